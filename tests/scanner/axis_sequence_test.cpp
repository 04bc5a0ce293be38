// The documented sequences, as writes and looks, against a drive without mechanics.
#include "scanner/axis_sequence.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scanner/fake_axis.hpp"

namespace servobus::scanner {
namespace {

using namespace std::chrono_literals;
using enum AxisValue;
using test::FakeAxis;
using testing::ElementsAre;
using testing::HasSubstr;
using Writes = std::vector<AxisWrite>;

/// Runs a sequence to its end, 10 ms from look to look.
AxisSequence run(FakeAxis& axis, AxisSteps steps) {
    AxisSequence sequence(std::move(steps));
    Time now{0};
    for (int i = 0; i < 100'000 && sequence.wants() != AxisSequence::Wants::nothing; ++i) {
        if (sequence.wants() == AxisSequence::Wants::write) {
            axis.write(sequence.next_write());
            sequence.written(now);
        } else {
            now += 10ms;
            axis.look();
            sequence.saw(axis.state, now);
        }
    }
    EXPECT_EQ(sequence.wants(), AxisSequence::Wants::nothing);
    return sequence;
}

Writes writes_of(FakeAxis& axis, AxisSteps steps) {
    const auto sequence = run(axis, std::move(steps));
    EXPECT_FALSE(sequence.failed()) << sequence.failure_text(axis.state);
    return axis.writes;
}

TEST(AxisSequence, EnablesInThreeSteps) {
    FakeAxis axis;
    EXPECT_EQ(writes_of(axis, enable_steps(axis.state)),
              (Writes{{control_word, 0x06}, {control_word, 0x07}, {control_word, 0x0F}}));
    axis.writes.clear();
    EXPECT_EQ(writes_of(axis, enable_steps(axis.state)), (Writes{{control_word, 0x0F}})) << "power stays on";
    axis.writes.clear();
    EXPECT_EQ(writes_of(axis, disable_steps(axis.state)), (Writes{{control_word, 0x07}, {control_word, 0x06}}));
}

TEST(AxisSequence, LeavesAQuickStopThroughSwitchOnDisabled) {
    FakeAxis axis;
    axis.make_ready();
    EXPECT_EQ(writes_of(axis, quick_stop_steps(axis.state)), (Writes{{control_word, 0x02}}));
    EXPECT_EQ(state_text(axis.state), "Quick stop active");
    writes_of(axis, enable_steps(axis.state));
    EXPECT_THAT(axis.control_words(), ElementsAre(0x02, 0x00, 0x06, 0x07, 0x0F));
}

TEST(AxisSequence, References) {
    FakeAxis axis;
    EXPECT_EQ(writes_of(axis, reference_steps(axis.state, {.method = 2}, 5s)), (Writes{{mode_requested, 6},
                                                                                       {reference_method, 2},
                                                                                       {control_word, 0x06},
                                                                                       {control_word, 0x07},
                                                                                       {control_word, 0x0F},
                                                                                       {control_word, 0x1F},
                                                                                       {mode_requested, 1},
                                                                                       {control_word, 0x0F}}));
    EXPECT_TRUE(axis.state.is_referenced());
}

TEST(AxisSequence, ReferencesARotativeMotorAtTheGivenSpeeds) {
    FakeAxis axis;
    const AxisReference reference{.method = 10, .sensor_speed = 2000, .z_mark_speed = 0};
    const auto writes = writes_of(axis, reference_steps(axis.state, reference, 5s));
    ASSERT_GE(writes.size(), 4U);
    EXPECT_EQ((Writes{writes.begin() + 1, writes.begin() + 4}),
              (Writes{{reference_method, 10}, {sensor_speed, 2000}, {z_mark_speed, 0}}));
}

TEST(AxisSequence, WaitsForAReferenceAsLongAsItsSpeedsNeed) {
    FakeAxis axis;
    axis.set(encoder_increments, 60'000);
    axis.set(sensor_speed, 1'000);
    axis.set(z_mark_speed, 500);
    EXPECT_EQ(reference_limit(axis.state, {.method = 10}), 60s + 150s + 180s);
    EXPECT_EQ(reference_limit(axis.state, {.method = 10, .sensor_speed = 0, .z_mark_speed = 9'000}), 60s + 10s);
}

TEST(AxisSequence, TellsAReferenceError) {
    FakeAxis axis;
    axis.in_motion = [](FakeAxis& self) { self.set(status_word, 0x2237); };
    const auto sequence = run(axis, reference_steps(axis.state, {.method = 1}, 5s));
    EXPECT_EQ(sequence.failure_text(axis.state),
              "the drive tells a reference error; the drive is in 'Operation enabled'");
}

TEST(AxisSequence, MovesAbsoluteAndRelative) {
    FakeAxis axis;
    axis.make_ready();
    EXPECT_EQ(writes_of(axis, move_steps({.position = 9000}, 5s)),
              (Writes{{mode_requested, 1}, {control_word, 0x0F}, {target, 9000}, {control_word, 0x1F}}));
    EXPECT_EQ(axis.state.number(position), 9000);
    axis.writes.clear();
    const AxisMove move{.position = -500,
                        .relative = true,
                        .speed = 1,
                        .acceleration = 2,
                        .s_curve = 3,
                        .window = 4,
                        .following_window = 5};
    EXPECT_EQ(writes_of(axis, move_steps(move, 5s)), (Writes{{mode_requested, 1},
                                                             {control_word, 0x0F},
                                                             {s_curve, 3},
                                                             {acceleration, 2},
                                                             {speed, 1},
                                                             {following_window, 5},
                                                             {target_window, 4},
                                                             {target, -500},
                                                             {control_word, 0x5F}}));
    EXPECT_EQ(axis.state.number(position), 8500);
}

TEST(AxisSequence, JogsAndHalts) {
    FakeAxis axis;
    axis.make_ready();
    EXPECT_EQ(
        writes_of(axis, jog_steps({.positive = false, .speed = 700, .duration = 100ms}, axis.state)),
        (Writes{
            {mode_requested, -1}, {control_word, 0x0F}, {speed, 700}, {control_word, 0x1F}, {control_word, 0x11F}}));
    EXPECT_LT(axis.state.number(position), 1000);
    axis.writes.clear();
    writes_of(axis, jog_steps({.positive = true, .speed = 700, .acceleration = 5000, .duration = 1s}, axis.state));
    EXPECT_THAT(axis.control_words(), ElementsAre(0x0F, 0x5F, 0x11F));
}

TEST(AxisSequence, HaltsByTheModeItFinds) {
    const auto halted = [](int mode, std::int64_t word) {
        FakeAxis axis;
        axis.make_ready();
        axis.set(AxisValue::mode, mode);
        axis.set(control_word, word);
        return writes_of(axis, halt_steps(axis.state));
    };
    EXPECT_EQ(halted(1, 0x5F), (Writes{{control_word, 0x15F}}));
    EXPECT_EQ(halted(-1, 0x5F), (Writes{{control_word, 0x11F}})) << "printed for both directions";
    EXPECT_EQ(halted(6, 0x1F), (Writes{{control_word, 0x11F}}));
    EXPECT_EQ(halted(0, 0x0F), (Writes{{direct_command, 0x3040}}));
}

TEST(AxisSequence, ResetsAFault) {
    FakeAxis axis;
    axis.fail_with(50, "following error");
    EXPECT_EQ(writes_of(axis, fault_reset_steps()),
              (Writes{{control_word, 0}, {control_word, 0x80}, {control_word, 0}}));
    EXPECT_FALSE(axis.state.has_fault());
}

TEST(AxisSequence, CalibratesForce) {
    FakeAxis axis;
    axis.make_ready();
    EXPECT_EQ(writes_of(axis, force_calibration_steps({.start = 200, .way = 3000}, 5s)),
              (Writes{{mode_requested, 0},
                      {calibration_start, 200},
                      {direct_command, 0x3000},
                      {calibration_way, 3000},
                      {direct_command, 0x4000},
                      {mode_requested, 1}}));
    axis.writes.clear();
    EXPECT_EQ(writes_of(axis, force_calibration_steps({.way = 3000}, 5s)).size(), 4U);
}

TEST(AxisSequence, SaysWhatItWaitedFor) {
    FakeAxis axis;
    axis.make_ready();
    axis.motion = 1'000'000;
    const auto sequence = run(axis, move_steps({.position = 9000}, 2500ms));
    EXPECT_EQ(sequence.failure_text(axis.state),
              "waited 2.5 s for the target position; the drive is in 'Operation enabled'");
}

TEST(AxisSequence, EndsWithAFault) {
    FakeAxis axis;
    axis.make_ready();
    axis.in_motion = [](FakeAxis& self) { self.fail_with(50, "following error"); };
    const auto sequence = run(axis, move_steps({.position = 9000}, 2s));
    EXPECT_EQ(sequence.failure_text(axis.state), "the drive is in 'Fault' with error 50: following error");
}

TEST(AxisSequence, EndsWhenThePowerGoes) {
    FakeAxis axis;
    axis.make_ready();
    axis.in_motion = [](FakeAxis& self) { self.set(status_word, 0x0250); };
    const auto sequence = run(axis, move_steps({.position = 9000}, 2s));
    EXPECT_EQ(sequence.failure_text(axis.state),
              "the drive has left 'Operation enabled' and is in 'Switch on disabled'");
}

TEST(AxisSequence, LimitsAMotionByWhatItShouldTake) {
    FakeAxis axis;
    EXPECT_GT(motion_limit({.position = 101'000}, axis.state), 4s);
    EXPECT_LT(motion_limit({.position = 101'000}, axis.state), 6s);
    EXPECT_GT(motion_limit({.position = 101'000, .speed = 100}, axis.state), 1000s);
    axis.set(speed_override, 1);
    EXPECT_GT(motion_limit({.position = 101'000}, axis.state), 100s);
    axis.set(speed, 0);
    axis.set(acceleration, 0);
    EXPECT_GT(motion_limit({.position = 101'000}, axis.state), 1s);
}

TEST(AxisState, PutsWordsIntoWords) {
    EXPECT_THAT(
        set_bits(status_bits(), 0x1637, 1),
        ElementsAre("ready to switch on", "switched on", "operation enabled", "voltage enabled", "no quick stop",
                    "remote", "target position reached", "moving to target position acknowledged"));
    EXPECT_THAT(set_bits(status_bits(), 0x3400, 6),
                ElementsAre("reference performed", "reference achieved", "reference error"));
    EXPECT_THAT(set_bits(status_bits(), 0x5000, 0), ElementsAre("bit 12", "bit 14"));
    EXPECT_THAT(set_bits(process_bits(), 0x8000400A, 0),
                ElementsAre("reference", "in position", "force calibration active", "bit 31"));
    EXPECT_EQ(mode_text(-1), "jog mode");
    EXPECT_EQ(mode_text(3), "unknown mode");
    EXPECT_THAT(std::string(reference_method_text(12)), HasSubstr("counter clockwise"));
}

}  // namespace
}  // namespace servobus::scanner
