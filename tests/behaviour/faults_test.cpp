// What goes wrong outside, and what the drive makes of it: number, bits, ramp or power off, what resets it and what does
// not (004 §3.3.7, §4.1, §4.2.7; the numbers besides 50 are chosen, drive/xenax_errors.hpp).
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "drive/xenax_errors.hpp"
#include "tests/support/axis_kinds.hpp"
#include "tests/support/drive_harness.hpp"

namespace servobus {
namespace {

using namespace std::chrono_literals;
using drive::xenax::find_message;
using test::DriveHarness;
namespace event = drive::event;

// Bits of the process status register (004 §3.3.7).
constexpr unsigned psr_error = 0;
constexpr unsigned psr_reference = 1;
constexpr unsigned psr_in_motion = 2;
constexpr unsigned psr_power = 8;
constexpr unsigned psr_warning = 23;
constexpr unsigned psr_information = 24;

bool process_bit(DriveHarness& drive, unsigned number) { return drive.bit("ProcessStatusRegisterXENAX", number); }
bool in_fault(DriveHarness& drive) { return (drive.word("Statusword") & 0x004FU) == 0x0008U; }
bool in_reaction(DriveHarness& drive) { return (drive.word("Statusword") & 0x004FU) == 0x000FU; }
bool enabled(DriveHarness& drive) { return (drive.word("Statusword") & 0x006FU) == 0x0027U; }
double velocity(DriveHarness& drive) { return static_cast<double>(drive.get("TellVelocity")); }

void expect_shown(DriveHarness& drive, std::string_view name) {
    const auto* message = find_message(name);
    ASSERT_NE(message, nullptr) << name;
    EXPECT_EQ(drive.get("TellError"), message->number) << name;
    EXPECT_EQ(drive.get("XENAXErrorNumber"), message->number) << name;
    EXPECT_EQ(drive.text("TellErrorString"), message->text);
}

void expect_no_message(DriveHarness& drive) {
    EXPECT_EQ(drive.get("TellError"), 0);
    EXPECT_EQ(drive.text("TellErrorString"), "no error");
    for (const unsigned bit : {psr_error, psr_warning, psr_information}) EXPECT_FALSE(process_bit(drive, bit)) << bit;
    EXPECT_FALSE(drive.bit("Statusword", 7));
}

/// The reaction is over, and everything tells it.
void expect_fault(DriveHarness& drive, std::string_view name) {
    EXPECT_TRUE(in_fault(drive)) << name << std::hex << drive.word("Statusword");
    expect_shown(drive, name);
    EXPECT_TRUE(process_bit(drive, psr_error)) << name;
    EXPECT_FALSE(process_bit(drive, psr_power)) << name;
    EXPECT_FALSE(process_bit(drive, psr_in_motion)) << name;
    EXPECT_EQ(drive.get("TellStatus"), 9) << name;
    EXPECT_EQ(drive.get("MotorCurrentActualValue"), 0) << name;
    EXPECT_FALSE(drive.bit("Statusword", 10)) << name;
    EXPECT_FALSE(drive.bit("Statusword", 12)) << name;
}

void reset_edge(DriveHarness& drive) {
    drive.set("Controlword", 0x00);
    drive.set("Controlword", 0x80);
}

/// 0x80, 0x06, 0x07, 0x0F, and it works as before.
void expect_recovery(DriveHarness& drive) {
    reset_edge(drive);
    expect_no_message(drive);
    EXPECT_EQ(drive.word("Statusword") & 0x004FU, 0x0040U);
    drive.power_on();
    drive.run(20ms);
    EXPECT_TRUE(enabled(drive));
    expect_no_message(drive);
}

constexpr std::int64_t speed = 200'000;
constexpr std::int64_t emergency_deceleration = 1'000'000;

/// Referenced, and on the way in positive direction with constant speed.
void get_going(DriveHarness& drive) {
    drive.reference();
    drive.move(10'000);
    drive.set("AccelerationJogOrProfilePositionMode", 2'000'000);
    drive.set("SpeedJogOrProfilePositionMode", speed);
    drive.set("DecelerationQuickStop", emergency_deceleration);
    drive.set("Controlword", 0x0F);
    drive.set("TargetPositionOrDistance", 220'000);
    drive.set("Controlword", 0x1F);
    drive.run(200ms);
    ASSERT_NEAR(velocity(drive), static_cast<double>(speed), 3'000);
}

struct Mishap {
    std::string_view error;
    drive::Event cause;
    drive::Event end;  ///< of the cause
    bool persists;
};

std::vector<Mishap> ramping() {
    using enum event::SafetyFunction;
    return {{"over_temperature_motor", event::SetTemperature{85}, event::SetTemperature{25}, true},
            {"positive_limit_switch", event::LimitSwitch{event::Direction::positive, true},
             event::LimitSwitch{event::Direction::positive, false}, false},
            {"emergency_exit", event::EmergencyExit{true, false}, event::EmergencyExit{false, false}, true},
            {"ss1", event::SafetyStop{ss1, true}, event::SafetyStop{ss1, false}, true}};
}

std::vector<Mishap> switching_off() {
    using enum event::SafetyFunction;
    return {{"under_voltage", event::SetSupply{10}, event::SetSupply{48}, true},
            {"over_voltage", event::SetSupply{90}, event::SetSupply{48}, true},
            {"power_stage_dropped_out", event::CutPowerStage{}, event::RemoveObstacle{}, false},
            {"encoder_lost", event::LoseEncoder{true}, event::LoseEncoder{false}, true},
            {"sto", event::SafetyStop{sto, true}, event::SafetyStop{sto, false}, true}};
}

/// As long as the cause is there it cannot be reset; then it can, and only an edge of bit 7 does it.
void expect_reset_as_it_should(DriveHarness& drive, const Mishap& mishap) {
    if (mishap.persists) {
        reset_edge(drive);
        drive.run(1ms);
        expect_fault(drive, mishap.error);
        EXPECT_TRUE(drive.try_command("PWC")) << mishap.error;
        drive.inject(mishap.end);
        drive.run(1ms);
        expect_fault(drive, mishap.error);
        drive.set("Controlword", 0x80);  // no edge
        expect_fault(drive, mishap.error);
    } else {
        drive.inject(mishap.end);
    }
    if (mishap.error == "over_temperature_motor") drive.run(1s);
    expect_recovery(drive);
}

TEST(Fault, RampsDownWithTheEmergencyDeceleration) {
    for (const Mishap& mishap : ramping()) {
        DriveHarness drive;
        get_going(drive);
        const auto begin = drive.get("PositionActualValue");
        drive.inject(mishap.cause);
        EXPECT_TRUE(in_reaction(drive)) << mishap.error;
        expect_shown(drive, mishap.error);
        EXPECT_TRUE(process_bit(drive, psr_error));
        EXPECT_TRUE(process_bit(drive, psr_power)) << "the ramp needs power";
        drive.run(100ms);
        EXPECT_TRUE(in_reaction(drive)) << mishap.error;
        EXPECT_NEAR(velocity(drive), 100'000, 6'000) << mishap.error;
        drive.set("Controlword", 0x80);  // not yet
        EXPECT_TRUE(in_reaction(drive)) << mishap.error;
        EXPECT_TRUE(drive.runs_until([&] { return in_fault(drive); }, 130ms)) << mishap.error;
        expect_fault(drive, mishap.error);
        drive.run(100ms);
        const auto way = static_cast<double>(drive.get("PositionActualValue") - begin);
        EXPECT_NEAR(way, 20'000, 800) << mishap.error;
        expect_reset_as_it_should(drive, mishap);
        EXPECT_TRUE(process_bit(drive, psr_reference)) << mishap.error << " needs no new reference";
        drive.move(60'000);
        EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 60'000, 100);
    }
}

TEST(Fault, SwitchesOffAtOnce) {
    for (const Mishap& mishap : switching_off()) {
        DriveHarness drive;
        get_going(drive);
        drive.inject(mishap.cause);
        drive.run(1ms);
        expect_fault(drive, mishap.error);
        drive.run(2s);  // it coasts
        EXPECT_EQ(velocity(drive), 0) << mishap.error;
        expect_reset_as_it_should(drive, mishap);
        const bool lost = mishap.error == "encoder_lost";
        EXPECT_EQ(process_bit(drive, psr_reference), !lost) << mishap.error;
        if (lost) continue;
        drive.move(60'000);
        EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 60'000, 100);
    }
}

TEST(Fault, ThatComesWhileAnotherOneRampsTakesThePowerAway) {
    for (const Mishap& mishap : switching_off()) {
        DriveHarness drive;
        get_going(drive);
        drive.inject(event::EmergencyExit{true, false});
        drive.run(50ms);
        ASSERT_TRUE(in_reaction(drive));
        drive.inject(mishap.cause);
        drive.run(1ms);
        expect_fault(drive, "emergency_exit");  // the first one is told
        EXPECT_FALSE(process_bit(drive, psr_power)) << mishap.error;
    }
}

TEST(Fault, WithoutMotionAsWell) {
    auto mishaps = ramping();
    for (const Mishap& mishap : switching_off()) mishaps.push_back(mishap);
    for (const Mishap& mishap : mishaps) {
        if (mishap.error == "positive_limit_switch") continue;  // it only ends motions
        DriveHarness drive;
        drive.reference();
        drive.inject(mishap.cause);
        drive.run(2ms);
        expect_fault(drive, mishap.error);
        expect_reset_as_it_should(drive, mishap);
    }
}

// --------------------------------------------------------------------------------------------- following error, heat

// "It is not necessary to run the reference again. Just use the command PWC" (004 §4.2.7).
TEST(FollowingError, OfABlockedAxisIsOverWithPowerContinue) {
    for (const bool by_command : {false, true}) {
        DriveHarness drive;
        get_going(drive);
        drive.inject(event::BlockAxis{true});
        EXPECT_TRUE(drive.runs_until([&] { return in_fault(drive); }, 1s));
        drive.run(1ms);
        expect_fault(drive, "following_error");
        EXPECT_EQ(find_message("following_error")->number, 50);
        EXPECT_TRUE(drive.bit("Statusword", 13));
        drive.inject(event::BlockAxis{false});
        if (by_command) {
            drive.command("PWC");
            EXPECT_TRUE(enabled(drive));
        } else {
            expect_recovery(drive);
        }
        EXPECT_FALSE(drive.bit("Statusword", 13));
        expect_no_message(drive);
        EXPECT_TRUE(process_bit(drive, psr_reference));
        drive.set("Controlword", 0x0F);
        drive.move(100'000);
        EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 100'000, 100);
    }
}

TEST(FollowingError, ComesWhenTheAxisIsPushedFarFromItsPlace) {
    DriveHarness drive;
    drive.reference();
    drive.set("FollowingPositionErrorWindow", 500);
    drive.inject(event::PushAxis{200});
    EXPECT_TRUE(drive.runs_until([&] { return in_fault(drive); }, 1s));
    expect_shown(drive, "following_error");
}

TEST(OverTemperature, CanBeResetWhenItHasCooled) {
    DriveHarness drive;
    drive.reference();
    drive.inject(event::SetTemperature{85});
    drive.run(2ms);
    expect_fault(drive, "over_temperature_motor");
    drive.inject(event::SetTemperature{78});  // below the limit, but hardly
    reset_edge(drive);
    EXPECT_TRUE(in_fault(drive));
    drive.inject(event::SetTemperature{70});
    expect_recovery(drive);
}

TEST(I2t, TripsUnderContinuousLoadAndIsResetAfterARest) {
    DriveHarness drive;
    drive.reference();
    drive.set("StopCurrent", 1'000);
    drive.set("FollowingPositionErrorWindow", 100'000);
    drive.inject(event::PushAxis{28});
    drive.run(10s);
    EXPECT_TRUE(enabled(drive)) << "for ten seconds the motor bears it";
    EXPECT_GT(drive.get("I2T"), 100);
    EXPECT_TRUE(drive.runs_until([&] { return in_fault(drive); }, 100s));
    drive.run(1ms);
    expect_fault(drive, "i2t");
    reset_edge(drive);
    EXPECT_TRUE(in_fault(drive));
    drive.inject(event::PushAxis{0});
    drive.run(60s);
    expect_recovery(drive);
}

TEST(Encoder, ThatWasLostNeedsANewReference) {
    DriveHarness drive;
    get_going(drive);
    drive.inject(event::LoseEncoder{true});
    drive.run(1s);
    EXPECT_FALSE(process_bit(drive, psr_reference));
    EXPECT_EQ(drive.get("TellReferenceState"), 0);
    drive.inject(event::LoseEncoder{false});
    expect_recovery(drive);
    drive.set("TargetPositionOrDistance", 60'000);
    drive.set("Controlword", 0x1F);
    drive.run(50ms);
    expect_shown(drive, "reference_missing");
    EXPECT_FALSE(process_bit(drive, psr_in_motion));
    drive.set("Controlword", 0x00);
    drive.reference();
    expect_no_message(drive);
    drive.move(60'000);
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 60'000, 100);
}

TEST(Encoder, OfAnAbsoluteAxisKnowsItsPlaceAgain) {
    DriveHarness drive(drive::shipped_kind("rotax-rxhq-50-12t0-3"));
    drive.enter_mode(1);
    drive.power_on();
    const auto before = drive.get("PositionActualValue");
    drive.inject(event::LoseEncoder{true});
    drive.run(5ms);
    expect_fault(drive, "encoder_lost");
    drive.inject(event::LoseEncoder{false});
    expect_recovery(drive);
    EXPECT_TRUE(process_bit(drive, psr_reference));
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), static_cast<double>(before), 500);
}

TEST(UnderVoltage, KeepsThePowerStageOff) {
    DriveHarness drive;
    drive.inject(event::SetSupply{0});
    expect_no_message(drive);
    EXPECT_FALSE(drive.bit("Statusword", 4)) << "voltage enabled";
    drive.set("Controlword", 0x06);
    drive.set("Controlword", 0x07);
    EXPECT_EQ(drive.word("Statusword") & 0x006FU, 0x0021U) << "transition 3 needs the voltage";
    drive.inject(event::SetSupply{48});
    EXPECT_TRUE(drive.bit("Statusword", 4));
    drive.set("Controlword", 0x07);
    EXPECT_EQ(drive.word("Statusword") & 0x006FU, 0x0023U);
}

// ------------------------------------------------------------------------------------------------------------ wires

TEST(LimitSwitch, EndsOnlyMotionTowardsIt) {
    for (const bool towards : {false, true}) {
        DriveHarness drive;
        get_going(drive);
        drive.inject(event::LimitSwitch{towards ? event::Direction::positive : event::Direction::negative, true});
        drive.run(5ms);
        EXPECT_TRUE(process_bit(drive, towards ? 11 : 10));
        EXPECT_TRUE(drive.bit("DigitalInputsXENAX", towards ? 1 : 0));
        EXPECT_EQ(in_reaction(drive), towards);
    }
}

TEST(LimitSwitch, IsNoErrorForAnAxisThatStands) {
    DriveHarness drive;
    drive.reference();
    for (const auto direction : {event::Direction::negative, event::Direction::positive}) {
        drive.inject(event::LimitSwitch{direction, true});
    }
    drive.run(100ms);
    EXPECT_TRUE(enabled(drive));
    expect_no_message(drive);
}

TEST(LimitSwitch, CanBeLeftAfterAReset) {
    DriveHarness drive;
    get_going(drive);
    drive.inject(event::LimitSwitch{event::Direction::positive, true});
    EXPECT_TRUE(drive.runs_until([&] { return in_fault(drive); }, 1s));
    expect_shown(drive, "positive_limit_switch");
    expect_recovery(drive);  // it stands on the switch still
    drive.set("TargetPositionOrDistance", 5'000);
    const auto begin = drive.get("PositionActualValue");
    drive.set("Controlword", 0x5F);
    drive.run(100ms);
    expect_fault(drive, "positive_limit_switch");
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue") - begin), 0, 20) << "not farther onto it";
    expect_recovery(drive);
    drive.move(-20'000, true);
    EXPECT_TRUE(enabled(drive));
}

TEST(EmergencyExit, PreventsSwitchingOn) {
    DriveHarness drive;
    drive.inject(event::EmergencyExit{true, false});
    EXPECT_TRUE(process_bit(drive, 13));
    EXPECT_TRUE(drive.bit("DigitalInputsXENAX", 3));
    expect_no_message(drive);
    drive.set("Controlword", 0x06);
    drive.set("Controlword", 0x07);
    EXPECT_EQ(drive.word("Statusword") & 0x006FU, 0x0021U);
    EXPECT_TRUE(drive.try_command("REF"));
    drive.inject(event::EmergencyExit{false, false});
    drive.set("Controlword", 0x07);
    EXPECT_EQ(drive.word("Statusword") & 0x006FU, 0x0023U);
}

TEST(EmergencyExit, WithPowerOnStopsAndBlocks) {
    DriveHarness drive;
    get_going(drive);
    const auto begin = drive.get("PositionActualValue");
    drive.inject(event::EmergencyExit{true, true});
    EXPECT_TRUE(enabled(drive));
    EXPECT_TRUE(process_bit(drive, 12));
    EXPECT_TRUE(drive.bit("Statusword", 7));
    EXPECT_TRUE(process_bit(drive, psr_warning));
    EXPECT_FALSE(process_bit(drive, psr_error));
    expect_shown(drive, "emergency_exit_power_on");
    drive.run(300ms);
    EXPECT_EQ(velocity(drive), 0);
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue") - begin), 20'000, 800);
    EXPECT_TRUE(process_bit(drive, psr_power));
    drive.set("Controlword", 0x0F);
    drive.set("Controlword", 0x1F);
    drive.run(50ms);
    EXPECT_EQ(velocity(drive), 0);
    expect_shown(drive, "emergency_exit_power_on");  // not covered by what the refused motion says
    drive.inject(event::EmergencyExit{false, true});
    expect_no_message(drive);
    drive.move(20'000);
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 20'000, 100);
}

TEST(EmergencyExit, AtAnInputCountsAsSoonAsTheInputGetsTheFunction) {
    DriveHarness drive;
    drive.reference();
    drive.inject(event::SetInput{3, true});
    drive.run(1s);
    EXPECT_FALSE(drive.device().next_deadline());
    drive.set("NIF", 3);
    drive.set("TYIF", 20);
    drive.run(2ms);
    expect_fault(drive, "emergency_exit");
    drive.set("ILA", 1);  // now the wire would have to be low
    EXPECT_FALSE(process_bit(drive, 13));
    expect_recovery(drive);
    drive.set("ILA", 0);
    drive.set("TYIF", 0);
    drive.run(2ms);
    EXPECT_TRUE(in_fault(drive) || enabled(drive));
}

TEST(EmergencyExit, WithPowerOnAtAnInputIsOverWithTheInput) {
    DriveHarness drive;
    get_going(drive);
    drive.set("NIF", 4);
    drive.set("TYIF", 21);
    drive.inject(event::SetInput{4, true});
    drive.run(500ms);
    expect_shown(drive, "emergency_exit_power_on");
    drive.inject(event::SetInput{4, false});
    expect_no_message(drive);
}

// ------------------------------------------------------------------------------------------------- safety functions

TEST(SafeTorqueOff, WithoutTorqueIsNoErrorButNothingSwitchesOn) {
    DriveHarness drive;
    drive.inject(event::SafetyStop{event::SafetyFunction::sto, true});
    drive.run(10ms);
    expect_no_message(drive);
    EXPECT_TRUE(process_bit(drive, 16));
    EXPECT_FALSE(drive.bit("Statusword", 4));
    drive.set("Controlword", 0x06);
    drive.set("Controlword", 0x0F);
    EXPECT_EQ(drive.word("Statusword") & 0x006FU, 0x0021U);
    EXPECT_TRUE(drive.try_command("PWC"));
    drive.inject(event::SafetyStop{event::SafetyFunction::sto, false});
    EXPECT_FALSE(process_bit(drive, 16));
    drive.set("Controlword", 0x0F);
    EXPECT_TRUE(enabled(drive));
}

TEST(SafeStop1, EndsWithoutTorque) {
    DriveHarness drive;
    get_going(drive);
    drive.inject(event::SafetyStop{event::SafetyFunction::ss1, true});
    EXPECT_TRUE(process_bit(drive, 17));
    EXPECT_FALSE(process_bit(drive, 16));
    EXPECT_TRUE(drive.runs_until([&] { return in_fault(drive); }, 300ms));
    drive.run(2ms);
    expect_fault(drive, "ss1");
    EXPECT_TRUE(process_bit(drive, 16)) << "at standstill SS1 has become STO";
    drive.inject(event::SafetyStop{event::SafetyFunction::ss1, false});
    expect_recovery(drive);
    EXPECT_FALSE(process_bit(drive, 16));
}

TEST(SafeStop1, TakesTheTorqueAwayAfterItsTime) {
    DriveHarness drive;
    get_going(drive);
    drive.set("DecelerationQuickStop", 100'000);  // 2 s
    drive.inject(event::SafetyStop{event::SafetyFunction::ss1, true});
    drive.run(490ms);
    EXPECT_TRUE(in_reaction(drive));
    drive.run(20ms);  // StopTimeoutSMU
    expect_fault(drive, "ss1");
}

TEST(SafeStop2, StopsAndKeepsThePower) {
    DriveHarness drive;
    get_going(drive);
    drive.inject(event::SafetyStop{event::SafetyFunction::ss2, true});
    drive.run(300ms);
    EXPECT_EQ(velocity(drive), 0);
    EXPECT_TRUE(enabled(drive));
    EXPECT_TRUE(process_bit(drive, psr_power));
    EXPECT_TRUE(process_bit(drive, 18));
    EXPECT_FALSE(process_bit(drive, 19));
    expect_shown(drive, "ss2");
    EXPECT_TRUE(drive.bit("Statusword", 7));
    EXPECT_TRUE(drive.try_command("GP"));
    drive.inject(event::SafetyStop{event::SafetyFunction::ss2, false});
    expect_no_message(drive);
    drive.set("Controlword", 0x0F);
    drive.move(20'000);
}

TEST(SafeStop2, IsHitByAnAxisThatIsPushedAway) {
    DriveHarness drive;
    drive.reference();
    drive.set("FollowingPositionErrorWindow", 100'000);
    drive.inject(event::SafetyStop{event::SafetyFunction::ss2, true});
    drive.run(600ms);
    drive.inject(event::PushAxis{200});
    EXPECT_TRUE(drive.runs_until([&] { return in_fault(drive); }, 1s));
    drive.run(1ms);
    expect_fault(drive, "ss2_hit");
    EXPECT_TRUE(process_bit(drive, 19));
    drive.inject(event::PushAxis{0});
    drive.run(1s);
    // SS2 goes on: it watches the new place now.
    reset_edge(drive);
    EXPECT_FALSE(process_bit(drive, 19));
    EXPECT_FALSE(process_bit(drive, psr_error));
    drive.power_on();
    drive.run(1s);
    EXPECT_TRUE(enabled(drive));
    expect_shown(drive, "ss2");
}

TEST(SafeStop2, DoesNotWatchAnAxisWithoutPower) {
    DriveHarness drive;
    drive.reference();
    drive.set("Controlword", 0x00);
    drive.inject(event::SafetyStop{event::SafetyFunction::ss2, true});
    drive.run(1s);
    drive.inject(event::PushAxis{20});
    drive.run(100ms);
    drive.inject(event::PushAxis{0});
    drive.run(1s);
    EXPECT_FALSE(process_bit(drive, 19));
    drive.power_on();
    drive.run(1s);
    EXPECT_TRUE(enabled(drive));
}

TEST(SafelyLimitedSpeed, IsAnInformationUntilItIsTooFast) {
    DriveHarness drive;
    get_going(drive);
    drive.inject(event::SafetyStop{event::SafetyFunction::sls, true});
    drive.run(10ms);
    EXPECT_TRUE(process_bit(drive, 20));
    EXPECT_TRUE(process_bit(drive, psr_information));
    EXPECT_FALSE(drive.bit("Statusword", 7));
    expect_shown(drive, "sls");
    EXPECT_TRUE(drive.runs_until([&] { return drive.reached(); }, 5s));
    EXPECT_TRUE(enabled(drive)) << "200000 increments/s are below SpeedLimitSMU";
    drive.set("Controlword", 0x0F);
    drive.set("SpeedJogOrProfilePositionMode", 400'000);
    drive.set("TargetPositionOrDistance", 10'000);
    drive.set("Controlword", 0x1F);
    EXPECT_TRUE(drive.runs_until([&] { return in_reaction(drive); }, 1s));
    EXPECT_TRUE(drive.runs_until([&] { return in_fault(drive); }, 1s));
    drive.run(1ms);
    expect_fault(drive, "sls_speed_hit");
    EXPECT_TRUE(process_bit(drive, 21));
    drive.inject(event::SafetyStop{event::SafetyFunction::sls, false});
    expect_recovery(drive);
    EXPECT_FALSE(process_bit(drive, 21));
}

// ------------------------------------------------------------------------------------------------ power, messages

TEST(PowerCycle, ForgetsTheReferenceAndKeepsTheParameters) {
    DriveHarness drive;
    get_going(drive);
    drive.set("StopCurrent", 123);
    drive.set("MassLoad", 250);
    drive.inject(event::PowerCycle{});
    EXPECT_EQ(drive.word("Statusword"), 0x0250U);
    EXPECT_EQ(drive.get("ModesOfOperationDisplayed"), 0);
    EXPECT_EQ(drive.get("ModesOfOperationRequested"), 0);
    EXPECT_EQ(drive.word("Controlword"), 0U);
    EXPECT_FALSE(process_bit(drive, psr_reference));
    EXPECT_FALSE(process_bit(drive, 25)) << "phasing";
    EXPECT_FALSE(process_bit(drive, psr_power));
    EXPECT_EQ(drive.get("SpeedJogOrProfilePositionMode"), speed);
    EXPECT_EQ(drive.get("StopCurrent"), 123);
    EXPECT_EQ(drive.get("MassLoad"), 250);
    drive.run(1s);
    drive.set("StopCurrent", 280);
    drive.reference();
    drive.move(100'000);
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 100'000, 100);
}

TEST(PowerCycle, ResetsAnError) {
    DriveHarness drive;
    get_going(drive);
    drive.inject(event::CutPowerStage{});
    drive.run(1s);
    expect_fault(drive, "power_stage_dropped_out");
    drive.inject(event::PowerCycle{});
    expect_no_message(drive);
    drive.reference();
}

TEST(Reset, LeavesTheTextOfAnErrorThatIsThere) {
    DriveHarness drive;
    drive.reference();
    drive.inject(event::CutPowerStage{});
    drive.run(500ms);
    drive.command("RES");
    expect_fault(drive, "power_stage_dropped_out");
    EXPECT_EQ(drive.get("ModesOfOperationDisplayed"), drive.get("ModesOfOperationRequested"));
    expect_recovery(drive);
}

TEST(Warning, IsOverWithTheNextMotion) {
    DriveHarness drive;
    drive.reference();
    drive.set("PG", 1);
    expect_shown(drive, "program_empty");
    EXPECT_TRUE(drive.bit("Statusword", 7));
    EXPECT_TRUE(process_bit(drive, psr_warning));
    EXPECT_FALSE(process_bit(drive, psr_error));
    EXPECT_TRUE(enabled(drive));
    EXPECT_EQ(drive.get("TellStatus"), 1);
    drive.move(70'000);
    expect_no_message(drive);
}

TEST(Information, OfASoftLimitIsOverWithTheNextMotionInside) {
    for (const std::int64_t mode : {1, -1}) {
        DriveHarness drive;
        drive.reference();
        drive.set("SoftLimitPositionNegative", 10'000);
        drive.set("SoftLimitPositionPositive", 100'000);
        drive.move(150'000);
        EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 100'000, 100);
        expect_shown(drive, "soft_limit");
        EXPECT_TRUE(drive.bit("Statusword", 11));
        EXPECT_TRUE(process_bit(drive, psr_information));
        EXPECT_FALSE(drive.bit("Statusword", 7));
        drive.set("Controlword", 0x0F);
        drive.enter_mode(mode);
        if (mode == 1) {
            drive.move(60'000);
        } else {
            drive.set("Controlword", 0x1F);
            drive.run(100ms);
        }
        EXPECT_FALSE(drive.bit("Statusword", 11)) << mode;
        expect_no_message(drive);
    }
}

TEST(Error, CoversAWarningAndTheResetClearsBoth) {
    DriveHarness drive;
    drive.reference();
    drive.set("PG", 1);
    drive.inject(event::CutPowerStage{});
    drive.run(1ms);
    expect_shown(drive, "power_stage_dropped_out");
    EXPECT_TRUE(drive.bit("Statusword", 7));
    expect_recovery(drive);
}

}  // namespace
}  // namespace servobus
