// Every direct command (0x65/1/0; 000 §2.3.2.1, 004 §3.4.1): what it does, and when it is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "drive/xenax_commands.hpp"
#include "tests/support/axis_kinds.hpp"
#include "tests/support/drive_bench.hpp"

namespace servobus {
namespace {

using namespace std::chrono_literals;
using drive::Refusal;
using test::DriveBench;
namespace psr = test::psr;

drive::AxisKind rotative() { return drive::shipped_kind("third-party-rotative"); }

/// The commands that have no mnemonic go by their name.
std::string word_of(const drive::DirectCommand& command) {
    return std::string(command.mnemonic.empty() ? command.name : command.mnemonic);
}

double ms(drive::Time time) { return std::chrono::duration<double, std::milli>(time).count(); }

// ------------------------------------------------------------------------------------------------- Reference

// The times of a real drive: 1.55 s for the electrical angle, the way over the marks, 0.11 to 0.13 s until it says that
// it knows where it is.
TEST(CommandREF, PowersOnAndTakesTheTimeOfARealDrive) {
    DriveBench drive;
    EXPECT_FALSE(drive.psr(psr::power));
    drive.command("REF");
    drive.run(5ms);
    EXPECT_EQ(drive.get("TellStatus"), 1);
    EXPECT_FALSE(drive.psr(psr::phasing));
    const auto begin = drive.now();
    EXPECT_TRUE(drive.runs_until([&] { return drive.moving(); }, 3s));
    EXPECT_NEAR(ms(drive.now() - begin), 1'550, 60);
    EXPECT_EQ(drive.get("TellStatus"), 2);
    EXPECT_EQ(drive.tpsr(), 0x0200'0154U);
    const auto search = drive.now();
    EXPECT_TRUE(drive.runs_until([&] { return !drive.moving(); }, 3s));
    EXPECT_NEAR(ms(drive.now() - search), 860, 100);
    EXPECT_EQ(drive.get("TellStatus"), 1);
    EXPECT_EQ(drive.tpsr(), 0x0200'0158U);
    const auto settling = drive.now();
    EXPECT_TRUE(drive.runs_until([&] { return drive.psr(psr::reference); }, 3s));
    EXPECT_NEAR(ms(drive.now() - settling), 120, 15);
    EXPECT_EQ(drive.tpsr(), 0x0200'015AU);
    EXPECT_EQ(drive.get("TellReferenceState"), 1);
}

TEST(CommandREF, AgainUnderPowerNeedsNoPhasing) {
    DriveBench drive;
    drive.refer();
    drive.command("REF");
    EXPECT_FALSE(drive.psr(psr::reference)) << "cleared at its start";
    const auto begin = drive.now();
    EXPECT_TRUE(drive.runs_until([&] { return drive.moving(); }, 1s));
    EXPECT_LE(drive.now() - begin, 10ms);
    EXPECT_EQ(drive.tpsr(), 0x0200'0154U);
    EXPECT_TRUE(drive.runs_until([&] { return drive.psr(psr::reference); }, 3s));
    EXPECT_NEAR(ms(drive.now() - begin), 1'040, 150);
}

TEST(CommandREF, SurvivesPQ) {
    DriveBench drive;
    drive.refer();
    drive.command("PQ");
    EXPECT_TRUE(drive.psr(psr::reference));
    EXPECT_EQ(drive.get("TellStatus"), 0);
}

TEST(CommandREF, TakesTheDirectionOfDRHR) {
    for (const std::int64_t direction : {0, 1}) {
        DriveBench drive;
        drive.set("DirectionReference", direction);
        drive.command("REF");
        EXPECT_TRUE(drive.runs_until([&] { return drive.moving(); }, 3s));
        drive.run(100ms);
        EXPECT_EQ(drive.get("TellVelocity") > 0, direction == 0);
    }
}

TEST(CommandREF, OfAGantrySaysSo) {
    DriveBench drive;
    drive.set("DirectionReference", 2);
    drive.refer();
    EXPECT_TRUE(drive.psr(psr::gantry));
    drive.set("DirectionReference", 0);
    drive.refer();
    EXPECT_FALSE(drive.psr(psr::gantry));
}

TEST(CommandREF, OfARotativeAxisFollowsDRHAndDRZ) {
    for (const std::int64_t home : {1, 2}) {
        for (const std::int64_t z_mark : {1, 2}) {
            DriveBench drive(rotative());
            drive.set("DirHome", home);
            drive.set("ZMark", z_mark);
            drive.set("ReferenceSpeedForExternalReferenceSensor", 20'000);
            drive.set("ReferenceSpeedForInternalZMark", 5'000);
            drive.refer();
            drive.go(0);
            EXPECT_LE(std::abs(drive.position()), 2);
        }
    }
}

TEST(CommandREF, IsRefusedInMotionAndWithoutSupply) {
    DriveBench drive;
    drive.refer();
    drive.command("JP");
    drive.run(20ms);
    drive.refuses("REF");
    drive.command("SM");
    EXPECT_TRUE(drive.stands_within());
    drive.command("PQ");
    drive.inject(drive::event::SetSupply{0});
    drive.run(10ms);
    for (const auto* command : {"REF", "RSTO", "PWC", "PWR"}) drive.refuses(command);
}

TEST(CommandREF, IsRefusedUnderSafeStop) {
    DriveBench drive;
    drive.refer();
    drive.inject(drive::event::SafetyStop{drive::event::SafetyFunction::ss2, true});
    drive.run(5ms);
    drive.refuses("REF");
    drive.refuses("RSTO");
    drive.refuses("MLC");
    drive.refuses("GP");
}

TEST(CommandREF, WaitsForTheBrake) {
    DriveBench drive;
    drive.set("PreselectedOutputFunction", 1);
    drive.set("TypeOfOutputFunction", 11);
    drive.set("BrakeDelay", 200);
    drive.command("PWR");
    drive.run(150ms);
    EXPECT_NE(drive.word("Statusword") & 0x6FU, 0x27U);
    drive.run(60ms);
    EXPECT_EQ(drive.word("Statusword") & 0x6FU, 0x27U);
    drive.command("PQ");
    drive.run(300ms);
    drive.refer();
    EXPECT_TRUE(drive.psr(psr::reference));
}

TEST(CommandRSTO, TakesTheStopAsItsPlace) {
    for (const bool positive : {true, false}) {
        DriveBench drive(drive::shipped_kind("elax-ex-50f20"));
        drive.set("MechanicalLimitPositionPositive", 50'800);
        drive.set("MechanicalLimitPositionNegative", -800);
        drive.set("DirectionReference", positive ? 0 : 1);
        drive.command("RSTO");
        EXPECT_TRUE(drive.runs_until([&] { return drive.psr(psr::reference); }, 60s));
        EXPECT_NEAR(drive.position(), positive ? 50'800 : -800, 30);
        drive.go(25'000);
        EXPECT_NEAR(drive.position(), 25'000, 2);
    }
}

TEST(CommandRSTO, IsForLinearAxes) {
    DriveBench drive(rotative());
    drive.refuses("RSTO", Refusal::not_configured);
    drive.refuses("MLC", Refusal::not_configured);
}

TEST(CommandMLC, FindsBothStops) {
    DriveBench drive(drive::shipped_kind("elax-ex-50f20"));
    drive.refuses("MLC");
    drive.refer();
    drive.go(25'000);
    drive.command("MLC");
    EXPECT_TRUE(drive.runs_until([&] { return !drive.moving(); }, 120s));
    EXPECT_NEAR(static_cast<double>(drive.get("MechanicalLimitPositionNegative")), -800, 60);
    EXPECT_NEAR(static_cast<double>(drive.get("MechanicalLimitPositionPositive")), 50'800, 60);
    EXPECT_NEAR(static_cast<double>(drive.get("DetectedMechanicalPositionPositive")), 50'800, 60);
    drive.run(100ms);
    EXPECT_NEAR(drive.position(), 25'000, 2);
    EXPECT_EQ(drive.get("TellError"), 0);
}

TEST(CommandAREF1, MakesReferenceModeReference) {
    DriveBench drive;
    EXPECT_EQ(drive.get("AutomaticReference"), 0);
    drive.command("AREF1");
    EXPECT_EQ(drive.get("AutomaticReference"), 1);
    drive.power_on();
    drive.set("ModesOfOperationRequested", 6);
    EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 12); }, 10s));
    EXPECT_TRUE(drive.psr(psr::reference));
}

TEST(CommandAREF1, AlsoWhenThePowerComesLater) {
    DriveBench drive;
    drive.command("AREF1");
    drive.enter_mode(6);
    drive.power_on();
    EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 12); }, 10s));
}

// ------------------------------------------------------------------------------------------------- Power

TEST(CommandPW, IsForRotativeMotors) {
    DriveBench linear;
    linear.refuses("PW", Refusal::not_configured);
    DriveBench drive(rotative());
    drive.command("PW");
    EXPECT_TRUE(drive.psr(psr::power));
    EXPECT_TRUE(drive.psr(psr::phasing));
    EXPECT_EQ(drive.word("Statusword") & 0x6FU, 0x27U);
    EXPECT_EQ(drive.get("TellStatus"), 1);
    drive.command("PQ");
    EXPECT_FALSE(drive.psr(psr::power));
    EXPECT_EQ(drive.get("TellStatus"), 0);
}

TEST(CommandPWC, ContinuesWhereTheAxisStands) {
    DriveBench drive;
    drive.refuses("PWC");  // a linear axis does not know its electrical angle yet
    drive.refer();
    drive.go(80'000);
    drive.command("PQ");
    drive.inject(drive::event::PushAxis{5});
    drive.run(100ms);
    drive.inject(drive::event::PushAxis{0});
    drive.run(200ms);
    const double where = drive.position();
    EXPECT_GT(where, 81'000) << "without power it can be pushed";
    drive.command("PWC");
    drive.run(100ms);
    EXPECT_NEAR(drive.position(), where, 3);
    EXPECT_TRUE(drive.psr(psr::reference));
    drive.go(90'000);
    EXPECT_NEAR(drive.position(), 90'000, 2);
}

TEST(CommandPWC, ResetsAnErrorWhoseCauseIsGone) {
    DriveBench drive;
    drive.refer();
    drive.inject(drive::event::BlockAxis{true});
    drive.set("GoImmediately", 150'000);
    EXPECT_TRUE(drive.runs_until([&] { return drive.get("TellError") == 50; }, 5s));
    EXPECT_EQ(drive.get("TellStatus"), 9);
    EXPECT_TRUE(drive.runs_until([&] { return !drive.psr(psr::power); }, 5s));
    drive.inject(drive::event::BlockAxis{false});
    drive.command("PWC");
    EXPECT_EQ(drive.get("TellError"), 0);
    EXPECT_EQ(drive.get("TellStatus"), 1);
    drive.inject(drive::event::SafetyStop{drive::event::SafetyFunction::sto, true});
    drive.run(10ms);
    for (const auto* command : {"PWC", "PWR", "REF"}) drive.refuses(command);
    drive.inject(drive::event::SafetyStop{drive::event::SafetyFunction::sto, false});
    drive.command("PWC");
    EXPECT_TRUE(drive.psr(psr::power));
}

TEST(CommandPWR, ForgetsTheReference) {
    DriveBench drive;
    drive.refer();
    drive.set("GoImmediately", 100'000);
    drive.run(50ms);
    drive.refuses("PWR");
    EXPECT_TRUE(drive.stands_within());
    drive.command("PWR");
    EXPECT_FALSE(drive.psr(psr::reference));
    EXPECT_TRUE(drive.psr(psr::power));
    EXPECT_TRUE(drive.psr(psr::phasing));
    drive.refuses("GP");
}

TEST(CommandPQ, StopsWhatRuns) {
    DriveBench drive;
    drive.refer();
    drive.command("JP");
    drive.run(100ms);
    drive.command("PQ");
    EXPECT_FALSE(drive.psr(psr::power));
    EXPECT_EQ(drive.word("Statusword") & 0x4FU, 0x40U);
    drive.run(1s);
    EXPECT_EQ(drive.get("TellVelocity"), 0);
    EXPECT_EQ(drive.get("MotorCurrentActualValue"), 0);
}

// ------------------------------------------------------------------------------------------------- Motion

TEST(CommandGP, DrivesToPOWithSPAndAC) {
    DriveBench drive;
    drive.refuses("GP");
    drive.refer();
    drive.set("Position", 120'000);
    drive.set("Speed", 50'000);
    drive.set("Acceleration", 500'000);
    const double way = 120'000 - drive.position();
    const auto begin = drive.now();
    drive.command("GP");
    EXPECT_TRUE(drive.moving());
    double fastest = 0;
    EXPECT_TRUE(drive.runs_until(
        [&] {
            fastest = std::max(fastest, static_cast<double>(drive.get("TellVelocity")));
            return !drive.moving();
        },
        10s));
    EXPECT_NEAR(fastest, 50'000, 1'500);
    EXPECT_NEAR(ms(drive.now() - begin), 1000 * (way / 50'000 + 0.1 / 0.9), 15);
    drive.run(50ms);
    EXPECT_NEAR(drive.position(), 120'000, 2);
    EXPECT_EQ(drive.tpsr(), 0x0200'015AU);
}

TEST(CommandGP, IsRefusedWhereItCannotBe) {
    DriveBench drive;
    drive.refer();
    drive.set("Position", 100'000);
    drive.command("GP");
    drive.run(30ms);
    for (const auto* command : {"GP", "GW", "JP", "JN", "FCT1", "FCT2", "IFDCP", "IFDCN", "MLC", "RSTO", "RES", "RESM"})
        drive.refuses(command);
    drive.refuses_write("GoImmediately", 0);
    drive.refuses_write("StartIndexNumber", 1);
    drive.refuses_write("DriveIForce", 1);
    EXPECT_TRUE(drive.stands_within());
    drive.run(50ms);
    EXPECT_NEAR(drive.position(), 100'000, 2);
    for (const std::int64_t mode : {6, 8}) {
        drive.enter_mode(mode);
        for (const auto* command : {"GP", "GW", "JP", "JN"}) drive.refuses(command);
        drive.refuses_write("GoImmediately", 0);
    }
    drive.enter_mode(-1);  // there the control word says how the axis runs
    drive.refuses("JP");
    drive.refuses("JN");
    drive.enter_mode(1);
    drive.command("PQ");
    for (const auto* command : {"GP", "GW", "JP", "JN"}) drive.refuses(command);
}

TEST(CommandGW, DrivesItsWayFromWhereItStands) {
    DriveBench drive;
    drive.refer();
    drive.go(100'000);
    for (const std::int64_t way : {20'000, -35'000}) {
        const double from = drive.position();
        drive.set("Way", way);
        drive.command("GW");
        EXPECT_TRUE(drive.stands_within());
        drive.run(50ms);
        EXPECT_NEAR(drive.position(), from + static_cast<double>(way), 3);
    }
}

TEST(CommandJPAndJN, ChangeTheDirectionWithoutAStop) {
    DriveBench drive;
    drive.refer();
    drive.go(100'000);
    drive.set("Speed", 40'000);
    drive.command("JP");
    drive.run(200ms);
    EXPECT_NEAR(static_cast<double>(drive.get("TellVelocity")), 40'000, 1'000);
    EXPECT_EQ(drive.tpsr(), 0x0200'0156U);
    drive.command("JN");
    drive.run(300ms);
    EXPECT_NEAR(static_cast<double>(drive.get("TellVelocity")), -40'000, 1'000);
    drive.set("Speed", 10'000);  // counts at once
    drive.run(200ms);
    EXPECT_NEAR(static_cast<double>(drive.get("TellVelocity")), -10'000, 1'000);
    drive.command("SM");
    EXPECT_TRUE(drive.stands_within(1s));
    drive.run(100ms);
    EXPECT_EQ(drive.get("TellVelocity"), 0);
    EXPECT_EQ(drive.tpsr(), 0x0200'015AU);
}

TEST(CommandSM, StopsEveryKindOfMotion) {
    DriveBench drive;
    drive.refer();
    drive.go(60'000);
    drive.command("SM");  // nothing to stop
    EXPECT_FALSE(drive.moving());
    drive.set("GoImmediately", 200'000);
    drive.run(300ms);
    drive.command("SM");
    EXPECT_TRUE(drive.stands_within(1s));
    EXPECT_LT(drive.position(), 150'000);
    EXPECT_TRUE(drive.psr(psr::power));
    drive.command("REF");
    drive.run(200ms);
    drive.command("SM");
    EXPECT_TRUE(drive.stands_within(1s));
    drive.run(500ms);
    EXPECT_FALSE(drive.psr(psr::reference));
    drive.refer();
}

TEST(CommandSM, EndsACalibration) {
    DriveBench drive;
    drive.refer();
    drive.go(60'000);
    for (const auto* command : {"FC", "IFDCP"}) {
        drive.command(command);
        drive.run(50ms);
        drive.command("SM");
        EXPECT_TRUE(drive.stands_within(1s));
        EXPECT_FALSE(drive.psr(psr::force_calibration)) << command;
        EXPECT_FALSE(drive.psr(psr::drift_compensation)) << command;
        EXPECT_EQ(drive.get("ForceCalibrationValid"), 0);
        EXPECT_TRUE(drive.psr(psr::in_position));
    }
}

TEST(CommandGZ, TurnsToTheZMark) {
    DriveBench linear;
    linear.refer();
    linear.refuses("GZ", Refusal::not_configured);
    DriveBench drive(rotative());
    drive.set("ReferenceSpeedForExternalReferenceSensor", 20'000);
    drive.set("ReferenceSpeedForInternalZMark", 5'000);
    drive.refuses("GZ");
    drive.refer();
    drive.set("ReferenceSpeedForInternalZMark", 50'000);
    for (const std::int64_t from : {3 * 24'000 + 4'000, -2 * 24'000 - 7'000}) {
        drive.go(from);
        drive.command("GZ");
        EXPECT_TRUE(drive.stands_within());
        drive.run(100ms);
        EXPECT_NEAR(drive.position(), from > 0 ? 3 * 24'000 : -2 * 24'000, 3);
    }
}

// ------------------------------------------------------------------------------------------------- Force calibration

TEST(CommandFC, NeedsTheModeThatIsNone) {
    DriveBench drive;
    drive.refer();
    drive.enter_mode(1);
    drive.refuses("FC");
    drive.refuses_write("CoggingReferenceDriveAutomatic", 0);
    drive.enter_mode(0);
    EXPECT_EQ(drive.get("ForceCalibrationValid"), 0);
    drive.go(60'000);
    drive.set("Way", 48'000);
    drive.command("FC");
    drive.run(10ms);
    EXPECT_TRUE(drive.psr(psr::force_calibration));
    EXPECT_TRUE(drive.psr(psr::in_motion));
    EXPECT_TRUE(drive.runs_until([&] { return !drive.psr(psr::force_calibration); }, 30s));
    EXPECT_EQ(drive.get("ForceCalibrationValid"), 1);
    EXPECT_NEAR(drive.position(), 60'000, 20);
}

/// The spread of I_Force over a slow move through one period of the cogging.
double spread_of_i_force(DriveBench& drive) {
    drive.go(60'000);
    drive.set("Speed", 20'000);
    drive.set("GoImmediately", 100'000);
    drive.run(200ms);
    double least = 1e9;
    double most = -1e9;
    while (drive.position() < 95'000) {
        drive.run(2ms);
        const auto force = static_cast<double>(drive.get("IForceActual"));
        least = std::min(least, force);
        most = std::max(most, force);
    }
    EXPECT_TRUE(drive.stands_within());
    drive.set("Speed", 100'000);
    return most - least;
}

TEST(CommandFC, TakesTheCoggingOutOfIForce) {
    DriveBench drive;
    drive.refer();
    const double before = spread_of_i_force(drive);
    EXPECT_GT(before, 250);  // 2 x 0.6 N at 3.57 N/A
    drive.go(60'000);
    drive.set("Way", 48'000);
    drive.command("FC");
    EXPECT_TRUE(drive.stands_within());
    EXPECT_LT(spread_of_i_force(drive), before / 4);
}

TEST(CommandFCT, LetsTheAxisBePushedByHand) {
    DriveBench drive;
    drive.refuses("FCT1");
    drive.refer();
    drive.go(60'000);
    drive.set("Way", 48'000);
    drive.command("FC");
    EXPECT_TRUE(drive.stands_within());
    for (const auto* command : {"FCT1", "FCT2"}) {
        const double from = drive.position();
        drive.inject(drive::event::PushAxis{2.5});
        drive.run(100ms);
        EXPECT_NEAR(drive.position(), from, 20) << "the controller holds it";
        drive.inject(drive::event::PushAxis{0});
        drive.command(command);
        drive.run(100ms);
        EXPECT_NEAR(drive.position(), from, 3'000);
        drive.inject(drive::event::PushAxis{2.5});
        EXPECT_TRUE(drive.runs_until([&] { return drive.position() > from + 5'000; }, 1s)) << command;
        drive.inject(drive::event::PushAxis{-2.5});
        EXPECT_TRUE(drive.runs_until([&] { return drive.position() < from; }, 2s)) << command;
        drive.inject(drive::event::PushAxis{0});
        drive.run(200ms);
        EXPECT_EQ(drive.get("TellError"), 0);
        // A set point would move, and the axis would not.
        drive.refuses("GP");
        drive.refuses("JP");
        drive.refuses_write("GoImmediately", 0);
        drive.command("FCT0");
        drive.run(50ms);
        EXPECT_TRUE(drive.psr(psr::in_position));
        drive.go(60'000);
        EXPECT_NEAR(drive.position(), 60'000, 2);
    }
}

// With the compensation a push that only just overcomes the friction moves the axis over every cogging pole; without
// it the axis stays in one.
TEST(CommandFCT, OneCompensatesAndTwoDoesNot) {
    for (const bool compensated : {true, false}) {
        DriveBench drive;
        drive.refer();
        drive.go(60'000);
        drive.set("Way", 48'000);
        drive.command("FC");
        EXPECT_TRUE(drive.stands_within());
        drive.command(compensated ? "FCT1" : "FCT2");
        drive.inject(drive::event::PushAxis{1.4});
        drive.run(3s);
        EXPECT_EQ(drive.position() > 100'000, compensated) << drive.position();
    }
}

TEST(CommandFCT, IsForgottenOverAPowerCycle) {
    DriveBench drive;
    drive.refer();
    drive.command("FCT2");
    drive.refuses("REF");
    drive.inject(drive::event::PowerCycle{});
    drive.refer();
    drive.go(70'000);
    EXPECT_NEAR(drive.position(), 70'000, 2);
}

TEST(CommandIFDC, TakesADriftOutOfIForce) {
    for (const bool positive : {true, false}) {
        DriveBench drive;
        drive.refuses("IFDCP");
        drive.refuses("IFDCN");
        drive.refer();
        drive.go(60'000);
        drive.set("Way", 48'000);
        drive.command("FC");
        EXPECT_TRUE(drive.stands_within());
        drive.inject(drive::event::PushAxis{-0.9});  // something hangs on the axis now
        drive.run(100ms);
        const auto mean = [&] {
            double sum = 0;
            for (const std::int64_t target : {70'000, 60'000}) {
                drive.set("GoImmediately", target);
                drive.run(70ms);
                for (int i = 0; i < 20; ++i) {
                    drive.run(2ms);
                    sum += static_cast<double>(drive.get("IForceActual")) / 40;
                }
                EXPECT_TRUE(drive.stands_within());
            }
            return sum;
        };
        drive.set("Speed", 50'000);
        EXPECT_NEAR(mean(), 900 / 3.571, 15);
        const double from = drive.position();
        drive.command(positive ? "IFDCP" : "IFDCN");
        drive.run(10ms);
        EXPECT_TRUE(drive.psr(psr::drift_compensation));
        drive.run(90ms);
        EXPECT_EQ(drive.position() > from, positive);
        EXPECT_TRUE(drive.runs_until([&] { return !drive.psr(psr::drift_compensation); }, 5s));
        EXPECT_NEAR(mean(), 0, 15);
        EXPECT_EQ(drive.get("TellError"), 0);
    }
}

// ------------------------------------------------------------------------------------------------- Initialisation

TEST(CommandRES, SetsWhatCanBeSetBackAndTellsTheTruthStill) {
    DriveBench drive;
    drive.refer();
    drive.enter_mode(1);
    drive.set("Speed", 77'000);
    drive.set("PreselectedIndexNumber", 3);
    drive.set("DistanceOfSelectedIndex", 1234);
    drive.set("SoftLimitPositionPositive", 1'000);
    drive.set("SetOutputHexMask", 0xFF);
    drive.refuses("RES");
    drive.command("PQ");
    const auto where = drive.get("PositionActualValue");
    drive.command("RES");
    EXPECT_EQ(drive.get("Speed"), 100'000);
    EXPECT_EQ(drive.get("PreselectedIndexNumber"), 1);
    drive.set("PreselectedIndexNumber", 3);
    EXPECT_EQ(drive.get("DistanceOfSelectedIndex"), 0);
    EXPECT_EQ(drive.get("SoftLimitPositionPositive"), 0);
    EXPECT_EQ(drive.get("TellOutputHex"), 0);
    EXPECT_EQ(drive.get("PositionActualValue"), where);
    EXPECT_TRUE(drive.psr(psr::reference));
    EXPECT_EQ(drive.get("ModesOfOperationRequested"), 1);
    EXPECT_EQ(drive.get("ModesOfOperationDisplayed"), 1);
    EXPECT_EQ(drive.text("MotorType"), "230101");
    EXPECT_EQ(drive.get("MassMotor"), 320);
}

TEST(CommandRES, LeavesAMessageItsText) {
    DriveBench drive;
    drive.refer();
    drive.inject(drive::event::LoseEncoder{true});
    drive.run(10ms);
    EXPECT_EQ(drive.get("TellError"), 20);
    const auto text = drive.text("TellErrorString");
    drive.command("RES");
    EXPECT_EQ(drive.get("TellError"), 20);
    EXPECT_EQ(drive.text("TellErrorString"), text);
}

TEST(CommandRESM, SetsWhatDependsOnTheMotorBack) {
    DriveBench drive(rotative());
    const auto mass = drive.get("MassMotor");
    drive.set("MassMotor", 1);
    drive.set("ForceConstantOfMotor", 1);
    drive.set("BandwidthPositionController", 10);
    drive.set("MassLoad", 5);
    drive.set("EncoderIncrements", 100);
    drive.set("PolePairs", 1);
    drive.set("Speed", 77'000);
    drive.command("RESM");
    EXPECT_EQ(drive.get("MassMotor"), mass);
    EXPECT_EQ(drive.get("ForceConstantOfMotor"), 120);
    EXPECT_EQ(drive.get("BandwidthPositionController"), 50);
    EXPECT_EQ(drive.get("MassLoad"), 0);
    EXPECT_EQ(drive.get("EncoderIncrements"), 24'000);
    EXPECT_EQ(drive.get("PolePairs"), 4);
    EXPECT_EQ(drive.get("Speed"), 77'000);
    drive.command("PW");
    drive.refuses("RESM");
}

TEST(CommandCP, CapturesAtEdgesOfItsInput) {
    for (const bool small : {false, true}) {
        DriveBench drive(drive::AxisKind{}, small ? "48v8" : "75v8s");
        const int input = small ? 4 : 12;
        const int other = small ? 12 : 4;
        const auto pulse = [&](int number) {
            drive.inject(drive::event::SetInput{number, true});
            drive.run(1ms);
            drive.inject(drive::event::SetInput{number, false});
            drive.run(1ms);
        };
        drive.refer();
        drive.go(70'000);
        drive.run(1s);
        pulse(input);
        EXPECT_EQ(drive.get("TellCapturedPosition1"), 0) << "not switched on";
        drive.command("CP121");
        pulse(other);
        EXPECT_EQ(drive.get("TellCapturedPosition1"), 0);
        pulse(input);  // while the axis stands, too
        EXPECT_NEAR(static_cast<double>(drive.get("TellCapturedPosition1")), 70'000, 2);
        drive.set("GoImmediately", 90'000);
        drive.run(100ms);
        const double where = drive.position();
        pulse(input);
        EXPECT_NEAR(static_cast<double>(drive.get("TellCapturedPosition2")), where, 150);
        EXPECT_EQ(drive.get("TellCapturePosBuffer1"), drive.get("TellCapturedPosition2"));
        EXPECT_EQ(drive.get("TellCapturePosBuffer2"), drive.get("TellCapturedPosition1"));
        EXPECT_TRUE(drive.stands_within());
        drive.command("CP120");
        pulse(input);
        EXPECT_EQ(drive.get("TellCapturedPosition3"), 0);
        drive.command("CLCP");
        EXPECT_EQ(drive.get("TellCapturedPosition1"), 0);
        EXPECT_EQ(drive.get("TellCapturePosBuffer1"), 0);
    }
}

TEST(CommandCLPO, IsForRotativeAxesAtStandstill) {
    DriveBench linear;
    linear.refer();
    linear.refuses("CLPO", Refusal::not_configured);
    DriveBench drive(rotative());
    drive.command("PW");
    drive.go(5'000);
    drive.command("JP");
    drive.run(50ms);
    drive.refuses("CLPO");
    drive.command("SM");
    EXPECT_TRUE(drive.stands_within());
    drive.run(100ms);
    drive.command("CLPO");
    EXPECT_EQ(drive.get("PositionActualValue"), 0);
    drive.run(100ms);
    EXPECT_NEAR(drive.position(), 0, 2) << "the axis itself does not move";
    drive.go(2'000);
    EXPECT_NEAR(drive.position(), 2'000, 2);
}

TEST(CommandDMBUS, IsTakenAtAnyTime) {
    DriveBench drive;
    drive.command("DMBUS");
    drive.refer();
    drive.command("JP");
    drive.command("DMBUS");
    EXPECT_TRUE(drive.moving());
}

// ------------------------------------------------------------------------------------------------- Force control

TEST(CommandForceMonitoring, EvaluatesACyclicMotion) {
    DriveBench drive;
    drive.reference(1, 8);
    drive.set("PreselectedSectorNumber", 1);
    drive.set("SectorIForceStart", drive.get("PositionActualValue") + 2'000);
    drive.set("SectorIForceEnd", drive.get("PositionActualValue") + 8'000);
    drive.set("IForceLow", -2'000);
    drive.set("IForceHigh", 2'000);
    auto target = drive.get("PositionActualValue");
    drive.set("TargetPositionOrDistance", target);
    drive.set("Controlword", 0x1F);
    const auto way = [&](int step) {
        for (int i = 0; i < 200; ++i) {
            target += step;
            drive.set("TargetPositionOrDistance", target);
            drive.run(1ms);
        }
        drive.run(50ms);
    };
    drive.command("StartForceMonitoring");
    way(50);
    EXPECT_FALSE(drive.psr(psr::force_in_sector)) << "not before it is finished";
    drive.command("FinishForceMonitoring");
    EXPECT_TRUE(drive.psr(psr::force_in_sector));
    EXPECT_EQ(drive.get("SectorIForceCurveFailed"), 0);
    EXPECT_GT(drive.get("IForcePeak"), 5);
    drive.set("IForceHigh", 1);
    drive.set("IForceLow", 0);
    drive.command("StartForceMonitoring");
    EXPECT_FALSE(drive.psr(psr::force_in_sector));
    way(-50);
    drive.command("FinishForceMonitoring");
    EXPECT_FALSE(drive.psr(psr::force_in_sector));
    EXPECT_EQ(drive.get("SectorIForceCurveFailed"), 1);
}

TEST(CommandTPSO, MakesThePositionTheOffset) {
    DriveBench drive;
    drive.refer();
    drive.go(75'000);
    drive.set("SectorIForceStart", 1'000);
    drive.set("SectorIForceEnd", 2'000);
    EXPECT_FALSE(drive.psr(psr::in_sector));
    drive.command("TPSO");
    EXPECT_EQ(drive.get("SetSectorOffset"), drive.get("PositionActualValue"));
    EXPECT_FALSE(drive.psr(psr::in_sector));
    drive.go(76'500);
    EXPECT_TRUE(drive.psr(psr::in_sector));
    drive.go(78'000);
    EXPECT_FALSE(drive.psr(psr::in_sector));
}

/// Presses with LF against something soft, so that FA has something to show.
void press(DriveBench& drive, std::int64_t limit_mn) {
    drive.refer();
    drive.go(90'000);
    drive.set("Speed", 20'000);
    drive.inject(drive::event::PutObstacle{100'000, 10, false});
    drive.set("LimitForce", limit_mn);
    drive.set("GoImmediately", 110'000);
    drive.run(2s);
}

TEST(CommandCLFO, MakesThePresentForceZero) {
    DriveBench drive;
    press(drive, 5'000);
    EXPECT_NEAR(static_cast<double>(drive.get("ForceActual")), 5'000, 250);
    drive.command("PQ");
    drive.command("PWC");  // holds where it stands
    drive.set("LimitForce", 0);
    drive.run(1s);
    const auto before = drive.get("ForceActual");
    EXPECT_GT(before, 500);
    drive.command("CLFO");
    EXPECT_EQ(drive.get("ForceActual"), 0) << "at once";
    drive.command("CLFO");
    drive.run(100ms);
    EXPECT_NEAR(static_cast<double>(drive.get("ForceActual")), 0, 20);
    drive.inject(drive::event::RemoveObstacle{});
    drive.run(200ms);
    EXPECT_NEAR(static_cast<double>(drive.get("ForceActual")), -static_cast<double>(before), 40);
    drive.set("ClearForceOffset", 1);
    EXPECT_EQ(drive.get("ForceActual"), 0);
}

TEST(CommandCLFO, NeedsTheLoadCell) {
    for (const auto* variant : {"75v8", "48v8"}) {
        DriveBench drive(drive::AxisKind{}, variant);
        drive.refuses("CLFO", Refusal::not_configured);
        drive.refuses_write("ClearForceOffset", 1, Refusal::not_configured);
    }
}

// ------------------------------------------------------------------------------------------------- All of them

TEST(DirectCommands, AllAreKnownAndNoOtherIs) {
    DriveBench drive;
    EXPECT_EQ(drive::direct_commands().size(), 31U);
    const auto& row = drive.row("DirectCommands");
    for (const std::int64_t number : {0x1040, 0x3060, 0x7000, 0x7001, 0x1, 0xFFFF})
        EXPECT_TRUE(drive.device().write(row, number)) << number;
}

TEST(DirectCommands, NoneThatIsRefusedLeavesATrace) {
    for (const bool linear : {true, false}) {
        for (const auto& command : drive::direct_commands()) {
            SCOPED_TRACE(word_of(command));
            DriveBench drive(linear ? drive::AxisKind{} : rotative(), "48v8");
            drive.inject(drive::event::SafetyStop{drive::event::SafetyFunction::sto, true});
            drive.run(5ms);
            const auto status = drive.tpsr();
            if (drive.try_command(word_of(command))) {
                EXPECT_EQ(drive.tpsr(), status);
                EXPECT_FALSE(drive.moving());
            }
            drive.run(20ms);
            EXPECT_FALSE(drive.psr(psr::power)) << "nothing brings power under STO";
        }
    }
}

}  // namespace
}  // namespace servobus
