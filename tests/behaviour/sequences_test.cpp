// The worked sequences of the manuals (000 §3.2, 004 §5 and §6), each with its status words.
#include <gtest/gtest.h>

#include "drive/axis_kind.hpp"
#include "tests/support/drive_harness.hpp"
#include "tests/support/rotative_axis.hpp"

namespace servobus {
namespace {

using namespace std::chrono_literals;
using test::DriveHarness;

// A rotative axis with sensor and Z-mark.
drive::AxisKind rotative() {
    auto kind = test::rotative_axis();
    kind.reference = drive::AxisKind::Reference::z_mark;
    kind.z_mark = 20'000;
    kind.sensor_position = 8'000;
    kind.sensor_width = 1'500;
    return kind;
}

TEST(PowerOn, ShowsThePrintedWords) {
    DriveHarness drive;
    EXPECT_EQ(drive.word("Statusword"), 0x0250U);  // switch on disabled, voltage, remote
    drive.set("Controlword", 0x06);
    EXPECT_EQ(drive.word("Statusword"), 0x0231U);
    drive.set("Controlword", 0x07);
    EXPECT_EQ(drive.word("Statusword"), 0x0233U);
    drive.set("Controlword", 0x0F);
    EXPECT_EQ(drive.word("Statusword"), 0x0237U);
}

// 1.1
TEST(Reference, OfALinearAxis) {
    for (const std::int64_t method : {1, 2}) {
        DriveHarness drive;
        drive.enter_mode(6);
        drive.set("ReferenceMethods", method);
        drive.power_on();
        EXPECT_FALSE(drive.bit("Statusword", 12));
        drive.set("Controlword", 0x1F);
        // First the electrical angle, which shows no motion.
        EXPECT_TRUE(drive.runs_until([&] { return drive.bit("ProcessStatusRegisterXENAX", 2); }, 2s));
        EXPECT_FALSE(drive.bit("ProcessStatusRegisterXENAX", 1));
        EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 12); }, 10s));
        EXPECT_TRUE(drive.bit("Statusword", 10));
        EXPECT_FALSE(drive.bit("Statusword", 13));
        EXPECT_EQ(drive.word("ProcessStatusRegisterXENAX"), 0x0200'015AU);  // as a real drive says it
        EXPECT_EQ(drive.get("TellReferenceState"), 1);
        drive.enter_mode(1);
        EXPECT_EQ(drive.word("Statusword") & 0x006F, 0x0027U);
        // The position is now the one from the mechanical zero, and not from where it was switched on.
        EXPECT_GT(drive.get("PositionActualValue"), 40'000);
        EXPECT_LT(drive.get("PositionActualValue"), 80'000);
    }
}

// 1.2
TEST(Reference, OfAGantry) {
    for (const std::int64_t method : {3, 4, 5, 6}) {
        DriveHarness drive;
        drive.reference(method, 8);
        EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 9)) << method;
        drive.enter_mode(-1);
        drive.set("Controlword", 0x5F);
        drive.run(50ms);
        EXPECT_EQ(drive.get("TellVelocity"), 0) << "jog is not allowed in a gantry";
    }
}

// 1.3
TEST(Reference, OfARotativeMotorEndsAtItsZMark) {
    for (const std::int64_t method : {10, 11, 12, 13}) {
        DriveHarness drive(rotative());
        drive.set("ReferenceSpeedForExternalReferenceSensor", 20'000);
        drive.set("ReferenceSpeedForInternalZMark", 5'000);
        drive.reference(method);
        EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 1)) << method;
        drive.set("SpeedJogOrProfilePositionMode", 20'000);
        drive.move(0);
        EXPECT_LE(std::abs(drive.get("PositionActualValue")), 2) << method;
    }
}

TEST(Reference, WithoutSensorOrZMark) {
    for (const bool sensor : {false, true}) {
        DriveHarness drive(rotative());
        drive.set("ReferenceSpeedForExternalReferenceSensor", sensor ? 20'000 : 0);
        drive.set("ReferenceSpeedForInternalZMark", sensor ? 0 : 5'000);
        drive.reference(10);
        EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 1));
    }
}

// 1.4
TEST(Reference, OfARotaxRxvp) {
    for (const std::int64_t method : {14, 15}) {
        auto kind = rotative();
        kind.family = drive::AxisKind::Family::rotax_rxvp;
        DriveHarness drive(kind);
        drive.set("ReferenceSpeedForExternalReferenceSensor", 20'000);
        drive.set("ReferenceSpeedForInternalZMark", 5'000);
        drive.reference(method);
        EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 1)) << method;
    }
}

TEST(Reference, IsNotNeededByARotaxRxhq) {
    auto kind = rotative();
    kind.family = drive::AxisKind::Family::rotax_rxhq;
    kind.reference = drive::AxisKind::Reference::absolute;
    kind.increments_per_turn = 120'000;
    kind.increments_per_unit = 120'000 / 6.283185307179586;
    DriveHarness drive(kind);
    EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 1));
    EXPECT_GE(drive.get("PositionActualValue"), 0);
    EXPECT_LE(drive.get("PositionActualValue"), 119'999);
    drive.enter_mode(1);
    drive.power_on();
    drive.move(60'000);
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 60'000, 2);
}

// 1.5
TEST(Reference, FailsOnABlockedAxisAndSucceedsAfterAReset) {
    DriveHarness drive;
    drive.inject(drive::event::BlockAxis{true});
    drive.enter_mode(6);
    drive.power_on();
    drive.set("Controlword", 0x1F);
    EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 3); }, 10s));
    EXPECT_TRUE(drive.bit("Statusword", 13));
    EXPECT_FALSE(drive.bit("Statusword", 12));
    drive.inject(drive::event::BlockAxis{false});
    drive.set("Controlword", 0x80);
    EXPECT_FALSE(drive.bit("Statusword", 3));
    EXPECT_FALSE(drive.bit("Statusword", 13));
    drive.power_on();
    drive.set("Controlword", 0x1F);
    EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 12); }, 10s));
    EXPECT_FALSE(drive.bit("Statusword", 13));
}

