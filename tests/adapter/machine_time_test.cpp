// The adapter and the time of its machine: when it is stepped, when it is left alone, and when events reach it.
#include <gtest/gtest.h>

#include "adapter/timetable.hpp"
#include "tests/adapter/fake_machine.hpp"
#include "tests/adapter/peers.hpp"

namespace servobus::test {
namespace {

namespace event = drive::event;
using testing::ElementsAre;
using testing::IsEmpty;

drive::Time drive_time(enip::Time now) { return std::chrono::floor<drive::Time>(now.time_since_epoch()); }

struct MachineSite : Site {
    explicit MachineSite(adapter::Limits limits = {}) : Site(limits, device_with_fake_machine()) {}
};

TEST(MachineTime, IsTheServersInWholeMicroseconds) {
    MachineSite site;
    site.now = enip::Time(1h + 1500ns);
    site.adapter.on_timer(site.now);
    EXPECT_THAT(fake_machine().steps, ElementsAre(drive::Time(1h) + 1us));
}

TEST(MachineTime, ADriveAtRestHasNoDeadline) {
    MachineSite site;
    site.adapter.on_timer(site.now);
    EXPECT_EQ(site.adapter.next_deadline(), std::nullopt);
}

TEST(MachineTime, ADriveThatMovesIsSteppedWhenItWants) {
    MachineSite site;
    const auto start = drive_time(site.now);
    fake_machine().deadline = start + 1ms;
    EXPECT_EQ(site.adapter.next_deadline(), site.now + 1ms);
    fake_machine().on_step = [](drive::Time now) -> std::optional<drive::Time> {
        return now < drive::Time(1h) + 3ms ? std::optional(now + 1ms) : std::nullopt;
    };
    site.advance(10s);
    EXPECT_THAT(fake_machine().steps, ElementsAre(start + 1ms, start + 2ms, start + 3ms));
    EXPECT_EQ(site.adapter.next_deadline(), std::nullopt);
}

TEST(MachineTime, AnHourAtRestIsOneStep) {
    MachineSite site;
    site.adapter.on_timer(site.now);
    site.advance(1h);
    ASSERT_EQ(fake_machine().steps.size(), 1U);
    site.adapter.on_timer(site.now);
    EXPECT_THAT(fake_machine().steps, ElementsAre(drive::Time(1h), drive::Time(2h)));
}

TEST(MachineTime, TheDriveIsBroughtToNowBeforeARequestIsAnswered) {
    MachineSite site;
    auto peer = registered(site);
    site.now += 250us;
    peer.call("10 03 20 64 24 01 30 00 32 00 00 00");
    EXPECT_EQ(fake_machine().steps.back(), drive_time(site.now));
    EXPECT_THAT(fake_machine().rows, ElementsAre(drive::Key{0x64, 0x00}));
}

TEST(MachineTime, ConnectionsAndMachineShareTheNextDeadline) {
    MachineSite site;
    const Peer peer(site);
    EXPECT_EQ(site.adapter.next_deadline(), site.now + 120s);
    fake_machine().deadline = drive_time(site.now) + 1ms;
    EXPECT_EQ(site.adapter.next_deadline(), site.now + 1ms);
}

adapter::Timetable timetable(std::vector<adapter::Timetable::Entry> entries,
                             std::optional<drive::Time> repeat_every = std::nullopt) {
    return {std::move(entries), repeat_every};
}

TEST(PlayedEvents, HappenAtTheirTimesFromTheFirstNowOn) {
    MachineSite site;
    site.adapter.play(timetable({{1s, event::RemoveObstacle{}}, {2500ms, event::CutPowerStage{}}}));
    EXPECT_EQ(site.adapter.next_deadline(), std::nullopt) << "the clock has not started";
    const auto start = drive_time(site.now);
    site.adapter.on_timer(site.now);
    EXPECT_EQ(site.adapter.next_deadline(), site.now + 1s);
    site.advance(10s);
    ASSERT_EQ(fake_machine().events.size(), 2U);
    EXPECT_TRUE(std::holds_alternative<event::RemoveObstacle>(fake_machine().events[0]));
    EXPECT_TRUE(std::holds_alternative<event::CutPowerStage>(fake_machine().events[1]));
    EXPECT_THAT(fake_machine().event_times, ElementsAre(start + 1s, start + 2500ms));
    EXPECT_THAT(site.log, ElementsAre("event: remove-obstacle", "event: cut-power-stage"));
    EXPECT_EQ(site.adapter.next_deadline(), std::nullopt);
    EXPECT_EQ(site.adapter.elapsed(site.now), drive::Time(10s));
}

TEST(PlayedEvents, MeetTheDriveAtTheirOwnTimeHoweverLateTheTimerIs) {
    MachineSite site;
    site.adapter.play(timetable({{1s, event::BlockAxis{true}}, {2s, event::BlockAxis{false}}}));
    const auto start = drive_time(site.now);
    site.adapter.on_timer(site.now);
    site.adapter.on_timer(site.now + 5s);
    EXPECT_THAT(fake_machine().event_times, ElementsAre(start + 1s, start + 2s));
    EXPECT_THAT(fake_machine().steps, ElementsAre(start, start + 1s, start + 2s, start + 5s));
}

TEST(PlayedEvents, ARequestAfterThemFindsThemDone) {
    MachineSite site;
    site.adapter.play(timetable({{1s, event::BlockAxis{}}}));
    auto peer = registered(site);
    site.now += 1s;
    peer.call("0E 03 20 64 24 01 30 00");
    EXPECT_EQ(fake_machine().events.size(), 1U);
}

TEST(PlayedEvents, StartAgainWhenTheyRepeat) {
    MachineSite site;
    site.adapter.play(timetable({{0s, event::BlockAxis{true}}, {1s, event::BlockAxis{false}}}, 3s));
    const auto start = drive_time(site.now);
    site.adapter.on_timer(site.now);
    site.advance(6s);
    EXPECT_THAT(fake_machine().event_times, ElementsAre(start, start + 1s, start + 3s, start + 4s, start + 6s));
    EXPECT_EQ(site.adapter.next_deadline(), site.now + 1s);
}

TEST(PlayedEvents, RepetitionsThatNobodyWasThereForAreLeftOut) {
    MachineSite site;
    site.adapter.play(timetable({{0s, event::BlockAxis{true}}, {1s, event::BlockAxis{false}}}, 3s));
    const auto start = drive_time(site.now);
    site.adapter.on_timer(site.now);
    site.adapter.on_timer(site.now + 3601s);
    EXPECT_THAT(fake_machine().event_times, ElementsAre(start, start + 1s, start + 3600s, start + 3601s));
}

TEST(PlayedEvents, InjectedOnesComeAfterAStepToNow) {
    MachineSite site;
    site.adapter.on_timer(site.now);
    site.now += 7ms;
    site.adapter.inject(event::SetInput{.number = 3, .high = false}, site.now);
    EXPECT_THAT(fake_machine().event_times, ElementsAre(drive_time(site.now)));
    EXPECT_THAT(site.log, ElementsAre("event: set-input number=3 high=false"));
}

TEST(PowerCycle, EndsAllConnectionsAndPowersTheMachineUp) {
    MachineSite site;
    auto peer = registered(site);
    const Peer other(site);
    const int power_ups = fake_machine().power_ups;
    site.adapter.inject(event::PowerCycle{}, site.now);
    EXPECT_EQ(fake_machine().power_ups, power_ups + 1);
    EXPECT_FALSE(peer.open());
    EXPECT_FALSE(other.open());
    EXPECT_THAT(site.adapter.take_expired(), ElementsAre(peer.id(), other.id()));
    auto next = registered(site);
    EXPECT_EQ(next.call("0E 03 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00"));
}

TEST(PowerCycle, ThatFallsBetweenTheOctetsOfARequestEndsThatToo) {
    MachineSite site;
    site.adapter.play(timetable({{1s, event::PowerCycle{}}}));
    auto peer = registered(site);
    site.now += 1s;
    EXPECT_EQ(peer.send(frame("04 00")), "");
    EXPECT_FALSE(peer.open());
}

TEST(PowerCycle, FulfilsAResetThatWasAskedFor) {
    MachineSite site;
    auto peer = registered(site);
    EXPECT_EQ(peer.call("05 02 20 01 24 01 00"), hex("85 00 00 00"));
    site.adapter.inject(event::PowerCycle{}, site.now);
    const int power_ups = fake_machine().power_ups;
    site.advance(1s);
    EXPECT_EQ(fake_machine().power_ups, power_ups);
}

TEST(MachineTime, AResetPowersTheMachineUpAndTheTimetableGoesOn) {
    MachineSite site;
    site.adapter.play(timetable({{1s, event::BlockAxis{}}}));
    auto peer = registered(site);
    const int power_ups = fake_machine().power_ups;
    EXPECT_EQ(peer.call("05 02 20 01 24 01 00"), hex("85 00 00 00"));
    site.advance(500ms);
    EXPECT_EQ(fake_machine().power_ups, power_ups + 1);
    EXPECT_THAT(fake_machine().events, IsEmpty());
    site.advance(500ms);
    EXPECT_EQ(fake_machine().events.size(), 1U);
}

}  // namespace
}  // namespace servobus::test
