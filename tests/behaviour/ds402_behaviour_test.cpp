// What the state machine does to power and motion (004 §4.1), and what the modes do with their words (004 §4.2, §5).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/support/axis_kinds.hpp"
#include "tests/support/drive_harness.hpp"

namespace servobus {
namespace {

using namespace std::chrono_literals;
using test::DriveHarness;
namespace event = drive::event;

constexpr std::uint32_t switch_on_disabled = 0x0040;
constexpr std::uint32_t ready_to_switch_on = 0x0021;
constexpr std::uint32_t switched_on = 0x0023;
constexpr std::uint32_t operation_enabled = 0x0027;
constexpr std::uint32_t quick_stop_active = 0x0007;

std::uint32_t state(DriveHarness& drive) { return drive.word("Statusword") & 0x006FU; }
double velocity(DriveHarness& drive) { return static_cast<double>(drive.get("TellVelocity")); }
double position(DriveHarness& drive) { return static_cast<double>(drive.get("PositionActualValue")); }
bool has_power(DriveHarness& drive) { return drive.bit("ProcessStatusRegisterXENAX", 8); }
bool in_motion(DriveHarness& drive) { return drive.bit("ProcessStatusRegisterXENAX", 2); }

/// Whether the motor holds the axis against somebody who pushes.
bool holds(DriveHarness& drive) {
    const double before = position(drive);
    drive.inject(event::PushAxis{8});
    drive.run(100ms);
    drive.inject(event::PushAxis{0});
    const bool held = std::abs(position(drive) - before) < 1'000;
    drive.run(200ms);
    return held;
}

/// In the middle of its travel, and on the way in positive direction with constant speed.
void get_going(DriveHarness& drive) {
    drive.reference();
    drive.move(10'000);
    drive.set("Controlword", 0x0F);
    drive.set("AccelerationJogOrProfilePositionMode", 2'000'000);
    drive.set("SpeedJogOrProfilePositionMode", 200'000);
    drive.set("DecelerationQuickStop", 1'000'000);
    drive.set("TargetPositionOrDistance", 220'000);
    drive.set("Controlword", 0x1F);
    drive.run(200ms);
    ASSERT_NEAR(velocity(drive), 200'000, 3'000);
}

// ----------------------------------------------------------------------------------------------------- transitions

TEST(Transition, PowerComesWith3AndTheDriveWith4) {
    DriveHarness drive;
    EXPECT_EQ(state(drive), switch_on_disabled);  // 0 and 1
    EXPECT_FALSE(has_power(drive));
    drive.set("Controlword", 0x07);  // from here only Shutdown leads on
    EXPECT_EQ(state(drive), switch_on_disabled);
    drive.set("Controlword", 0x06);  // 2
    EXPECT_EQ(state(drive), ready_to_switch_on);
    EXPECT_FALSE(has_power(drive));
    drive.set("Controlword", 0x07);  // 3
    EXPECT_EQ(state(drive), switched_on);
    EXPECT_TRUE(has_power(drive));
    EXPECT_FALSE(holds(drive));
    drive.set("Controlword", 0x0F);  // 4
    EXPECT_EQ(state(drive), operation_enabled);
    EXPECT_TRUE(has_power(drive));
    EXPECT_TRUE(holds(drive));
}

struct Leaving {
    int number;
    std::int64_t word;
    std::uint32_t to;
    bool power;
};

// 5, 8, 9: the drive function is disabled, and the axis coasts.
TEST(Transition, OutOfOperationTakesTheDriveAway) {
    constexpr std::array<Leaving, 3> ways{
        {{5, 0x07, switched_on, true}, {8, 0x06, ready_to_switch_on, false}, {9, 0x00, switch_on_disabled, false}}};
    for (const Leaving& way : ways) {
        for (const bool moving : {false, true}) {
            DriveHarness drive;
            if (moving) {
                get_going(drive);
            } else {
                drive.reference();
            }
            drive.set("Controlword", way.word);
            EXPECT_EQ(state(drive), way.to) << way.number;
            EXPECT_EQ(has_power(drive), way.power) << way.number;
            EXPECT_FALSE(in_motion(drive)) << way.number;
            EXPECT_FALSE(drive.bit("Statusword", 10)) << way.number;
            EXPECT_FALSE(drive.bit("Statusword", 12)) << way.number;
            drive.run(10ms);
            EXPECT_EQ(drive.get("MotorCurrentActualValue"), 0) << way.number;
            if (moving) {
                EXPECT_GT(velocity(drive), 100'000) << "it coasts";
                drive.run(2s);
                EXPECT_EQ(velocity(drive), 0);
            }
            EXPECT_FALSE(holds(drive)) << way.number;
            // Back again: it stands where it is, and the old target is forgotten.
            const double before = position(drive);
            drive.power_on();
            drive.run(300ms);
            EXPECT_NEAR(position(drive), before, 5) << way.number;
            EXPECT_EQ(drive.get("TellError"), 0);
        }
    }
}

// 6, 7, 10
TEST(Transition, BackWithoutOperation) {
    const auto after = [](std::int64_t first, std::int64_t second) {
        DriveHarness drive;
        drive.set("Controlword", 0x06);
        if (first != 0x06) drive.set("Controlword", first);
        drive.set("Controlword", second);
        EXPECT_FALSE(has_power(drive));
        return state(drive);
    };
    EXPECT_EQ(after(0x07, 0x06), ready_to_switch_on);  // 6
    EXPECT_EQ(after(0x06, 0x00), switch_on_disabled);  // 7
    EXPECT_EQ(after(0x06, 0x02), switch_on_disabled);  // 7
    EXPECT_EQ(after(0x07, 0x00), switch_on_disabled);  // 10
    EXPECT_EQ(after(0x07, 0x02), switch_on_disabled);  // 10
}

// 11, then 12 or 16
TEST(Transition, QuickStopRampsDownAndWaits) {
    for (const bool goes_on : {false, true}) {
        DriveHarness drive;
        get_going(drive);
        const double begin = position(drive);
        drive.set("Controlword", 0x0B);
        EXPECT_EQ(state(drive), quick_stop_active);
        drive.run(100ms);
        EXPECT_NEAR(velocity(drive), 100'000, 6'000);
        EXPECT_TRUE(in_motion(drive));
        EXPECT_FALSE(drive.try_command("SM")) << "it is stopping already";
        drive.run(110ms);
        EXPECT_NEAR(position(drive) - begin, 20'000, 800) << "6085h, not the acceleration";
        drive.run(200ms);
        EXPECT_EQ(state(drive), quick_stop_active) << "until the controller says more";
        EXPECT_FALSE(in_motion(drive));
        EXPECT_TRUE(has_power(drive));
        EXPECT_TRUE(holds(drive));
        drive.set("Controlword", 0x1F & ~0x04);  // still a quick stop
        EXPECT_EQ(state(drive), quick_stop_active);
        if (goes_on) {
            drive.set("Controlword", 0x0F);  // 16
            EXPECT_EQ(state(drive), operation_enabled);
            drive.run(50ms);
            EXPECT_FALSE(in_motion(drive)) << "the old target is forgotten";
            drive.move(30'000);
            EXPECT_NEAR(position(drive), 30'000, 100);
        } else {
            drive.set("Controlword", 0x00);  // 12
            EXPECT_EQ(state(drive), switch_on_disabled);
            EXPECT_FALSE(has_power(drive));
            EXPECT_FALSE(holds(drive));
        }
    }
}

TEST(Transition, OutOfAQuickStopBeforeItStands) {
    DriveHarness drive;
    get_going(drive);
    drive.set("Controlword", 0x02);
    drive.run(50ms);
    drive.set("Controlword", 0x0F);
    EXPECT_EQ(state(drive), operation_enabled);
    drive.set("Controlword", 0x1F);  // it does not stand yet
    drive.run(300ms);
    EXPECT_EQ(velocity(drive), 0);
    drive.move(30'000);
    EXPECT_NEAR(position(drive), 30'000, 100);
}

// 13, 14, 15
TEST(Transition, FaultReactionEndsByItself) {
    DriveHarness drive;
    get_going(drive);
    drive.inject(event::EmergencyExit{true, false});
    EXPECT_EQ(drive.word("Statusword") & 0x004FU, 0x000FU);
    for (const std::int64_t word : {0x00, 0x06, 0x07, 0x0F, 0x80}) {
        drive.set("Controlword", word);
        EXPECT_EQ(drive.word("Statusword") & 0x004FU, 0x000FU) << word;
    }
    EXPECT_TRUE(drive.runs_until([&] { return (drive.word("Statusword") & 0x004FU) == 0x0008U; }, 300ms));
    EXPECT_FALSE(has_power(drive));
    drive.inject(event::EmergencyExit{false, false});
    drive.set("Controlword", 0x80);  // bit 7 has been set before
    EXPECT_EQ(drive.word("Statusword") & 0x004FU, 0x0008U);
    drive.set("Controlword", 0x0F);  // a fault takes no command
    EXPECT_EQ(drive.word("Statusword") & 0x004FU, 0x0008U);
    drive.set("Controlword", 0x8F);
    EXPECT_EQ(state(drive), switch_on_disabled) << "a reset does nothing else";
    drive.set("Controlword", 0x8F);
    EXPECT_EQ(state(drive), switch_on_disabled);
}

TEST(Transition, StraightFromReadyToOperation) {
    for (const std::int64_t word : {0x0F, 0x1F}) {
        DriveHarness drive;
        drive.set("Controlword", 0x06);
        drive.set("Controlword", word);
        EXPECT_EQ(state(drive), operation_enabled) << word;
    }
}

TEST(SwitchOnDisable, LeavesThePowerOffInTransition3) {
    DriveHarness drive;
    drive.set("SOD", 1);
    drive.set("Controlword", 0x06);
    drive.set("Controlword", 0x07);
    EXPECT_EQ(state(drive), switched_on);
    EXPECT_FALSE(has_power(drive));
    drive.set("Controlword", 0x0F);
    EXPECT_TRUE(has_power(drive));
    EXPECT_TRUE(holds(drive));
    drive.set("Controlword", 0x07);
    EXPECT_EQ(state(drive), switched_on);
    EXPECT_FALSE(has_power(drive)) << "the same state, the same power";
}

TEST(ControlWord, WrittenTwiceDoesNothingTheSecondTime) {
    DriveHarness drive;
    drive.reference();
    drive.set("Controlword", 0x0F);
    drive.set("TargetPositionOrDistance", 2'000);
    drive.set("Controlword", 0x5F);
    EXPECT_TRUE(drive.runs_until([&] { return drive.reached(); }, 5s));
    const double reached = position(drive);
    drive.set("Controlword", 0x5F);
    drive.run(100ms);
    EXPECT_NEAR(position(drive), reached, 100);
    EXPECT_TRUE(drive.bit("Statusword", 10));
    drive.set("Controlword", 0x0F);
    drive.set("Controlword", 0x5F);
    EXPECT_TRUE(drive.runs_until([&] { return drive.reached(); }, 5s));
    EXPECT_NEAR(position(drive), reached + 2'000, 100);
}

TEST(ControlWord, ThatEnablesAndStartsDoesBoth) {
    DriveHarness drive;
    drive.reference();
    drive.set("Controlword", 0x06);
    drive.set("TargetPositionOrDistance", 100'000);
    drive.set("Controlword", 0x1F);
    EXPECT_EQ(state(drive), operation_enabled);
    EXPECT_TRUE(drive.bit("Statusword", 12));
    EXPECT_TRUE(drive.runs_until([&] { return drive.reached(); }, 5s));
    EXPECT_NEAR(position(drive), 100'000, 100);
}

// ----------------------------------------------------------------------------------------------------------- brake

constexpr std::int64_t brake_released = 11;  // TYOF

void connect_brake(DriveHarness& drive) {
    drive.set("NOF", 2);
    drive.set("TYOF", brake_released);
    drive.set("BRKD", 150);
}

bool brake_output(DriveHarness& drive) { return drive.bit("TellOutputHex", 1); }

TEST(Brake, OpensAfterTheCurrentAndClosesBeforeIt) {
    DriveHarness drive;
    connect_brake(drive);
    EXPECT_FALSE(brake_output(drive));
    EXPECT_TRUE(holds(drive)) << "the brake holds an axis without power";
    drive.set("Controlword", 0x06);
    drive.set("Controlword", 0x07);
    drive.set("Controlword", 0x0F);
    EXPECT_EQ(state(drive), switched_on) << "until the brake is open";
    drive.run(140ms);
    EXPECT_EQ(state(drive), switched_on);
    EXPECT_FALSE(brake_output(drive));
    drive.run(20ms);
    EXPECT_EQ(state(drive), operation_enabled);
    EXPECT_TRUE(brake_output(drive));
    EXPECT_TRUE(holds(drive));

    drive.set("Controlword", 0x00);
    EXPECT_EQ(state(drive), switch_on_disabled);
    EXPECT_FALSE(brake_output(drive));
    drive.run(50ms);
    EXPECT_TRUE(drive.device().next_deadline()) << "the motor holds until the brake does";
    drive.run(200ms);
    EXPECT_EQ(drive.get("MotorCurrentActualValue"), 0);
    EXPECT_TRUE(holds(drive));
}

TEST(Brake, IsWaitedForByCommands) {
    DriveHarness drive;
    connect_brake(drive);
    drive.command("REF");
    EXPECT_EQ(state(drive), switched_on);
    EXPECT_TRUE(drive.runs_until([&] { return drive.bit("ProcessStatusRegisterXENAX", 1); }, 10s));
    drive.command("PQ");
    drive.run(500ms);
    EXPECT_FALSE(has_power(drive));
    drive.command("PWC");
    drive.run(200ms);
    EXPECT_EQ(state(drive), operation_enabled) << "whatever the control word says";
    EXPECT_TRUE(brake_output(drive));
}

TEST(Brake, IsWaitedForByTheModes) {
    DriveHarness drive;
    drive.reference(1, 8);
    drive.set("Controlword", 0x00);
    connect_brake(drive);
    drive.set("TargetPositionOrDistance", drive.get("PositionActualValue"));
    drive.set("Controlword", 0x06);
    drive.set("Controlword", 0x1F);
    EXPECT_FALSE(drive.bit("Statusword", 12));
    drive.run(200ms);
    EXPECT_EQ(state(drive), operation_enabled);
    EXPECT_TRUE(drive.bit("Statusword", 12));
}

TEST(Brake, StaysClosedWhenOperationIsNotWantedAnyMore) {
    DriveHarness drive;
    connect_brake(drive);
    drive.set("Controlword", 0x06);
    drive.set("Controlword", 0x0F);
    drive.run(50ms);
    drive.set("Controlword", 0x07);
    drive.run(500ms);
    EXPECT_EQ(state(drive), switched_on);
    EXPECT_FALSE(brake_output(drive));
    EXPECT_EQ(drive.get("MotorCurrentActualValue"), 0);
    EXPECT_TRUE(has_power(drive));
    drive.set("Controlword", 0x0F);
    drive.run(200ms);
    EXPECT_EQ(state(drive), operation_enabled);
}

TEST(Brake, StopsAnAxisThatIsDisabledInMotion) {
    DriveHarness drive;
    connect_brake(drive);
    drive.enter_mode(6);
    drive.set("Controlword", 0x06);
    drive.set("Controlword", 0x0F);
    drive.run(200ms);
    drive.set("Controlword", 0x1F);
    EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 12); }, 10s));
    drive.enter_mode(-1);
    drive.set("Controlword", 0x5F);
    drive.run(300ms);
    const double begin = position(drive);
    drive.set("Controlword", 0x07);
    EXPECT_FALSE(in_motion(drive)) << "the set point stands at once";
    drive.run(500ms);
    EXPECT_LT(position(drive) - begin, 5'000);
    EXPECT_TRUE(holds(drive));
}

TEST(Brake, ClosesWhenLogicPowerGoes) {
    DriveHarness drive;
    connect_brake(drive);
    drive.command("REF");
    drive.run(3s);
    drive.inject(event::PowerCycle{});
    EXPECT_FALSE(brake_output(drive));
    EXPECT_TRUE(holds(drive));
}

// ----------------------------------------------------------------------------------------------------------- modes

TEST(Mode, ChangesWhenTheAxisStands) {
    DriveHarness drive;
    get_going(drive);
    drive.set("ModesOfOperationRequested", -1);
    EXPECT_EQ(drive.get("ModesOfOperationDisplayed"), 1);
    drive.run(50ms);
    EXPECT_EQ(drive.get("ModesOfOperationDisplayed"), 1);
    EXPECT_TRUE(drive.runs_until([&] { return drive.get("ModesOfOperationDisplayed") == -1; }, 5s));
    EXPECT_FALSE(in_motion(drive));
    EXPECT_NEAR(position(drive), 220'000, 200) << "the running motion was finished";
}

TEST(Mode, NoneAndMinusTwoStartNothing) {
    for (const std::int64_t mode : {0, -2}) {
        DriveHarness drive;
        drive.reference(1, mode);
        drive.set("TargetPositionOrDistance", 100'000);
        for (const std::int64_t word : {0x1F, 0x0F, 0x5F, 0x10F, 0x0F, 0x1F}) {
            drive.set("Controlword", word);
            drive.run(20ms);
            EXPECT_FALSE(in_motion(drive)) << mode;
        }
        EXPECT_FALSE(drive.bit("Statusword", 12));
        EXPECT_EQ(state(drive), operation_enabled);
    }
}

TEST(Mode, RefusesWhatIsNotListed) {
    DriveHarness drive;
    for (const std::int64_t mode : {-3, 2, 3, 5, 7, 9, 10}) {
        EXPECT_TRUE(drive.try_set("ModesOfOperationRequested", mode)) << mode;
    }
    EXPECT_EQ(drive.get("ModesOfOperationDisplayed"), 0);
}

TEST(ProfilePosition, WithoutReferenceWarnsAndStands) {
    DriveHarness drive;
    drive.enter_mode(1);
    drive.power_on();
    drive.set("TargetPositionOrDistance", 50'000);
    drive.set("Controlword", 0x1F);
    EXPECT_EQ(drive.get("TellError"), 40);
    EXPECT_TRUE(drive.bit("Statusword", 7));
    EXPECT_FALSE(drive.bit("Statusword", 12));
    drive.run(200ms);
    EXPECT_EQ(position(drive), 0);
    EXPECT_EQ(state(drive), operation_enabled) << "a warning, no fault";
}

TEST(ProfilePosition, WaitsAtAnOverrideOf0) {
    DriveHarness drive;
    drive.reference();
    drive.set("OVRD", 0);
    drive.set("TargetPositionOrDistance", 120'000);
    drive.set("Controlword", 0x1F);
    EXPECT_TRUE(drive.bit("Statusword", 12));
    drive.run(300ms);
    EXPECT_EQ(velocity(drive), 0);
    EXPECT_TRUE(in_motion(drive));
    EXPECT_FALSE(drive.bit("Statusword", 10));
    drive.set("OVRD", 25);
    drive.run(300ms);
    EXPECT_NEAR(velocity(drive), 25'000, 1'000) << "a quarter of SP";
    EXPECT_TRUE(drive.runs_until([&] { return drive.reached(); }, 5s));
    EXPECT_NEAR(position(drive), 120'000, 100);
}

TEST(ProfilePosition, OfAnIndexKeepsItsOwnSpeedWhileItWaits) {
    DriveHarness drive;
    drive.reference(1, 0);
    drive.set("NIX", 3);
    drive.set("SIX", 40'000);
    drive.set("DIX", 120'000);
    drive.set("TYIX", 1);
    drive.set("OVRD", 0);
    drive.set("IX", 3);
    drive.run(100ms);
    EXPECT_EQ(velocity(drive), 0);
    drive.set("OVRD", 50);
    drive.run(300ms);
    EXPECT_NEAR(velocity(drive), 20'000, 1'000);
}

TEST(ProfilePosition, HaltEndsAMotionThatWaits) {
    DriveHarness drive;
    drive.reference();
    drive.set("OVRD", 0);
    drive.set("TargetPositionOrDistance", 120'000);
    drive.set("Controlword", 0x1F);
    drive.run(10ms);
    drive.set("Controlword", 0x10F);
    drive.run(10ms);
    EXPECT_FALSE(drive.bit("Statusword", 12));
    drive.set("OVRD", 100);
    drive.run(100ms);
    EXPECT_FALSE(in_motion(drive));
}

TEST(ProfilePosition, ShowsTheTargetAfterTheWindowTime) {
    for (const std::int64_t milliseconds : {0, 50, 1'000}) {
        DriveHarness drive;
        drive.reference();
        drive.set("TargetPositionWindowTime", milliseconds);
        drive.set("TargetPositionOrDistance", 80'000);
        drive.set("Controlword", 0x1F);
        EXPECT_TRUE(drive.runs_until([&] { return !drive.bit("Statusword", 12); }, 5s));
        const auto arrival = drive.now();
        EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 10); }, 3s)) << milliseconds;
        const double waited = std::chrono::duration<double, std::milli>(drive.now() - arrival).count();
        EXPECT_NEAR(waited, static_cast<double>(milliseconds), 30) << milliseconds;
    }
}

TEST(ProfilePosition, NeedNotAcknowledge) {
    DriveHarness drive;
    drive.reference();
    drive.set("SPAD", 1);
    drive.set("TargetPositionOrDistance", 80'000);
    drive.set("Controlword", 0x1F);
    EXPECT_TRUE(in_motion(drive));
    EXPECT_FALSE(drive.bit("Statusword", 12));
    EXPECT_FALSE(drive.bit("Statusword", 10));
    EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 10); }, 5s));
}

TEST(ProfilePosition, EndsAtTheSoftLimit) {
    for (const bool relative : {false, true}) {
        for (const bool positive : {false, true}) {
            DriveHarness drive;
            drive.reference();
            drive.set("SoftLimitPositionNegative", 30'000);
            drive.set("SoftLimitPositionPositive", 90'000);
            drive.move(positive ? 100'000 : -100'000, relative);
            EXPECT_NEAR(position(drive), positive ? 90'000 : 30'000, 100);
            EXPECT_TRUE(drive.bit("Statusword", 11));
            EXPECT_EQ(drive.get("TellError"), 80);
            drive.move(60'000);
            EXPECT_FALSE(drive.bit("Statusword", 11));
        }
    }
}

TEST(CyclicSynchronousPosition, IsHeldAtTheSoftLimit) {
    DriveHarness drive;
    drive.reference(1, 8);
    const auto limit = drive.get("PositionActualValue") + 2'000;
    drive.set("SoftLimitPositionNegative", 0);
    drive.set("SoftLimitPositionPositive", limit);
    drive.set("TargetPositionOrDistance", drive.get("PositionActualValue"));
    drive.set("Controlword", 0x1F);
    for (std::int64_t target = limit - 2'000; target < limit + 3'000; target += 50) {
        drive.set("TargetPositionOrDistance", target);
        drive.run(1ms);
        EXPECT_EQ(drive.bit("Statusword", 11), target > limit) << target - limit;
    }
    drive.run(200ms);
    EXPECT_NEAR(position(drive), static_cast<double>(limit), 5);
    drive.set("TargetPositionOrDistance", limit - 20);
    drive.run(10ms);
    EXPECT_FALSE(drive.bit("Statusword", 11));
    EXPECT_EQ(drive.get("TellError"), 0);
}

TEST(CyclicSynchronousPosition, StopsWhenTheStartBitGoes) {
    DriveHarness drive;
    drive.reference(1, 8);
    auto target = drive.get("PositionActualValue");
    drive.set("TargetPositionOrDistance", target);
    drive.set("Controlword", 0x1F);
    for (int cycle = 0; cycle < 100; ++cycle) {
        drive.set("TargetPositionOrDistance", target += cycle);
        drive.run(1ms);
    }
    drive.set("Controlword", 0x0F);
    EXPECT_FALSE(drive.bit("Statusword", 12));
    drive.run(300ms);
    EXPECT_EQ(velocity(drive), 0);
    EXPECT_EQ(drive.get("TellError"), 0);
    const double before = position(drive);
    drive.set("TargetPositionOrDistance", target + 10'000);
    drive.run(100ms);
    EXPECT_NEAR(position(drive), before, 5) << "nobody listens";
}

// ------------------------------------------------------------------------------------------------------------- jog

TEST(Jog, TurnsRoundOnTheFly) {
    DriveHarness drive;
    drive.reference(1, -1);
    drive.set("Controlword", 0x5F);
    drive.run(250ms);
    EXPECT_NEAR(velocity(drive), 100'000, 3'000);
    drive.set("Controlword", 0x1F);
    drive.run(20ms);
    EXPECT_FALSE(drive.bit("Statusword", 10)) << "not constant";
    EXPECT_FALSE(drive.bit("Statusword", 12));
    drive.run(280ms);
    EXPECT_NEAR(velocity(drive), -100'000, 3'000);
    EXPECT_TRUE(drive.bit("Statusword", 10));
}

TEST(Jog, FollowsTheOverrideInItsDirection) {
    for (const bool by_command : {false, true}) {
        for (const bool positive : {false, true}) {
            DriveHarness drive;
            drive.reference(1, by_command ? 0 : -1);
            if (by_command) {
                drive.command(positive ? "JP" : "JN");
            } else {
                drive.set("Controlword", positive ? 0x5F : 0x1F);
            }
            const double sign = positive ? 1 : -1;
            drive.run(200ms);
            EXPECT_NEAR(velocity(drive), sign * 100'000, 3'000);
            drive.set("OVRD", 30);
            drive.run(200ms);
            EXPECT_NEAR(velocity(drive), sign * 30'000, 1'500);
            drive.set("OVRD", 0);
            drive.run(200ms);
            EXPECT_NEAR(velocity(drive), 0, 100);
            drive.set("OVRD", 50);
            drive.run(100ms);
            EXPECT_NEAR(velocity(drive), sign * 50'000, 2'000) << "in the direction that was asked for";
        }
    }
}

// Halt stops it whatever bit 6 says (errata X-29).
TEST(Jog, HaltStopsItInEitherDirection) {
    for (const std::int64_t start : {0x1F, 0x5F}) {
        for (const std::int64_t halt : {0x11F, 0x15F}) {
            DriveHarness drive;
            drive.reference(1, -1);
            drive.set("Controlword", start);
            drive.run(200ms);
            drive.set("Controlword", halt);
            EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 12); }, 1s));
            EXPECT_TRUE(drive.bit("Statusword", 10));
            drive.run(100ms);
            EXPECT_EQ(velocity(drive), 0);
            drive.set("Controlword", start);  // without halt it goes on
            drive.run(200ms);
            EXPECT_NEAR(std::abs(velocity(drive)), 100'000, 3'000);
            drive.set("Controlword", 0x0F);  // without bit 4 it ends
            drive.run(300ms);
            EXPECT_EQ(velocity(drive), 0);
        }
    }
}

TEST(Jog, BrakesInTimeForTheSoftLimit) {
    for (const bool positive : {false, true}) {
        DriveHarness drive;
        drive.reference(1, -1);
        drive.set("SoftLimitPositionNegative", 20'000);
        drive.set("SoftLimitPositionPositive", 120'000);
        const double limit = positive ? 120'000 : 20'000;
        drive.set("Controlword", positive ? 0x5F : 0x1F);
        double beyond = -1e9;
        EXPECT_TRUE(drive.runs_until(
            [&] {
                beyond = std::max(beyond, (position(drive) - limit) * (positive ? 1 : -1));
                return drive.bit("Statusword", 11) && drive.bit("Statusword", 12);
            },
            5s));
        EXPECT_LT(beyond, 20);
        drive.run(100ms);
        EXPECT_NEAR(position(drive), limit, 100);
        EXPECT_EQ(drive.get("TellError"), 80);
        drive.set("Controlword", 0x0F);
        drive.set("Controlword", positive ? 0x5F : 0x1F);
        drive.run(100ms);
        EXPECT_NEAR(position(drive), limit, 120) << "no farther";
        drive.set("Controlword", positive ? 0x1F : 0x5F);
        drive.run(300ms);
        EXPECT_FALSE(drive.bit("Statusword", 11));
        EXPECT_NEAR(std::abs(velocity(drive)), 100'000, 3'000) << "away from it";
    }
}

TEST(Jog, IsStoppedAndNotTurnedRoundByAParameter) {
    DriveHarness drive;
    drive.reference(1, 0);
    drive.command("JP");
    drive.run(200ms);
    drive.command("SM");
    drive.set("SpeedJogOrProfilePositionMode", 50'000);
    drive.run(300ms);
    EXPECT_EQ(velocity(drive), 0);
}

// ------------------------------------------------------------------------------------------------------- reference

TEST(ReferenceMode, CanBeInterrupted) {
    for (const std::int64_t word : {0x0F, 0x10F, 0x11F}) {
        for (const auto moment : {500ms, 1'550ms}) {  // while the axis finds its angle, and while it searches
            DriveHarness drive;
            drive.enter_mode(6);
            drive.power_on();
            drive.set("Controlword", 0x1F);
            drive.run(moment);
            EXPECT_EQ(in_motion(drive), moment > 1s) << "while it finds its angle the drive shows no motion";
            drive.set("Controlword", word);
            drive.run(300ms);
            EXPECT_FALSE(in_motion(drive));
            EXPECT_EQ(velocity(drive), 0);
            EXPECT_EQ(state(drive), operation_enabled);
            EXPECT_FALSE(drive.bit("Statusword", 12));
            EXPECT_FALSE(drive.bit("Statusword", 13));
            EXPECT_FALSE(drive.bit("ProcessStatusRegisterXENAX", 1));
            drive.set("Controlword", 0x0F);
            drive.set("Controlword", 0x1F);
            EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 12); }, 10s));
        }
    }
}

TEST(ReferenceMode, StartsByItselfWithAutomaticReference) {
    DriveHarness drive;
    drive.set("AREF", 1);
    drive.power_on();
    drive.enter_mode(6);
    EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 12); }, 10s));
    EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 1));
    // A second time there is nothing to do.
    drive.enter_mode(1);
    drive.enter_mode(6);
    drive.run(100ms);
    EXPECT_FALSE(in_motion(drive));
}

TEST(ReferenceMode, WithNeitherSensorNorZMarkTakesThePlaceWhereTheAxisStands) {
    DriveHarness drive(drive::shipped_kind("third-party-rotative"));
    drive.set("ReferenceSpeedForExternalReferenceSensor", 0);
    drive.set("ReferenceSpeedForInternalZMark", 0);
    drive.reference(10);
    EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 1));
    EXPECT_EQ(position(drive), 0);
}

TEST(Calibration, ThatIsStoppedIsOver) {
    for (const auto* command : {"FC", "IFDCP", "MLC"}) {
        DriveHarness drive;
        drive.reference(1, 0);
        drive.set("WA", 40'000);
        drive.command(command);
        drive.run(100ms);
        drive.command("SM");
        drive.run(300ms);
        EXPECT_FALSE(in_motion(drive)) << command;
        EXPECT_FALSE(drive.bit("ProcessStatusRegisterXENAX", 14)) << command;
        EXPECT_FALSE(drive.bit("ProcessStatusRegisterXENAX", 26)) << command;
        EXPECT_EQ(drive.get("ForceCalibrationValid"), 0);
    }
}

// ------------------------------------------------------------------------------------------------------------ rest

TEST(Rest, WantsNoStep) {
    DriveHarness drive;
    drive.run(1ms);
    EXPECT_FALSE(drive.device().next_deadline()) << "without power";
    drive.reference();
    drive.move(80'000);
    drive.run(2s);
    EXPECT_FALSE(drive.device().next_deadline()) << "in its place";
    drive.set("Controlword", 0x0F);
    drive.set("TargetPositionOrDistance", 90'000);
    drive.set("Controlword", 0x1F);
    EXPECT_TRUE(drive.device().next_deadline());
    EXPECT_LE(*drive.device().next_deadline(), drive.now() + 1ms);
    drive.run(2s);
    EXPECT_FALSE(drive.device().next_deadline());
    drive.inject(event::PushAxis{5});
    EXPECT_TRUE(drive.device().next_deadline()) << "somebody pushes";
    drive.inject(event::PushAxis{0});
    drive.set("Controlword", 0x00);
    drive.run(2s);
    EXPECT_FALSE(drive.device().next_deadline());
}

// The same moments, seen seldom or often: not a bit may differ, but for warmth in the rests between.
TEST(Rest, DoesNotDependOnHowOftenTheDriveIsStepped) {
    const auto history = [](drive::Time step) {
        drive::Device device(*drive::xenax_model("75v8s"), drive::Machine{drive::AxisKind{}, 5});
        drive::Time now{0};
        device.step(now);
        const auto write = [&](drive::Key key, std::int64_t value) {
            EXPECT_FALSE(device.write(*device.find(key), value));
        };
        const auto pass = [&](drive::Time duration) {
            for (const drive::Time end = now + duration; now < end;) device.step(now = std::min(end, now + step));
        };
        write({0x66, 0x28}, 100);  // the time in the target window
        write({0x66, 0x20}, 6);
        for (const std::int64_t word : {0x06, 0x0F, 0x1F}) write({0x66, 0x00}, word);
        pass(4s);
        write({0x66, 0x20}, 1);
        for (const std::int64_t target : {100'000, 20'000, 21'000}) {
            write({0x66, 0x00}, 0x0F);
            write({0x66, 0x3A}, target);
            write({0x66, 0x00}, 0x1F);
            pass(3s);
        }
        device.inject(event::BlockAxis{true});
        write({0x66, 0x00}, 0x0F);
        write({0x66, 0x00}, 0x5F);
        pass(2s);
        std::vector<drive::Value> values;
        for (const auto& row : device.store().table()) values.push_back(device.store().value(row));
        return values;
    };
    const auto often = history(100us);
    EXPECT_EQ(history(7ms), often);
    EXPECT_EQ(history(5s), often);
}

}  // namespace
}  // namespace servobus
