#include "tests/sim/shrink.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace servobus::sim {
namespace {

using Kind = Action::Kind;

bool is_of_connection(Kind kind) { return kind <= Kind::relax; }
bool is_of_client(Kind kind) { return kind == Kind::start_client || kind == Kind::stop_client; }
bool is_of_line(Kind kind) {
    return kind == Kind::faults || kind == Kind::cut || kind == Kind::reset_streams || kind == Kind::forge;
}
bool is_of_node(Kind kind) {
    return kind == Kind::crash_node || kind == Kind::hold_up_node || kind == Kind::discover || is_of_line(kind);
}
bool is_of_drive(Kind kind) {
    return kind == Kind::kill_drive || kind == Kind::power_cycle || kind == Kind::restart_drive ||
           kind == Kind::close_sessions || kind == Kind::hold_up_drive;
}

/// Takes number `gone` out of a count, and what stands behind it one down.
void move_up(unsigned& number, unsigned gone) {
    if (number > gone) --number;
}

Scenario without_connection(Scenario scenario, unsigned gone) {
    scenario.connections.erase(scenario.connections.begin() + gone);
    std::erase_if(scenario.actions,
                  [&](const Action& each) { return is_of_connection(each.kind) && each.subject == gone; });
    for (auto& each : scenario.actions) {
        if (is_of_connection(each.kind)) move_up(each.subject, gone);
    }
    return scenario;
}

Scenario without_client(Scenario scenario, unsigned gone) {
    scenario.clients.erase(scenario.clients.begin() + gone);
    std::erase_if(scenario.actions,
                  [&](const Action& each) { return is_of_client(each.kind) && each.subject == gone; });
    for (auto& each : scenario.actions) {
        if (is_of_client(each.kind)) move_up(each.subject, gone);
    }
    return scenario;
}

template <class Belongs>
Scenario without_those(Scenario scenario, Belongs belongs) {
    for (auto i = static_cast<unsigned>(scenario.connections.size()); i-- > 0;) {
        if (belongs(scenario.connections[i].node, scenario.connections[i].drive))
            scenario = without_connection(std::move(scenario), i);
    }
    for (auto i = static_cast<unsigned>(scenario.clients.size()); i-- > 0;) {
        if (belongs(scenario.clients[i].node, scenario.clients[i].drive))
            scenario = without_client(std::move(scenario), i);
    }
    return scenario;
}

Scenario without_drive(Scenario scenario, unsigned gone) {
    scenario = without_those(std::move(scenario), [&](unsigned, unsigned drive) { return drive == gone; });
    scenario.drives.erase(scenario.drives.begin() + gone);
    std::erase_if(scenario.actions, [&](const Action& each) {
        return (is_of_drive(each.kind) && each.subject == gone) || (is_of_line(each.kind) && each.other == gone);
    });
    for (auto& each : scenario.actions) {
        if (is_of_drive(each.kind)) move_up(each.subject, gone);
        if (is_of_line(each.kind)) move_up(each.other, gone);
    }
    for (auto& each : scenario.connections) move_up(each.drive, gone);
    for (auto& each : scenario.clients) move_up(each.drive, gone);
    return scenario;
}

Scenario without_node(Scenario scenario, unsigned gone) {
    scenario = without_those(std::move(scenario), [&](unsigned node, unsigned) { return node == gone; });
    --scenario.nodes;
    std::erase_if(scenario.actions, [&](const Action& each) { return is_of_node(each.kind) && each.subject == gone; });
    for (auto& each : scenario.actions) {
        if (is_of_node(each.kind)) move_up(each.subject, gone);
    }
    for (auto& each : scenario.connections) move_up(each.node, gone);
    for (auto& each : scenario.clients) move_up(each.node, gone);
    return scenario;
}

class Shrinker {
public:
    Shrinker(Scenario scenario, Failure failure, const Play& play, std::size_t most_plays)
        : best_{std::move(scenario), failure, 0}, play_(play), most_plays_(most_plays) {}

    Shrunk run() {
        stop_at_the_failure();
        auto before = best_.scenario;
        do {
            before = best_.scenario;
            drop_people();
            drop_actions();
            calm_down();
        } while (best_.scenario != before && best_.plays < most_plays_);
        return best_;
    }

private:
    /// Takes it when it fails for the same reason.
    bool offer(const Scenario& smaller) {
        if (best_.plays >= most_plays_ || smaller == best_.scenario) return false;
        ++best_.plays;
        const auto failure = play_(smaller);
        if (!failure || failure->invariant != best_.failure.invariant) return false;
        best_.scenario = smaller;
        best_.failure = *failure;
        stop_at_the_failure();
        return true;
    }

    /// What would have come later changes nothing; that everybody leaves might.
    void stop_at_the_failure() {
        auto& scenario = best_.scenario;
        if (best_.failure.at >= scenario.length) return;
        auto shorter = scenario;
        shorter.length = best_.failure.at;
        std::erase_if(shorter.actions, [&](const Action& each) { return each.at > shorter.length; });
        ++best_.plays;
        const auto failure = play_(shorter);
        if (!failure || failure->invariant != best_.failure.invariant) return;
        scenario = std::move(shorter);
        best_.failure = *failure;
    }

    void drop_people() {
        const auto drop_each = [&](auto count, auto without) {
            for (auto i = static_cast<unsigned>(count(best_.scenario)); i-- > 0;) {
                if (i < count(best_.scenario)) offer(without(best_.scenario, i));
            }
        };
        if (best_.scenario.drives.size() > 1) {
            drop_each([](const Scenario& each) { return each.drives.size() > 1 ? each.drives.size() : 0; },
                      without_drive);
        }
        drop_each([](const Scenario& each) { return each.nodes > 1 ? each.nodes : 0; }, without_node);
        drop_each([](const Scenario& each) { return each.connections.size(); }, without_connection);
        drop_each([](const Scenario& each) { return each.clients.size(); }, without_client);
    }

    /// Half of them, then a quarter, and so on down to each.
    void drop_actions() {
        for (auto part = std::max<std::size_t>(1, best_.scenario.actions.size() / 2);; part /= 2) {
            for (std::size_t begin = 0; begin < best_.scenario.actions.size();) {
                auto smaller = best_.scenario;
                const auto first = smaller.actions.begin() + static_cast<std::ptrdiff_t>(begin);
                const auto count = std::min(part, smaller.actions.size() - begin);
                smaller.actions.erase(first, first + static_cast<std::ptrdiff_t>(count));
                if (!offer(smaller)) begin += part;
            }
            if (part <= 1) return;
        }
    }

    void change(std::size_t place, void (*how)(Action&)) {
        if (place >= best_.scenario.actions.size()) return;
        auto other = best_.scenario;
        how(other.actions[place]);
        offer(other);
    }

    void calm_down() {
        for (std::size_t i = 0; i < best_.scenario.actions.size(); ++i) {
            if (best_.scenario.actions[i].kind != Kind::faults) continue;
            change(i, [](Action& each) { each.faults.loss = 0; });
            change(i, [](Action& each) { each.faults.duplicate = 0; });
            change(i, [](Action& each) { each.faults.reorder = 0; });
            change(i, [](Action& each) { each.faults.jitter = microseconds(0); });
            change(i, [](Action& each) { each.faults.delay = Faults{}.delay; });
        }
    }

    Shrunk best_;
    const Play& play_;
    std::size_t most_plays_;
};

}  // namespace

Shrunk shrink(Scenario scenario, Failure failure, const Play& play, std::size_t most_plays) {
    return Shrinker(std::move(scenario), failure, play, most_plays).run();
}

}  // namespace servobus::sim
