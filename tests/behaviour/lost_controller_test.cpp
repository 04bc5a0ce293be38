// What the drive does when whoever controls it over a cyclic connection is idle, silent, or has gone (docs/motion.md).
#include <gtest/gtest.h>

#include <array>
#include <cmath>

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
void lose(DriveHarness& drive) { drive.inject(event::LoseController{}); }

/// At 200,000 increments/s in positive direction, with 6085h = 1,000,000.
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

void stands_for_a_while(DriveHarness& drive) {
    drive.run(500ms);
    const double place = position(drive);
    EXPECT_FALSE(in_motion(drive));
    drive.run(1s);
    EXPECT_NEAR(position(drive), place, 20);
    EXPECT_NEAR(velocity(drive), 0, 500);
}

TEST(LostController, StopsWithTheRampOfAQuickStopAndKeepsThePower) {
    DriveHarness drive;
    get_going(drive);
    const double begin = position(drive);
    lose(drive);
    EXPECT_EQ(state(drive), quick_stop_active);  // transition 11
    drive.run(100ms);
    EXPECT_NEAR(velocity(drive), 100'000, 6'000);
    drive.run(110ms);
    EXPECT_NEAR(position(drive) - begin, 20'000, 800) << "6085h, not the acceleration";
    stands_for_a_while(drive);
    EXPECT_EQ(state(drive), quick_stop_active);
    EXPECT_TRUE(has_power(drive)) << "a load that hangs is held";
    EXPECT_EQ(drive.get("TE"), 0) << "it is no fault";
}

TEST(LostController, OldStartBitStartsNothingWhenTheControllerIsBack) {
    DriveHarness drive;
    get_going(drive);
    lose(drive);
    drive.run(500ms);
    for (int repeated = 0; repeated < 3; ++repeated) {
        drive.set("Controlword", 0x1F);
        EXPECT_EQ(state(drive), operation_enabled) << "transition 16";
        stands_for_a_while(drive);
    }
    drive.set("Controlword", 0x0F);
    stands_for_a_while(drive);
    drive.set("Controlword", 0x1F);
    EXPECT_TRUE(drive.runs_until([&] { return drive.reached(); }, 10s));
    EXPECT_NEAR(position(drive), 220'000, 100);
}

// A controller that comes back knows nothing of an edge either: the bit has to be seen at 0 once.
TEST(LostController, StartBitThatComesWithTheControllerIsNoEdge) {
    DriveHarness drive;
    get_going(drive);
    drive.set("Controlword", 0x0F);
    lose(drive);
    drive.run(500ms);
    drive.set("Controlword", 0x1F);
    stands_for_a_while(drive);
}

TEST(LostController, LeavesQuickStopByDisableVoltageToo) {
    DriveHarness drive;
    get_going(drive);
    lose(drive);
    drive.run(500ms);
    drive.set("Controlword", 0x00);  // transition 12
    EXPECT_EQ(state(drive), switch_on_disabled);
    EXPECT_FALSE(has_power(drive));
    drive.power_on();
    drive.move(30'000);
    EXPECT_NEAR(position(drive), 30'000, 100);
}

struct Level {
    std::int64_t mode;
    std::int64_t word;
};

// In these two modes bit 4 is a level, and a word that is only repeated would do.
TEST(LostController, EndsJogAndFollowingUntilTheBitRisesAgain) {
    for (const Level& level : std::array<Level, 2>{{{-1, 0x5F}, {8, 0x1F}}}) {
        SCOPED_TRACE(level.mode);
        DriveHarness drive;
        drive.reference(1, level.mode);
        drive.set("SpeedJogOrProfilePositionMode", 20'000);
        drive.set("TargetPositionOrDistance", static_cast<std::int64_t>(position(drive)));
        drive.set("Controlword", level.word);
        for (int cycle = 0; cycle < 200; ++cycle) {
            drive.set("TargetPositionOrDistance", drive.get("TargetPositionOrDistance") + 20);
            drive.run(1ms);
        }
        ASSERT_NEAR(velocity(drive), 20'000, 2'000);
        lose(drive);
        EXPECT_EQ(state(drive), quick_stop_active);
        drive.run(500ms);
        drive.set("TargetPositionOrDistance", drive.get("TargetPositionOrDistance") + 5'000);
        drive.set("Controlword", level.word);
        EXPECT_EQ(state(drive), operation_enabled);
        stands_for_a_while(drive);
        drive.set("Controlword", 0x0F);
        drive.set("TargetPositionOrDistance", static_cast<std::int64_t>(position(drive)));
        drive.set("Controlword", level.word);
        drive.set("TargetPositionOrDistance", static_cast<std::int64_t>(position(drive)) + 200);
        EXPECT_TRUE(in_motion(drive));
    }
}

TEST(LostController, EndsAReferenceWithoutSuccess) {
    DriveHarness drive;
    drive.enter_mode(6);
    drive.power_on();
    drive.set("Controlword", 0x1F);
    drive.run(1800ms);
    ASSERT_NE(velocity(drive), 0);
    lose(drive);
    EXPECT_EQ(state(drive), quick_stop_active);
    stands_for_a_while(drive);
    EXPECT_FALSE(drive.bit("ProcessStatusRegisterXENAX", 1));
    drive.set("Controlword", 0x1F);
    stands_for_a_while(drive);
}

// A program that waits would go on to power on and to move.
TEST(LostController, EndsAProgramAlsoWhileItWaitsWithoutPower) {
    for (const bool with_power : {false, true}) {
        SCOPED_TRACE(with_power);
        const auto value = [](std::string_view mnemonic) {
            return std::int64_t{drive::find_command(drive::direct_commands(), mnemonic)->value};
        };
        using Kind = drive::ProgramStep::Kind;
        drive::Machine machine;
        machine.memory.programs[1] = {{Kind::wait_time, {}, 500},
                                      {Kind::write, {0x65, 0x00}, value("PWC")},
                                      {Kind::write, {0x65, 0x00}, value("JP")}};
        DriveHarness drive(machine);
        if (with_power) drive.reference(1, 0);
        drive.set("PG", 1);
        drive.run(100ms);
        ASSERT_FALSE(drive.bit("ProcessStatusRegisterXENAX", 4));
        lose(drive);
        EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 4)) << "the end of a program";
        drive.run(2s);
        EXPECT_FALSE(in_motion(drive));
        EXPECT_EQ(state(drive), with_power ? quick_stop_active : switch_on_disabled);
    }
}

TEST(LostController, UncouplesFromTheMaster) {
    DriveHarness drive;
    drive.reference(1, 0);
    drive.set("SR", 100);
    drive.inject(event::TurnMaster{20'000});
    drive.run(300ms);
    ASSERT_NEAR(velocity(drive), 20'000, 2'000);
    lose(drive);
    drive.run(500ms);
    drive.set("Controlword", 0x0F);
    EXPECT_EQ(state(drive), operation_enabled);
    stands_for_a_while(drive);
    drive.set("SR", 100);
    drive.run(300ms);
    EXPECT_NEAR(velocity(drive), 20'000, 2'000);
}

// A motion that waits for an override above 0, and one whose target is behind an obstacle, do not go on later.
TEST(LostController, LeavesNoMotionThatWaits) {
    DriveHarness drive;
    get_going(drive);
    EXPECT_TRUE(drive.runs_until([&] { return drive.reached(); }, 10s));
    drive.set("OVRD", 0);
    drive.set("Controlword", 0x0F);
    drive.set("TargetPositionOrDistance", 20'000);
    drive.set("Controlword", 0x1F);
    lose(drive);
    drive.set("OVRD", 100);
    stands_for_a_while(drive);
    EXPECT_NEAR(position(drive), 220'000, 100);
}

TEST(LostController, DoesNotGoOnWhenAnObstacleGivesWay) {
    DriveHarness drive;
    drive.reference();
    drive.move(10'000);
    drive.set("SpeedJogOrProfilePositionMode", 50'000);
    drive.set("LimitIForce", 100);
    drive.inject(event::PutObstacle{30'000, 200});
    drive.set("Controlword", 0x0F);
    drive.set("TargetPositionOrDistance", 80'000);
    drive.set("Controlword", 0x1F);
    drive.run(3s);
    const double place = position(drive);
    ASSERT_LT(place, 40'000);
    lose(drive);
    drive.run(500ms);
    drive.inject(event::RemoveObstacle{});
    drive.run(2s);
    EXPECT_NEAR(position(drive), place, 5'000);
    EXPECT_FALSE(in_motion(drive));
}

TEST(LostController, ChangesNoOtherState) {
    for (const auto word : {0x00, 0x06, 0x07}) {
        DriveHarness drive;
        drive.set("Controlword", 0x06);
        drive.set("Controlword", word);
        const auto before = state(drive);
        ASSERT_EQ(before, word == 0x00 ? switch_on_disabled : word == 0x06 ? ready_to_switch_on : switched_on);
        lose(drive);
        EXPECT_EQ(state(drive), before);
        drive.set("Controlword", 0x06);
        drive.power_on();
    }
}

TEST(LostController, LeavesAFaultAlone) {
    DriveHarness drive;
    get_going(drive);
    drive.inject(event::LoseEncoder{true});
    const auto error = drive.get("TE");
    ASSERT_NE(error, 0);
    drive.run(100ms);
    const auto before = state(drive);
    lose(drive);
    EXPECT_EQ(state(drive), before);
    EXPECT_EQ(drive.get("TE"), error);
}

TEST(LostController, StopsAMotionThatAnotherHasBegunToo) {
    DriveHarness drive;
    drive.reference(1, 0);
    drive.set("SP", 50'000);
    drive.command("JP");
    drive.run(300ms);
    ASSERT_TRUE(in_motion(drive));
    lose(drive);
    EXPECT_EQ(state(drive), quick_stop_active);
    stands_for_a_while(drive);
}

TEST(LostController, DoesNotWaitForTheBrakeToEnableOperation) {
    DriveHarness drive;
    drive.set("NOF", 1);
    drive.set("TYOF", 11);  // a brake
    drive.set("BRKD", 100);
    drive.set("Controlword", 0x06);
    drive.set("Controlword", 0x07);
    drive.set("Controlword", 0x0F);
    ASSERT_EQ(state(drive), switched_on);
    lose(drive);
    drive.run(500ms);
    EXPECT_EQ(state(drive), switched_on);
    drive.set("Controlword", 0x0F);
    drive.run(500ms);
    EXPECT_EQ(state(drive), operation_enabled);
}

TEST(LostController, KeepsItsOutputsOrClearsThem) {
    for (const bool off : {false, true}) {
        drive::Machine machine;
        if (off) machine.outputs_without_controller = drive::OutputsWithoutController::off;
        DriveHarness drive(machine);
        drive.set("NOF", 2);
        drive.set("TYOF", 4);  // in position: not a matter of what is written
        drive.set("DigitalOutputsXENAX", 0x00A50000);
        drive.reference();
        const auto function = drive.get("TOX") & 0x02;
        lose(drive);
        EXPECT_EQ(drive.word("DigitalOutputsXENAX"), off ? 0U : 0x00A50000U);
        EXPECT_EQ(drive.get("TOX"), (off ? 0x00 : 0xA5) | function);
        drive.set("DigitalOutputsXENAX", 0x00010000);
        EXPECT_EQ(drive.get("TOX") & ~0x02, 0x01);
    }
}

TEST(LostController, IsForgottenAfterAPowerCycle) {
    DriveHarness drive;
    get_going(drive);
    lose(drive);
    drive.inject(event::PowerCycle{});
    drive.reference();
    drive.move(30'000);
    EXPECT_NEAR(position(drive), 30'000, 100);
}

}  // namespace
}  // namespace servobus
