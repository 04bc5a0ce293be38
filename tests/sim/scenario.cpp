#include "tests/sim/scenario.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "assemblies/connection.hpp"
#include "tests/sim/random.hpp"

namespace servobus::sim {
namespace {

using Kind = Action::Kind;
using nlohmann::json;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::array<const char*, 21> kind_names{"open",           "close",        "run",           "idle",
                                                 "move",           "hold",         "relax",         "start_client",
                                                 "stop_client",    "faults",       "cut",           "reset_streams",
                                                 "crash_node",     "kill_drive",   "power_cycle",   "restart_drive",
                                                 "close_sessions", "hold_up_node", "hold_up_drive", "discover",
                                                 "forge"};
constexpr std::array<const char*, 3> way_names{"both", "to_drive", "to_node"};

// ------------------------------------------------------------------------------------------------------- drawing

/// A connection waits no longer than this, so that a run sees the end of what it has begun.
constexpr microseconds longest_timeout = seconds(30);

class Artist {
public:
    Artist(std::uint64_t seed, microseconds length) : random_(seed, 1) {
        scenario_.seed = seed;
        scenario_.length = length;
    }

    Scenario draw() {
        scenario_.nodes = 1 + random_.below(3);
        const auto drives = 1 + random_.below(3);
        for (unsigned i = 0; i < drives; ++i) scenario_.drives.push_back({random_.chance(0.5)});
        const auto connections = 1 + random_.below(3 * drives + 2);
        for (unsigned i = 0; i < connections; ++i) {
            scenario_.connections.push_back(connection(i < drives, i));
            if (random_.chance(0.3)) scenario_.connections.push_back(companion(scenario_.connections.back()));
        }
        const auto clients = random_.below(4);
        for (unsigned i = 0; i < clients; ++i) scenario_.clients.push_back(client());
        begin();
        happen();
        std::ranges::stable_sort(scenario_.actions, {}, &Action::at);
        return std::move(scenario_);
    }

private:
    unsigned any_node() { return random_.below(scenario_.nodes); }
    unsigned any_drive() { return random_.below(static_cast<unsigned>(scenario_.drives.size())); }
    unsigned any_connection() { return random_.below(static_cast<unsigned>(scenario_.connections.size())); }

    ConnectionSpec connection(bool owner, unsigned number) {
        constexpr std::array<unsigned, 10> intervals{1, 1, 2, 2, 4, 5, 8, 10, 20, 100};
        const auto all = assemblies::connections();
        const auto& kind = owner ? all[random_.below(5)] : random_.of(all);
        ConnectionSpec spec;
        spec.node = any_node();
        spec.drive = owner ? number : any_drive();
        spec.o_to_t_point = kind.o_to_t_point;
        spec.t_to_o_point = kind.t_to_o_point;
        spec.multicast = kind.kind == assemblies::Connection::Kind::listen_only || random_.chance(0.4);
        spec.large = random_.chance(0.3);
        spec.redundant = !owner && random_.chance(0.1);
        spec.o_to_t_rpi = milliseconds(random_.of(intervals));
        // Whoever joins a group has to ask for what the first has asked for: one interval for most of them.
        spec.t_to_o_rpi = spec.multicast && random_.chance(0.9) ? milliseconds(4) : milliseconds(random_.of(intervals));
        if (random_.chance(0.1)) spec.o_to_t_rpi += microseconds(random_.between(1, 999));
        do spec.multiplier = random_.below(8);
        while (std::max(spec.o_to_t_rpi, spec.t_to_o_rpi) * (4 << spec.multiplier) > longest_timeout);
        if (random_.chance(0.2)) {
            spec.trigger = 1 + random_.below(2);
            if (random_.chance(0.5)) {
                spec.inhibit =
                    milliseconds(random_.between(1, std::max<std::int64_t>(1, spec.t_to_o_rpi.count() / 1000)));
            }
        }
        return spec;
    }

    /// Somebody who looks on, and mostly wants what the other wants: joins its group, or listens to it.
    ConnectionSpec companion(const ConnectionSpec& other) {
        auto spec = other;
        spec.node = any_node();
        spec.o_to_t_point = random_.chance(0.5) ? assemblies::input_only_point : assemblies::listen_only_point;
        spec.o_to_t_rpi = milliseconds(random_.between(1, 50));
        spec.redundant = false;
        if (random_.chance(0.9)) return spec;
        spec.trigger = 0;
        spec.inhibit.reset();
        spec.t_to_o_rpi *= 2;
        return spec;
    }

