#include "tests/sim/world.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace servobus::sim {
namespace {

using namespace std::chrono_literals;
using Kind = Action::Kind;

/// What is told of what was done before a violation.
constexpr std::size_t told_actions = 12;
/// Longer than all times that could still run: 120 s of an idle TCP connection, and what a connection of class 1 waits.
constexpr auto farewell = 200s;

}  // namespace

World::World(const Scenario& scenario) : scenario_(scenario), began_(queue_.now()), wire_(queue_, scenario_) {
    for (unsigned i = 0; i < scenario_.drives.size(); ++i) {
        drives_.push_back(
            std::make_unique<DriveSite>(i, scenario_.drives[i], scenario_.seed, queue_, wire_, neighbourhood_, judge_));
        wire_.attach(End::drive, i, *drives_.back());
    }
    for (unsigned i = 0; i < scenario_.nodes; ++i) {
        nodes_.push_back(std::make_unique<NodeSite>(i, scenario_, queue_, wire_, neighbourhood_, judge_));
        wire_.attach(End::node, i, *nodes_.back());
    }
}

bool World::run_until(Time end) {
    while (!queue_.empty() && queue_.next() <= end) {
        queue_.run_next();
        if (judge_.violation()) return false;
    }
    return true;
}

Outcome World::run(const std::function<void(const std::string&)>& trace) {
    trace_ = trace;
    for (const auto& action : scenario_.actions) {
        if (action.at > scenario_.length) continue;
        queue_.at(began_ + action.at, [this, &action] { perform(action); });
    }
    if (run_until(began_ + scenario_.length)) {
        leave();
        if (run_until(began_ + scenario_.length + farewell)) look_around();
    }
    Outcome outcome{.violation = judge_.violation(),
                    .failed_at = {},
                    .last = {last_.begin(), last_.end()},
                    .arrived = wire_.last_arrivals(began_),
                    .statistics = statistics()};
    if (outcome.violation) {
        outcome.failed_at = std::chrono::duration_cast<std::chrono::microseconds>(outcome.violation->at - began_);
    }
    return outcome;
}

void World::perform(const Action& action) {
    auto line = describe(action);
    if (trace_) trace_(line);
    last_.push_back(std::move(line));
    if (last_.size() > told_actions) last_.pop_front();
    const auto node_of = [&]() -> NodeSite& { return *nodes_[scenario_.connections[action.subject].node]; };
    const auto client_of = [&]() -> NodeSite& { return *nodes_[scenario_.clients[action.subject].node]; };
    switch (action.kind) {
        case Kind::open:
            return node_of().open(action.subject);
        case Kind::close:
            return node_of().close(action.subject);
        case Kind::run:
        case Kind::idle:
            return node_of().run(action.subject, action.kind == Kind::run);
        case Kind::move:
            return node_of().want(action.subject, MotionProgram::Goal::move);
        case Kind::hold:
            return node_of().want(action.subject, MotionProgram::Goal::hold);
        case Kind::relax:
            return node_of().want(action.subject, MotionProgram::Goal::relax);
        case Kind::start_client:
            return client_of().start_client(action.subject);
        case Kind::stop_client:
            return client_of().stop_client(action.subject, action.silent);
        case Kind::faults:
            return wire_.set_faults(action.subject, action.other, action.way, action.faults);
        case Kind::cut:
            return wire_.cut(action.subject, action.other, action.way, queue_.now() + action.duration);
        case Kind::reset_streams:
            return wire_.reset_streams(action.subject, action.other);
        case Kind::crash_node:
            return nodes_[action.subject]->crash(action.duration, action.silent);
        case Kind::kill_drive:
            return drives_[action.subject]->kill(action.duration, action.silent);
        case Kind::power_cycle:
            return drives_[action.subject]->power_cycle();
        case Kind::restart_drive:
            return drives_[action.subject]->restart(action.duration);
        case Kind::close_sessions:
            return drives_[action.subject]->close_sessions();
        case Kind::hold_up_node:
            return nodes_[action.subject]->hold_up(action.duration);
        case Kind::hold_up_drive:
            return drives_[action.subject]->hold_up(action.duration);
        case Kind::discover:
            return nodes_[action.subject]->discover();
        case Kind::forge:
            return forge(action.subject, action.other);
    }
}

/// Newer than everything, of the right size, and from an address that has no such connection (R-IO-7).
void World::forge(unsigned node, unsigned drive) {
    const auto* adapter = drives_[drive]->adapter();
    if (adapter == nullptr) return;
    for (const auto& connection : adapter->io().all()) {
        if (connection->originator.address == Neighbourhood::node_address(node)) continue;
        constexpr std::uint32_t ahead = 1'000'000;
        cip::Bytes octets(enip::io_packet_overhead + connection->request.o_to_t.size, 0x55);
        static_cast<void>(enip::begin_io_packet(octets, connection->o_to_t_id, ahead));
        wire_.send(node, drive, End::drive, {Neighbourhood::node_address(node), enip::io_port},
                   {Neighbourhood::drive_address(drive), enip::io_port}, octets);
    }
}

/// The lines are whole again, and everybody goes; whoever is away does so when he is back.
void World::leave() {
    wire_.heal();
    for (unsigned i = 0; i < scenario_.connections.size(); ++i) nodes_[scenario_.connections[i].node]->close(i);
    for (unsigned i = 0; i < scenario_.clients.size(); ++i) nodes_[scenario_.clients[i].node]->stop_client(i, false);
}

void World::look_around() {
    for (const auto& drive : drives_) drive->expect_nothing();
    for (const auto& node : nodes_) node->expect_nothing();
    const auto now = queue_.now();
    if (wire_.streams() != 0) {
        judge_.report(Invariant::nothing_left_behind, now,
                      fmt::format("{} TCP connections{}", wire_.streams(), wire_.describe_streams()));
    }
    if (neighbourhood_.groups() != 0) {
        judge_.report(Invariant::nothing_left_behind, now,
                      fmt::format("{} groups that somebody listens to", neighbourhood_.groups()));
    }
}

Statistics World::statistics() const {
    Statistics sum{.events = queue_.done(),
                   .wire = wire_.counters(),
                   .targets = {},
                   .originators = {},
                   .simulated = queue_.now() - began_};
    for (const auto& drive : drives_) {
        const auto& more = drive->watch().counters();
        sum.targets.owners += more.owners;
        sum.targets.onlookers += more.onlookers;
        sum.targets.listeners += more.listeners;
        sum.targets.class3 += more.class3;
        sum.targets.refused += more.refused;
        sum.targets.closed += more.closed;
        sum.targets.timed_out += more.timed_out;
        sum.targets.taken += more.taken;
        sum.targets.stale += more.stale;
        sum.targets.foreign += more.foreign;
        sum.targets.answers += more.answers;
        sum.targets.losses_in_motion += more.losses_in_motion;
    }
    for (const auto& node : nodes_) {
        const auto more = node->counters();
        sum.originators.io.opened += more.io.opened;
        sum.originators.io.timed_out += more.io.timed_out;
        sum.originators.io.inputs += more.io.inputs;
        sum.originators.io.dropped += more.io.dropped;
        SessionClient::add(sum.originators.requests, more.requests);
        sum.originators.discovered += more.discovered;
    }
    return sum;
}

}  // namespace servobus::sim
