// The whole simulation: it repeats, it sees what is broken on purpose, and a failure shrinks and plays again.
#include "tests/sim/world.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cip/forward_open.hpp"
#include "cip/services.hpp"
#include "enip/messages.hpp"
#include "tests/sim/shrink.hpp"
#include "tests/support/octets.hpp"

namespace servobus::sim {
namespace {

using namespace std::chrono_literals;
using Kind = Action::Kind;

/// An owner that lets the axis of its drive move, at 4 ms.
Scenario one_owner() {
    Scenario scenario;
    scenario.seed = 1;
    scenario.length = 10s;
    scenario.drives.resize(1);
    scenario.connections.push_back({.o_to_t_rpi = 4ms, .t_to_o_rpi = 4ms});
    for (const auto kind : {Kind::open, Kind::run, Kind::move}) scenario.actions.push_back({.kind = kind});
    return scenario;
}

std::int64_t value(DriveSite& drive, drive::Key key) {
    auto& device = drive.adapter()->device();
    return std::get<std::int64_t>(device.store().value(*device.find(key)));
}
/// Something happens at the drive, so that it is looked at.
void nudge(DriveSite& drive) {
    const enip::Frame list{.command = enip::Command::list_identity};
    drive.on_packet({.source = {Neighbourhood::node_address(0), 40'000},
                     .destination = {Neighbourhood::drive_address(0), enip::tcp_port},
                     .octets = list.encode()});
}

/// The owner's connection ends, and nobody has heard why.
void forget_owner(adapter::Adapter& adapter, Time now) {
    const auto* owner = adapter.io().owner();
    if (owner == nullptr) return;
    cip::ForwardClose close;
    close.triad = owner->request.triad;
    const auto id = adapter.on_open({owner->originator.address, 1}, {}, now);
    ASSERT_TRUE(id);
    const auto say = [&](const enip::Frame& frame) {
        static_cast<void>(adapter.on_octets(*id, frame.encode(), now));
        return enip::Frame::parse(adapter.take_replies(*id)).value();
    };
    const auto registered = say({.command = enip::Command::register_session, .data = enip::RegisterSession{}.encode()});
    const cip::Request request{cip::service::forward_close, cip::Path::to(6, 1), close.encode()};
    static_cast<void>(say({.command = enip::Command::send_rr_data,
                           .session = registered.session,
                           .data = enip::SendData::unconnected(request.encode()).encode()}));
    adapter.on_closed(*id, now);
}
constexpr drive::Key control_word{0x66, 0x00};
constexpr drive::Key actual_position{0x66, 0x24};

std::string broken(const Outcome& outcome) {
    return outcome.violation ? std::string(law(outcome.violation->invariant).name) : "nothing";
}

TEST(World, RepeatsItself) {
    for (const std::uint64_t seed : {2U, 12U}) {
        const auto scenario = draw(seed, 5s);
        const auto first = World(scenario).run().statistics;
        const auto second = World(scenario).run().statistics;
        EXPECT_EQ(first.events, second.events);
        EXPECT_EQ(first.wire.lost, second.wire.lost);
        EXPECT_EQ(first.targets.taken, second.targets.taken);
        EXPECT_EQ(first.originators.io.inputs, second.originators.io.inputs);
        EXPECT_GT(first.events, 100U);
    }
}

// Otherwise there would be nothing to stop.
TEST(World, ItsOwnerMovesTheAxis) {
    World world(one_owner());
    std::int64_t lowest = 0;
    std::int64_t highest = 0;
    for (int i = 0; i < 100; ++i) {
        world.queue().after(i * 100ms, [&] {
            lowest = std::min(lowest, value(world.drive(0), actual_position));
            highest = std::max(highest, value(world.drive(0), actual_position));
        });
    }
    const auto outcome = world.run();
    EXPECT_EQ(broken(outcome), "nothing") << outcome.violation->what;
    EXPECT_GT(highest - lowest, 20'000);
    EXPECT_EQ(outcome.statistics.targets.timed_out, 0U);
    EXPECT_GT(outcome.statistics.targets.taken, 2'000U);
}

TEST(World, AnOwnerWhoIsLostInMotionIsNoted) {
    auto scenario = one_owner();
    for (int i = 1; i <= 4; ++i) scenario.actions.push_back({.at = i * 2s, .kind = Kind::cut, .duration = 500ms});
    const auto outcome = World(scenario).run();
    EXPECT_EQ(broken(outcome), "nothing") << outcome.violation->what;
    EXPECT_GT(outcome.statistics.targets.losses_in_motion, 0U);
}

// Each of them breaks the device or its surroundings behind the books' back.
TEST(World, SeesADriveThatMovesByItself) {
    auto scenario = one_owner();
    scenario.drives[0].jog = true;
    scenario.actions.push_back({.at = 3s, .kind = Kind::crash_node, .duration = 60s});
    World world(scenario);
    world.queue().after(5s, [&] {
        auto& device = world.drive(0).adapter()->device();
        for (const std::int64_t word : {0x0F, 0x1F}) ASSERT_FALSE(device.write(*device.find(control_word), word));
        nudge(world.drive(0));
    });
    EXPECT_EQ(broken(world.run()), "drive_stands_without_owner");
}

TEST(World, SeesAConnectionThatEndsTooEarly) {
    World world(one_owner());
    world.queue().after(3s, [&] { forget_owner(*world.drive(0).adapter(), world.queue().now()); });
    const auto outcome = world.run();
    EXPECT_EQ(broken(outcome), "target_timeout_early");
    EXPECT_EQ(outcome.last.size(), 3U);
    ASSERT_EQ(outcome.arrived.size(), 16U);
    EXPECT_THAT(outcome.arrived.back(),
                testing::MatchesRegex("[23]\\.[0-9]+ s, (node|drive) 0 to (drive|node) 0: id .*, number .*"));
}

TEST(World, SeesDataThatNobodyHasSent) {
    World world(one_owner());
    world.queue().after(3s, [&] {
        auto& device = world.drive(0).adapter()->device();
        ASSERT_FALSE(device.write(*device.find({0x66, 0x3A}), std::int64_t{-1}));
        nudge(world.drive(0));
    });
    EXPECT_EQ(broken(world.run()), "newest_data_is_in_force");
}

TEST(World, SeesWhatIsLeftBehind) {
    World world(one_owner());
    world.queue().after(209s, [&] {
        static_cast<void>(
            world.drive(0).adapter()->on_open({Neighbourhood::node_address(0), 1}, {}, world.queue().now()));
    });
    EXPECT_EQ(broken(world.run()), "nothing_left_behind");
}

// ---------------------------------------------------------------------------------------------------- shrinking

TEST(Shrink, KeepsWhatItTakes) {
    const auto is = [](Kind kind) { return [kind](const Action& each) { return each.kind == kind; }; };
    const Play play = [&](const Scenario& scenario) -> std::optional<Failure> {
        const auto crash = std::ranges::find_if(scenario.actions, is(Kind::crash_node));
        if (crash == scenario.actions.end()) return std::nullopt;
        const auto cut = std::find_if(crash, scenario.actions.end(), is(Kind::cut));
        if (cut == scenario.actions.end()) return std::nullopt;
        return Failure{Invariant::one_owner, cut->at + 1ms};
    };
    int shrunk = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const auto scenario = draw(seed, 300s);
        const auto failure = play(scenario);
        if (!failure) continue;
        ++shrunk;
        const auto small = shrink(scenario, *failure, play);
        EXPECT_EQ(small.scenario.actions.size(), 2U) << seed;
        EXPECT_TRUE(small.scenario.connections.empty() && small.scenario.clients.empty());
        EXPECT_EQ(small.scenario.drives.size(), 1U);
        EXPECT_LE(small.scenario.nodes, 2U) << "the one that crashes, and the one whose line is cut";
        EXPECT_EQ(small.scenario.length, small.failure.at);
        std::string mistake;
        EXPECT_TRUE(from_json(to_json(small.scenario), mistake)) << mistake;
    }
    EXPECT_GT(shrunk, 5);
}

TEST(Shrink, DoesNotTakeAnotherFailureForTheSame) {
    auto scenario = one_owner();
    const auto size = scenario.actions.size();
    const Play play = [&](const Scenario& smaller) {
        return Failure{smaller.actions.size() == size ? Invariant::one_owner : Invariant::in_order, 1s};
    };
    EXPECT_EQ(shrink(scenario, {Invariant::one_owner, 1s}, play).scenario.actions.size(), size);
}

TEST(Shrink, GivesUpAfterSoManyPlays) {
    std::size_t plays = 0;
    const Play play = [&](const Scenario&) -> std::optional<Failure> {
        ++plays;
        return std::nullopt;
    };
    static_cast<void>(shrink(draw(5, 600s), {Invariant::one_owner, 500s}, play, 20));
    EXPECT_LE(plays, 21U);
}

// The way of a real failure: seen in a large scenario, made small, written down, played again.
TEST(Shrink, AFailureOfTheWorldPlaysAgainFromItsText) {
    const Play play = [](const Scenario& scenario) -> std::optional<Failure> {
        World world(scenario);
        for (auto time = 0ms; time < 20s; time += 500ms) {
            world.queue().after(time, [&] {  // a device that forgets its owner
                auto* adapter = world.drive(0).adapter();
                if (adapter != nullptr) forget_owner(*adapter, world.queue().now());
            });
        }
        const auto outcome = world.run();
        if (!outcome.violation) return std::nullopt;
        return Failure{outcome.violation->invariant, outcome.failed_at};
    };
    Scenario scenario;
    std::optional<Failure> failure;
    for (std::uint64_t seed = 1; !failure && seed < 20; ++seed) {  // the first one that has an owner at drive 0
        scenario = draw(seed, 20s);
        failure = play(scenario);
    }
    ASSERT_TRUE(failure);
    ASSERT_EQ(failure->invariant, Invariant::target_timeout_early);
    const auto small = shrink(scenario, *failure, play);
    EXPECT_EQ(small.scenario.connections.size(), 1U);
    EXPECT_EQ(small.scenario.actions.size(), 1U) << to_json(small.scenario);
    EXPECT_EQ(small.scenario.actions[0].kind, Kind::open);
    std::string mistake;
    const auto again = from_json(to_json(small.scenario), mistake);
    ASSERT_TRUE(again) << mistake;
    const auto once_more = play(*again);
    ASSERT_TRUE(once_more);
    EXPECT_EQ(once_more->invariant, Invariant::target_timeout_early);
    EXPECT_EQ(once_more->at, small.failure.at);
}

}  // namespace
}  // namespace servobus::sim