    ClientSpec client() {
        return {.node = any_node(),
                .drive = any_drive(),
                .class3 = random_.chance(0.4),
                .pause = milliseconds(random_.chance(0.1) ? random_.between(5'000, 30'000) : random_.between(1, 400)),
                .burst = 1 + (random_.chance(0.3) ? random_.below(12) : 0)};
    }

    Faults any_faults() {
        Faults faults;
        faults.delay = microseconds(random_.between(10, random_.chance(0.2) ? 20'000 : 500));
        if (random_.chance(0.5)) faults.jitter = microseconds(random_.between(1, random_.chance(0.3) ? 30'000 : 1'000));
        if (random_.chance(0.5)) faults.loss = random_.chance(0.2) ? random_.unit() : random_.unit() * 0.2;
        if (random_.chance(0.4)) faults.duplicate = random_.unit() * 0.3;
        if (random_.chance(0.4)) faults.reorder = random_.unit() * 0.3;
        return faults;
    }
    microseconds any_duration(milliseconds longest) {
        return microseconds(random_.between(
            1'000, random_.chance(0.7) ? microseconds(longest).count() / 10 : microseconds(longest).count()));
    }

    void add(Action action) { scenario_.actions.push_back(action); }

    void begin() {
        for (unsigned i = 0; i < scenario_.connections.size(); ++i) {
            if (!random_.chance(0.8)) continue;
            const auto at = microseconds(random_.between(0, 2'000'000));
            add({.at = at, .kind = Kind::open, .subject = i});
            add({.at = at, .kind = Kind::run, .subject = i});
            add({.at = at, .kind = Kind::move, .subject = i});
        }
        for (unsigned i = 0; i < scenario_.clients.size(); ++i) {
            add({.at = microseconds(random_.between(0, 3'000'000)), .kind = Kind::start_client, .subject = i});
        }
    }

    /// One thing after the other, some seconds between them; more rarely in quiet scenarios.
    void happen() {
        const auto mean = random_.chance(0.2) ? seconds(5) : milliseconds(random_.between(100, 2'000));
        microseconds at = seconds(1);
        while (true) {
            at += microseconds(random_.between(1'000, 2 * microseconds(mean).count()));
            if (at >= scenario_.length) return;
            happen(at);
        }
    }

    void happen(microseconds at) {
        Action action{.at = at};
        const auto dice = random_.below(100);
        if (dice < 34) {
            action.kind = random_.of(std::array{Kind::open, Kind::open, Kind::open, Kind::close, Kind::run, Kind::run,
                                                Kind::idle, Kind::move, Kind::move, Kind::hold, Kind::relax});
            action.subject = any_connection();
        } else if (dice < 54) {
            action.kind = Kind::faults;
            line(action);
            if (random_.chance(0.6)) action.faults = any_faults();
        } else if (dice < 66) {
            action.kind = Kind::cut;
            line(action);
            action.duration = any_duration(seconds(15));
        } else if (dice < 72 && !scenario_.clients.empty()) {
            action.kind = random_.chance(0.6) ? Kind::start_client : Kind::stop_client;
            action.subject = random_.below(static_cast<unsigned>(scenario_.clients.size()));
            action.silent = random_.chance(0.3);
        } else if (dice < 76) {
            action.kind = Kind::reset_streams;
            line(action);
        } else if (dice < 82) {
            action.kind = Kind::crash_node;
            action.subject = any_node();
            action.silent = random_.chance(0.5);
            action.duration = any_duration(seconds(20));
        } else if (dice < 85) {
            action.kind = Kind::kill_drive;
            action.subject = any_drive();
            action.silent = random_.chance(0.5);
            action.duration = any_duration(seconds(20));
        } else if (dice < 88) {
            action.kind = random_.chance(0.5) ? Kind::power_cycle : Kind::restart_drive;
            action.subject = any_drive();
            if (action.kind == Kind::restart_drive) action.duration = any_duration(seconds(3));
        } else if (dice < 90) {
            action.kind = Kind::close_sessions;
            action.subject = any_drive();
        } else if (dice < 97) {
            action.kind = random_.chance(0.5) ? Kind::hold_up_node : Kind::hold_up_drive;
            action.subject = action.kind == Kind::hold_up_node ? any_node() : any_drive();
            action.duration = any_duration(seconds(2));
        } else {
            action.kind = random_.chance(0.5) ? Kind::discover : Kind::forge;
            action.subject = any_node();
            if (action.kind == Kind::forge) action.other = any_drive();
        }
        add(action);
    }

    void line(Action& action) {
        action.subject = any_node();
        action.other = any_drive();
        action.way =
            random_.of(std::array{Action::Way::both, Action::Way::both, Action::Way::to_drive, Action::Way::to_node});
    }

    Random random_;
    Scenario scenario_;
};

// ---------------------------------------------------------------------------------------------------------- JSON

std::int64_t count(microseconds time) { return time.count(); }

json written(const Faults& faults) {
    return {{"loss", faults.loss},
            {"duplicate", faults.duplicate},
            {"reorder", faults.reorder},
            {"delay", count(faults.delay)},
            {"jitter", count(faults.jitter)}};
}

Faults read_faults(const json& from) {
    return {.loss = from.at("loss"),
            .duplicate = from.at("duplicate"),
            .reorder = from.at("reorder"),
            .delay = microseconds(from.at("delay").get<std::int64_t>()),
            .jitter = microseconds(from.at("jitter").get<std::int64_t>())};
}

json written(const ConnectionSpec& spec) {
    json to{{"node", spec.node},
            {"drive", spec.drive},
            {"o_to_t_point", spec.o_to_t_point},
            {"t_to_o_point", spec.t_to_o_point},
            {"multicast", spec.multicast},
            {"large", spec.large},
            {"o_to_t_rpi", count(spec.o_to_t_rpi)},
            {"t_to_o_rpi", count(spec.t_to_o_rpi)},
            {"multiplier", spec.multiplier},
            {"trigger", spec.trigger}};
    if (spec.redundant) to["redundant"] = true;
    if (spec.inhibit) to["inhibit"] = count(*spec.inhibit);
    return to;
}

ConnectionSpec read_connection(const json& from) {
    ConnectionSpec spec{.node = from.at("node"),
                        .drive = from.at("drive"),
                        .o_to_t_point = from.at("o_to_t_point"),
                        .t_to_o_point = from.at("t_to_o_point"),
                        .multicast = from.at("multicast"),
                        .large = from.at("large"),
                        .o_to_t_rpi = microseconds(from.at("o_to_t_rpi").get<std::int64_t>()),
                        .t_to_o_rpi = microseconds(from.at("t_to_o_rpi").get<std::int64_t>()),
                        .multiplier = from.at("multiplier"),
                        .trigger = from.at("trigger")};
    spec.redundant = from.value("redundant", false);
    if (from.contains("inhibit")) spec.inhibit = microseconds(from.at("inhibit").get<std::int64_t>());
    return spec;
}

json written(const ClientSpec& spec) {
    return {{"node", spec.node},
            {"drive", spec.drive},
            {"class3", spec.class3},
            {"pause", count(spec.pause)},
            {"burst", spec.burst}};
}

ClientSpec read_client(const json& from) {
    return {.node = from.at("node"),
            .drive = from.at("drive"),
            .class3 = from.at("class3"),
            .pause = microseconds(from.at("pause").get<std::int64_t>()),
            .burst = from.at("burst")};
}

/// Only what is not as usual, so that a person can read it.
json written(const Action& action) {
    json to{{"at", count(action.at)}, {"do", name(action.kind)}, {"subject", action.subject}};
    if (action.other != 0) to["other"] = action.other;
    if (action.way != Action::Way::both) to["way"] = way_names[static_cast<std::size_t>(action.way)];
    if (action.silent) to["silent"] = true;
    if (action.duration.count() != 0) to["duration"] = count(action.duration);
    if (action.kind == Kind::faults) to["faults"] = written(action.faults);
    return to;
}

template <std::size_t size>
std::size_t place_of(const std::array<const char*, size>& names, const std::string& wanted) {
    const auto found =
        std::ranges::find(names, std::string_view(wanted), [](const char* each) { return std::string_view(each); });
    if (found == names.end()) throw json::other_error::create(501, "unknown word '" + wanted + "'", nullptr);
    return static_cast<std::size_t>(found - names.begin());
}

Action read_action(const json& from) {
    Action action;
    action.at = microseconds(from.at("at").get<std::int64_t>());
    action.kind = static_cast<Kind>(place_of(kind_names, from.at("do")));
    action.subject = from.at("subject");
    action.other = from.value("other", 0U);
    action.way = static_cast<Action::Way>(place_of(way_names, from.value("way", std::string("both"))));
    action.silent = from.value("silent", false);
    action.duration = microseconds(from.value("duration", std::int64_t{0}));
    if (from.contains("faults")) action.faults = read_faults(from.at("faults"));
    return action;
}

template <class List>
json list_of(const List& list) {
    auto to = json::array();
    for (const auto& each : list) to.push_back(written(each));
    return to;
}

/// Every number that names somebody names somebody who is there.
bool is_sound(const Scenario& scenario) {
    const auto drives = scenario.drives.size();
    const bool connections = std::ranges::all_of(scenario.connections, [&](const auto& each) {
        return each.node < scenario.nodes && each.drive < drives && each.multiplier < 8 && each.trigger < 3 &&
               assemblies::find_connection(each.o_to_t_point, each.t_to_o_point) != nullptr;
    });
    const bool clients = std::ranges::all_of(scenario.clients, [&](const auto& each) {
        return each.node < scenario.nodes && each.drive < drives && each.burst > 0 && each.pause.count() > 0;
    });
    const bool actions = std::ranges::all_of(scenario.actions, [&](const Action& each) {
        switch (each.kind) {
            case Kind::open:
            case Kind::close:
            case Kind::run:
            case Kind::idle:
            case Kind::move:
            case Kind::hold:
            case Kind::relax:
                return each.subject < scenario.connections.size();
            case Kind::start_client:
            case Kind::stop_client:
                return each.subject < scenario.clients.size();
            case Kind::faults:
            case Kind::cut:
            case Kind::reset_streams:
            case Kind::forge:
                return each.subject < scenario.nodes && each.other < drives;
            case Kind::crash_node:
            case Kind::hold_up_node:
            case Kind::discover:
                return each.subject < scenario.nodes;
            case Kind::kill_drive:
            case Kind::power_cycle:
            case Kind::restart_drive:
            case Kind::close_sessions:
            case Kind::hold_up_drive:
                return each.subject < drives;
        }
        return false;
    });
    return connections && clients && actions;
}

}  // namespace

Scenario draw(std::uint64_t seed, microseconds length) { return Artist(seed, length).draw(); }

std::string to_json(const Scenario& scenario) {
    auto drives = json::array();
    for (const auto& drive : scenario.drives) drives.push_back({{"jog", drive.jog}});
    // A line for each action: what a person reads and a comparison shows.
    std::string text = fmt::format("{{\"seed\": {},\n\"length\": {},\n\"nodes\": {},\n\"drives\": {},\n", scenario.seed,
                                   count(scenario.length), scenario.nodes, drives.dump());
    const auto lines = [&](const char* title, const json& list, const char* end) {
        text += fmt::format("\"{}\": [", title);
        for (std::size_t i = 0; i < list.size(); ++i) text += fmt::format("{}\n  {}", i > 0 ? "," : "", list[i].dump());
        text += end;
    };
    lines("connections", list_of(scenario.connections), "],\n");
    lines("clients", list_of(scenario.clients), "],\n");
    lines("actions", list_of(scenario.actions), "]}\n");
    return text;
}

std::optional<Scenario> from_json(const std::string& text, std::string& mistake) {
    try {
        const auto from = json::parse(text);
        Scenario scenario;
        scenario.seed = from.at("seed");
        scenario.length = microseconds(from.at("length").get<std::int64_t>());
        scenario.nodes = from.at("nodes");
        for (const auto& each : from.at("drives")) scenario.drives.push_back({each.at("jog")});
        for (const auto& each : from.at("connections")) scenario.connections.push_back(read_connection(each));
        for (const auto& each : from.at("clients")) scenario.clients.push_back(read_client(each));
        for (const auto& each : from.at("actions")) scenario.actions.push_back(read_action(each));
        std::ranges::stable_sort(scenario.actions, {}, &Action::at);
        if (is_sound(scenario)) return scenario;
        mistake = "a number names nobody who is there, or a value is out of its range";
    } catch (const json::exception& wrong) {
        mistake = wrong.what();
    }
    return std::nullopt;
}

const char* name(Kind kind) { return kind_names[static_cast<std::size_t>(kind)]; }

std::string describe(const Action& action) { return written(action).dump(); }

}  // namespace servobus::sim