// 2.1
TEST(ProfilePosition, AbsoluteThenRelative) {
    DriveHarness drive;
    drive.reference();
    drive.set("Controlword", 0x0F);
    drive.set("SCurve", 20);
    drive.set("AccelerationJogOrProfilePositionMode", 2'000'000);
    drive.set("SpeedJogOrProfilePositionMode", 200'000);
    drive.set("FollowingPositionErrorWindow", 2'000);
    drive.set("TargetPositionWindow", 20);
    drive.set("TargetPositionOrDistance", 100'000);
    drive.set("Controlword", 0x1F);
    EXPECT_TRUE(drive.bit("Statusword", 12));
    EXPECT_FALSE(drive.bit("Statusword", 10));
    drive.run(50ms);
    EXPECT_EQ(drive.word("ProcessStatusRegisterXENAX"), 0x0200'0156U);  // as a real drive says it while moving
    EXPECT_TRUE(drive.runs_until([&] { return drive.reached(); }, 5s));
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 100'000, 20);
    EXPECT_EQ(drive.word("Statusword"), 0x0637U);

    drive.set("Controlword", 0x0F);
    drive.set("TargetPositionOrDistance", -30'000);
    drive.set("Controlword", 0x5F);
    EXPECT_FALSE(drive.bit("Statusword", 10));
    EXPECT_TRUE(drive.runs_until([&] { return drive.reached(); }, 5s));
    drive.run(300ms);
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 70'000, 2);
    EXPECT_EQ(drive.word("ProcessStatusRegisterXENAX"), 0x0200'015AU);
}

TEST(ProfilePosition, ReachesATargetWhereItAlreadyStands) {
    DriveHarness drive;
    drive.reference();
    drive.move(0, true);
    drive.move(50'000);
    drive.run(500ms);
    drive.move(50'000);
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 50'000, 2);
    EXPECT_LT(std::abs(drive.get("MotorCurrentActualValue")), 100) << "friction holds it";
}

TEST(ProfilePosition, TakesANewSetPointOnlyAtTheTarget) {
    DriveHarness drive;
    drive.reference();
    drive.set("TargetPositionOrDistance", 100'000);
    drive.set("Controlword", 0x1F);
    drive.run(20ms);
    drive.set("Controlword", 0x0F);
    drive.set("TargetPositionOrDistance", 20'000);
    drive.set("Controlword", 0x1F);  // lost
    EXPECT_TRUE(drive.runs_until([&] { return drive.reached(); }, 5s));
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 100'000, 100);
}

// 2.2
TEST(ProfilePosition, HaltDeceleratesWithTheAccelerationOfThatMoment) {
    const auto way_of_halt = [](std::int64_t acceleration) {
        DriveHarness drive;
        drive.reference();
        drive.move(10'000);
        drive.set("Controlword", 0x0F);
        drive.set("TargetPositionOrDistance", 200'000);
        drive.set("Controlword", 0x1F);
        drive.run(400ms);
        drive.set("AccelerationJogOrProfilePositionMode", acceleration);
        const auto begin = drive.get("PositionActualValue");
        drive.set("Controlword", 0x10F);
        EXPECT_TRUE(drive.runs_until([&] { return drive.reached(); }, 5s));
        EXPECT_EQ(drive.word("Statusword") & 0x006FU, 0x0027U);
        drive.set("Controlword", 0x0F);
        drive.run(100ms);
        EXPECT_FALSE(drive.bit("ProcessStatusRegisterXENAX", 2)) << "the old target is forgotten";
        return drive.get("PositionActualValue") - begin;
    };
    const double gentle = static_cast<double>(way_of_halt(500'000));
    const double hard = static_cast<double>(way_of_halt(5'000'000));
    EXPECT_NEAR(gentle, 100'000.0 * 100'000 / 2 / 500'000, 2'000);
    EXPECT_NEAR(hard, 100'000.0 * 100'000 / 2 / 5'000'000, 300);
}

// 2.3, and the promise of the manual: no new reference is necessary
TEST(ProfilePosition, AFollowingErrorIsReset) {
    DriveHarness drive;
    drive.reference();
    drive.inject(drive::event::BlockAxis{true});
    drive.set("TargetPositionOrDistance", 100'000);
    drive.set("Controlword", 0x1F);
    EXPECT_TRUE(drive.runs_until([&] { return (drive.word("Statusword") & 0x004FU) == 0x0008U; }, 3s));
    EXPECT_TRUE(drive.bit("Statusword", 13));
    EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 0));
    EXPECT_FALSE(drive.bit("ProcessStatusRegisterXENAX", 8));
    EXPECT_EQ(drive.get("TellError"), 50);
    EXPECT_NE(drive.text("TellErrorString").find("Following error"), std::string::npos);
    drive.inject(drive::event::BlockAxis{false});
    drive.set("Controlword", 0x80);
    EXPECT_FALSE(drive.bit("Statusword", 3));
    EXPECT_EQ(drive.get("TellError"), 0);
    EXPECT_EQ(drive.text("TellErrorString"), "no error");
    drive.power_on();
    EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 1));
    drive.move(100'000);
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 100'000, 100);
}

// 3.1
TEST(CyclicSynchronousPosition, FollowsItsSetPoints) {
    DriveHarness drive;
    drive.reference(1, 8);
    drive.set("Controlword", 0x0F);
    drive.set("PDOCycleTime", 1'000);
    auto target = drive.get("PositionActualValue");
    drive.set("TargetPositionOrDistance", target);
    drive.set("Controlword", 0x06);
    EXPECT_EQ(drive.word("Statusword") & 0x006FU, 0x0021U);
    drive.set("Controlword", 0x1F);
    EXPECT_EQ(drive.word("Statusword") & 0x006FU, 0x0027U);
    EXPECT_TRUE(drive.bit("Statusword", 12));
    double speed = 0;  // increments per cycle
    for (int cycle = 0; cycle < 1'000; ++cycle) {
        speed = cycle < 200 ? speed + 0.25 : cycle >= 800 ? speed - 0.25 : speed;
        target += static_cast<std::int64_t>(speed);
        drive.set("TargetPositionOrDistance", target);
        drive.run(1ms);
        EXPECT_LT(std::abs(drive.get("ActualPositionFollowingError")), 200) << cycle;
    }
    drive.run(500ms);
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), static_cast<double>(target), 2);
    EXPECT_TRUE(drive.bit("Statusword", 10));
}

// 3.2
TEST(CyclicSynchronousPosition, ContinuesAfterAFault) {
    DriveHarness drive;
    drive.reference(1, 8);
    drive.set("TargetPositionOrDistance", drive.get("PositionActualValue"));
    drive.set("Controlword", 0x1F);
    drive.set("TargetPositionOrDistance", drive.get("PositionActualValue") + 50'000);  // in one cycle: too far
    EXPECT_TRUE(drive.runs_until([&] { return (drive.word("Statusword") & 0x004FU) == 0x0008U; }, 3s));
    EXPECT_EQ(drive.get("TellError"), 50);
    drive.set("Controlword", 0x80);
    drive.set("Controlword", 0x06);
    drive.set("TargetPositionOrDistance", drive.get("PositionActualValue"));
    drive.set("Controlword", 0x0F);
    EXPECT_EQ(drive.word("Statusword") & 0x006FU, 0x0027U);
    EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 1));
}

// 4
TEST(Jog, InBothDirectionsWithItsStatusBits) {
    for (const bool positive : {false, true}) {
        DriveHarness drive;
        drive.reference(1, -1);
        EXPECT_TRUE(drive.bit("Statusword", 12));
        const auto begin = drive.get("PositionActualValue");
        drive.set("SpeedJogOrProfilePositionMode", 50'000);
        drive.set("Controlword", positive ? 0x5F : 0x1F);
        EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 10) && !drive.bit("Statusword", 12); }, 2s));
        EXPECT_NEAR(static_cast<double>(drive.get("TellVelocity")), positive ? 50'000 : -50'000, 2'000);
        // Speed and acceleration count at once.
        drive.set("SpeedJogOrProfilePositionMode", 20'000);
        EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 10) && !drive.bit("Statusword", 12); }, 2s));
        drive.run(50ms);
        EXPECT_NEAR(static_cast<double>(drive.get("TellVelocity")), positive ? 20'000 : -20'000, 2'000);
        drive.set("Controlword", 0x11F);  // printed for both directions
        EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 10) && drive.bit("Statusword", 12); }, 2s));
        drive.run(200ms);
        EXPECT_EQ(drive.get("TellVelocity"), 0);
        EXPECT_EQ(drive.get("PositionActualValue") > begin, positive);
    }
}

// 5.1
TEST(ForceCalibration, RunsForwardAndBack) {
    DriveHarness drive;
    drive.reference();
    drive.enter_mode(0);
    drive.set("Position", 80'000);
    drive.command("GP");
    EXPECT_TRUE(drive.runs_until(
        [&] { return !drive.bit("ProcessStatusRegisterXENAX", 2) && drive.bit("ProcessStatusRegisterXENAX", 3); }, 5s));
    EXPECT_EQ(drive.word("ProcessStatusRegisterXENAX") & 0xFU, 0b1010U);
    drive.set("Way", 40'000);
    drive.command("FC");
    drive.run(1ms);
    EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 14));
    std::int64_t farthest = 0;
    EXPECT_TRUE(drive.runs_until(
        [&] {
            farthest = std::max(farthest, drive.get("PositionActualValue"));
            return !drive.bit("ProcessStatusRegisterXENAX", 14);
        },
        30s));
    EXPECT_NEAR(static_cast<double>(farthest), 120'000, 100);
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 80'000, 100);
    EXPECT_EQ(drive.get("ForceCalibrationValid"), 1);
    drive.enter_mode(1);
}

// 5.2
TEST(ForceLimitation, HoldsTheCurrentAndSaysSo) {
    DriveHarness drive;
    drive.reference();
    drive.move(80'000);
    drive.inject(drive::event::PutObstacle{100'000, 50, false});
    drive.set("LimitIForce", 140);
    drive.set("Controlword", 0x0F);
    drive.set("TargetPositionOrDistance", 120'000);
    drive.set("SpeedJogOrProfilePositionMode", 20'000);
    drive.set("Controlword", 0x1F);
    EXPECT_TRUE(drive.runs_until([&] { return drive.bit("ProcessStatusRegisterXENAX", 15); }, 5s));
    drive.run(2s);
    EXPECT_FALSE(drive.bit("Statusword", 3)) << "no following error while a limit is active";
    EXPECT_NEAR(static_cast<double>(drive.get("IForceActual")), 1'400, 60);
    EXPECT_LT(drive.get("PositionActualValue"), 101'000);
    // The lesson: without the limit the target is still far away.
    drive.set("LimitIForce", 0);
    EXPECT_TRUE(drive.runs_until([&] { return drive.bit("Statusword", 3); }, 2s));
    EXPECT_EQ(drive.get("TellError"), 50);
}

// 5.3
TEST(ForceMonitoring, JudgesTheCurveInItsSectors) {
    DriveHarness drive;
    drive.reference();
    drive.move(90'000);
    drive.inject(drive::event::PutObstacle{100'000, 2, false});
    drive.set("NSEC", 1);
    drive.set("SIFS", 100'500);
    drive.set("SIFE", 101'500);
    drive.set("IFL", 20);
    drive.set("IFH", 200);
    drive.set("STCX", 0);
    drive.set("SSEC", 1);
    drive.set("Controlword", 0x0F);
    drive.set("TargetPositionOrDistance", 102'000);
    drive.set("SpeedJogOrProfilePositionMode", 5'000);
    drive.set("Controlword", 0x1F);
    EXPECT_TRUE(drive.runs_until([&] { return drive.reached(); }, 10s));
    EXPECT_EQ(drive.get("SIFF"), 0);
    EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 7));
    EXPECT_GT(drive.get("IForcePeak"), 80);

    // The same part with an opening that it does not reach.
    drive.move(90'000);
    drive.set("IFL", 500);
    drive.set("IFH", 1'000);
    drive.move(102'000);
    EXPECT_EQ(drive.get("SIFF"), 1);
    EXPECT_FALSE(drive.bit("ProcessStatusRegisterXENAX", 7));
}

}  // namespace
}  // namespace servobus
