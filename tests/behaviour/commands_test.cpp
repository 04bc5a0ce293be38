// The commands with an argument and the parameters of classes 0x64 to 0x68 and 0x6E: each shows that it does what its
// text in the table says (000 §2.3, 004 §3.4, §4.2, §6).
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/support/axis_kinds.hpp"
#include "tests/support/drive_bench.hpp"

namespace servobus {
namespace {

using namespace std::chrono_literals;
using drive::Refusal;
using test::DriveBench;
namespace psr = test::psr;

drive::AxisKind rotative() { return drive::shipped_kind("third-party-rotative"); }

double seconds(drive::Time time) { return std::chrono::duration<double>(time).count(); }

/// From now until it stands; and the highest speed on the way.
struct Course {
    double seconds = 0;
    double fastest = 0;
};
Course course_of(DriveBench& drive) {
    const auto begin = drive.now();
    Course course;
    EXPECT_TRUE(drive.runs_until(
        [&] {
            course.fastest = std::max(course.fastest, std::abs(static_cast<double>(drive.get("TellVelocity"))));
            return !drive.moving();
        },
        60s));
    course.seconds = seconds(drive.now() - begin);
    drive.run(80ms);
    return course;
}

// ------------------------------------------------------------------------------------------------- Index

TEST(CommandIX, DrivesWithTheFieldsOfItsIndex) {
    DriveBench drive;
    drive.refuses_write("StartIndexNumber", 7);
    drive.refer();
    drive.go(100'000);
    drive.set("PreselectedIndexNumber", 7);
    drive.set("TypeOfIndex", 1);
    drive.set("DistanceOfSelectedIndex", 140'000);
    drive.set("SpeedOfSelectedIndex", 50'000);
    drive.set("AccelerationOfSelectedIndex", 500);  // 500'000 inc/s2
    drive.set("PreselectedIndexNumber", 50);
    drive.set("TypeOfIndex", 2);
    drive.set("DistanceOfSelectedIndex", -30'000);
    drive.set("SpeedOfSelectedIndex", 20'000);
    drive.set("AccelerationOfSelectedIndex", 4'000);
    drive.set("StartIndexNumber", 7);
    auto course = course_of(drive);
    EXPECT_NEAR(drive.position(), 140'000, 2);
    EXPECT_NEAR(course.fastest, 50'000, 1'000);
    EXPECT_NEAR(course.seconds, 0.8 + 0.1 / 0.9, 0.01);
    drive.set("StartIndexNumber", 50);
    course = course_of(drive);
    EXPECT_NEAR(drive.position(), 110'000, 3);
    EXPECT_NEAR(course.fastest, 20'000, 2'000);
    EXPECT_NEAR(course.seconds, 1.5 + 0.005 / 0.9, 0.01);
    EXPECT_EQ(drive.get("Speed"), 100'000);
}

TEST(CommandIX, TheDynamicIndexIsNumberZeroOfAnInput) {
    DriveBench drive;
    drive.refer();
    drive.go(100'000);
    drive.set("PreselectedInputFunction", 3);
    drive.set("TypeOfInputFunction", 8);
    drive.set("ParameterAOfInputFunction", 0);
    drive.set("TypeOfDynamicallyIndex", 2);
    drive.set("DistanceOfSelectedDynamicallyIndex", 12'000);
    drive.set("SpeedOfSelectedDynamicallyIndex", 30'000);
    drive.set("AccelerationOfSelectedDynamicallyIndex", 600);
    drive.inject(drive::event::SetInput{3, true});
    const auto course = course_of(drive);
    EXPECT_NEAR(drive.position(), 112'000, 2);
    EXPECT_NEAR(course.fastest, 30'000, 1'000);
    EXPECT_NEAR(course.seconds, 0.4 + 0.05 / 0.9, 0.01);
}

TEST(CommandG, GoesAtOnce) {
    DriveBench drive;
    drive.refuses_write("GoImmediately", 90'000);
    drive.refer();
    drive.go(90'000);
    EXPECT_NEAR(drive.position(), 90'000, 2);
    EXPECT_EQ(drive.get("Position"), 0) << "PO is not concerned";
}

// ------------------------------------------------------------------------------------------------- Override, limits

TEST(ParameterOVRD, ScalesEveryMotion) {
    DriveBench drive;
    drive.refer();
    drive.go(50'000);
    drive.set("SpeedOverride", 50);
    drive.set("GoImmediately", 100'000);
    EXPECT_NEAR(course_of(drive).fastest, 50'000, 1'500);
    drive.set("DistanceOfSelectedIndex", 60'000);
    drive.set("SpeedOfSelectedIndex", 40'000);
    drive.set("StartIndexNumber", 1);
    EXPECT_NEAR(course_of(drive).fastest, 20'000, 1'000);
    drive.set("TypeOfInputFunction", 6);
    drive.set("ParameterAOfInputFunction", 100'000);
    drive.set("ParameterBOfInputFunction", 60'000);
    drive.inject(drive::event::SetInput{1, true});
    EXPECT_NEAR(course_of(drive).fastest, 30'000, 1'000);
    drive.command("JN");
    drive.run(200ms);
    EXPECT_NEAR(static_cast<double>(drive.get("TellVelocity")), -50'000, 1'500);
    drive.set("SpeedOverride", 20);
    drive.run(200ms);
    EXPECT_NEAR(static_cast<double>(drive.get("TellVelocity")), -20'000, 1'500);
    drive.command("SM");
    EXPECT_TRUE(drive.stands_within());
    drive.set("SpeedOfSelectedDriveIForce", 50'000);
    drive.set("IForceLimitOfSelectedDriveIForce", 100);
    drive.set("DriveIForce", 1);
    drive.run(200ms);
    EXPECT_NEAR(static_cast<double>(drive.get("TellVelocity")), 10'000, 1'000);
}

TEST(ParameterOVRD, OfZeroHoldsAMotionBack) {
    DriveBench drive;
    drive.refer();
    drive.go(50'000);
    drive.set("DistanceOfSelectedIndex", 90'000);
    drive.set("SpeedOfSelectedIndex", 40'000);
    drive.set("SpeedOverride", 0);
    drive.set("StartIndexNumber", 1);
    drive.run(500ms);
    EXPECT_NEAR(drive.position(), 50'000, 2);
    EXPECT_TRUE(drive.moving());
    drive.refuses("GP");
    drive.set("SpeedOverride", 50);
    EXPECT_NEAR(course_of(drive).fastest, 20'000, 1'000) << "its own speed, and the override";
    EXPECT_NEAR(drive.position(), 90'000, 2);
    drive.set("SpeedOverride", 0);
    drive.refuses_write("DriveIForce", 1);
}

TEST(ParameterSLPNAndSLPP, HoldEveryMotion) {
    DriveBench drive;
    drive.refer();
    drive.set("SoftLimitPositionNegative", 50'000);
    drive.set("SoftLimitPositionPositive", 100'000);
    drive.go(150'000);
    EXPECT_NEAR(drive.position(), 100'000, 2);
    EXPECT_EQ(drive.get("TellError"), 80);
    EXPECT_TRUE(drive.bit("Statusword", 11));
    drive.set("DistanceOfSelectedIndex", 10'000);
    drive.set("StartIndexNumber", 1);
    EXPECT_TRUE(drive.stands_within());
    drive.run(50ms);
    EXPECT_NEAR(drive.position(), 50'000, 2);
    drive.command("JP");
    EXPECT_TRUE(drive.stands_within(5s));
    drive.run(50ms);
    EXPECT_NEAR(drive.position(), 100'000, 60);
    EXPECT_LE(drive.position(), 100'000);
    drive.go(90'000);
    drive.set("SpeedOfSelectedDriveIForce", 20'000);
    drive.set("IForceLimitOfSelectedDriveIForce", 200);
    drive.set("DriveIForce", 1);
    EXPECT_TRUE(drive.stands_within(5s));
    EXPECT_NEAR(drive.position(), 100'000, 100);
    EXPECT_FALSE(drive.psr(psr::in_force));
    drive.set("SoftLimitPositionNegative", 0);
    drive.set("SoftLimitPositionPositive", 0);
    drive.go(150'000);
    EXPECT_NEAR(drive.position(), 150'000, 2);
}

TEST(ParameterED, StopsAQuickStop) {
    const auto way = [](std::int64_t deceleration) {
        DriveBench drive;
        drive.refer();
        drive.go(20'000);
        drive.set("EmergencyDeceleration", deceleration);
        drive.set("Controlword", 0x0F);
        drive.command("JP");
        drive.run(300ms);
        const double from = drive.position();
        drive.set("Controlword", 0x02);
        drive.run(5ms);
        drive.command("SM");  // not softer than the quick stop
        drive.run(1s);
        EXPECT_EQ(drive.get("TellVelocity"), 0);
        return drive.position() - from;
    };
    EXPECT_NEAR(way(1'000'000), 1e10 / 2 / 1'000'000, 400);
    EXPECT_NEAR(way(5'000'000), 1e10 / 2 / 5'000'000, 200);
}

TEST(ParameterDP, IsTheFollowingErrorThatIsStillNone) {
    for (const bool tight : {false, true}) {
        DriveBench drive;
        drive.refer();
        drive.inject(drive::event::PutObstacle{70'000, 100, false});
        drive.set("DeviationPosition", tight ? 300 : 100'000);
        drive.set("Speed", 20'000);
        drive.set("GoImmediately", 72'000);
        drive.run(1s);
        EXPECT_EQ(drive.get("TellError"), tight ? 50 : 0);
    }
}

TEST(ParameterDTP, AndItsTimeDecideWhenATargetIsReached) {
    const auto time = [](std::int64_t window, std::int64_t wait) {
        DriveBench drive;
        drive.reference();
        drive.set("Acceleration", 100'000);
        drive.set("Speed", 10'000);
        drive.set("TargetPositionWindow", window);
        drive.set("TargetPositionWindowTime", wait);
        drive.set("TargetPositionOrDistance", 5'000);
        drive.set("Controlword", 0x5F);
        const auto begin = drive.now();
        EXPECT_TRUE(drive.runs_until([&] { return drive.reached(); }, 10s));
        return seconds(drive.now() - begin);
    };
    const double loose = time(100, 0);
    EXPECT_GE(time(1, 0), loose);
    EXPECT_NEAR(time(100, 200), loose + 0.2, 0.003);
}

TEST(ParameterSCRV, RoundsTheRampsAndACVTellsTheJerk) {
    DriveBench drive;
    drive.refer();
    drive.go(60'000);
    drive.set("Acceleration", 500'000);
    double last = 0;
    std::int64_t jerk = 1'000'000'000;
    for (const std::int64_t percent : {1, 20, 100}) {
        drive.set("SCurve", percent);
        drive.go(60'000);
        drive.set("GoImmediately", 120'000);
        const double time = course_of(drive).seconds;
        EXPECT_NEAR(time, 0.6 + 0.2 / (1 - static_cast<double>(percent) / 200), 0.005);
        EXPECT_GT(time, last);
        EXPECT_LT(drive.get("AccelerationVariation"), jerk);
        last = time;
        jerk = drive.get("AccelerationVariation");
    }
    // a / (T/2) with a ramp of T = v / a * 2, divided by 1000.
    EXPECT_EQ(jerk, 2'500);
}

// ------------------------------------------------------------------------------------------------- Force, by current

TEST(CommandDIF, PressesWithTheCurrentOfItsDrive) {
    for (const bool positive : {true, false}) {
        DriveBench drive;
        drive.refuses_write("DriveIForce", 4);
        drive.refer();
        drive.go(100'000);
        drive.inject(drive::event::PutObstacle{positive ? 120'000 : 80'000, 100, !positive});
        drive.set("PreselectedDriveIForceNumber", 4);
        drive.set("AccelerationOfSelectedDriveIForce", 300);
        drive.set("SpeedOfSelectedDriveIForce", 25'000);
        drive.set("IForceLimitOfSelectedDriveIForce", 90);
        drive.set("DirectionOfSelectedDriveIForce", positive ? 0 : 1);
        drive.set("PreselectedDriveIForceNumber", 1);
        drive.set("DriveIForce", 4);
        EXPECT_FALSE(drive.psr(psr::in_force));
        drive.run(300ms);
        EXPECT_NEAR(static_cast<double>(drive.get("TellVelocity")), positive ? 25'000 : -25'000, 1'000);
        EXPECT_TRUE(drive.runs_until([&] { return drive.psr(psr::in_force); }, 5s));
        EXPECT_TRUE(drive.psr(psr::current_limit));
        drive.run(500ms);
        EXPECT_NEAR(static_cast<double>(drive.get("IForceActual")), positive ? 900 : -900, 40);
        EXPECT_NEAR(drive.position(), positive ? 120'000 : 80'000, 200);
        EXPECT_EQ(drive.get("TellError"), 0);
        // The next way begins where the axis stands, not where its set point would be.
        const double from = drive.position();
        drive.set("Way", positive ? -10'000 : 10'000);
        drive.command("GW");
        EXPECT_FALSE(drive.psr(psr::in_force));
        EXPECT_TRUE(drive.stands_within());
        drive.run(100ms);
        EXPECT_EQ(drive.get("TellError"), 0);
        EXPECT_NEAR(drive.position(), from + (positive ? -10'000 : 10'000), 3);
    }
}

TEST(CommandCLIF, ChangesTheLimitOfTheMotionThatRuns) {
    DriveBench drive;
    drive.refer();
    drive.go(100'000);
    drive.inject(drive::event::PutObstacle{110'000, 100, false});
    drive.set("IForceLimitOfSelectedDriveIForce", 90);
    drive.set("SpeedOfSelectedDriveIForce", 20'000);
    drive.set("DriveIForce", 1);
    EXPECT_TRUE(drive.runs_until([&] { return drive.psr(psr::in_force); }, 5s));
    for (const std::int64_t limit : {150, 60}) {
        drive.set("ChangeLimitIForce", limit);
        drive.run(300ms);
        EXPECT_NEAR(static_cast<double>(drive.get("IForceActual")), static_cast<double>(limit) * 10, 40);
    }
    drive.set("LimitIForce", 0);
    drive.go(100'000);  // and the next motion has the old one again
    EXPECT_NEAR(drive.position(), 100'000, 2);
    EXPECT_EQ(drive.get("IForceLimitOfSelectedDriveIForce"), 90);
    drive.set("Speed", 10'000);
    drive.set("GoImmediately", 112'000);
    drive.run(200ms);
    drive.set("ChangeLimitIForce", 120);
    drive.run(2s);
    EXPECT_NEAR(static_cast<double>(drive.get("IForceActual")), 1'200, 40);
    EXPECT_TRUE(drive.psr(psr::current_limit));
    EXPECT_EQ(drive.get("TellError"), 0);
}

TEST(ParameterIRAndIS, LimitTheCurrentOfTheMotor) {
    DriveBench drive;
    drive.refer();
    drive.set("RunCurrent", 100);  // 1 A: 3.5 N for 0.32 kg
    drive.set("Acceleration", 30'000'000);
    drive.set("DeviationPosition", 1'000'000);
    drive.set("GoImmediately", 150'000);
    double most = 0;
    EXPECT_TRUE(drive.runs_until(
        [&] {
            if (!drive.moving()) return true;
            most = std::max(most, std::abs(static_cast<double>(drive.get("TellMotorCurrent"))));
            return false;
        },
        5s));
    EXPECT_NEAR(most, 1'000, 20);
    drive.run(500ms);
    for (const std::int64_t stop : {60, 250}) {
        drive.set("StopCurrent", stop);
        drive.set("DeviationPosition", 1'000'000);
        drive.go(100'000);
        drive.inject(drive::event::PushAxis{6});
        drive.run(400ms);
        const double held = std::abs(static_cast<double>(drive.get("TellMotorCurrent")));
        EXPECT_LE(held, static_cast<double>(stop) * 10 + 10);
        EXPECT_EQ(drive.position() < 105'000, stop == 250) << "1.7 A hold 6 N";
        drive.inject(drive::event::PushAxis{0});
        drive.run(500ms);
    }
}

TEST(ParameterLIF, LimitsAnyMotionAtAnyTime) {
    DriveBench drive;
    drive.refer();
    drive.inject(drive::event::PutObstacle{90'000, 100, false});
    drive.set("Speed", 20'000);
    drive.set("LimitIForce", 100);
    drive.set("GoImmediately", 100'000);
    drive.run(2500ms);
    EXPECT_NEAR(static_cast<double>(drive.get("IForceActual")), 1'000, 40);
    EXPECT_TRUE(drive.psr(psr::current_limit));
    drive.set("LimitIForce", 140);
    drive.run(100ms);
    EXPECT_NEAR(static_cast<double>(drive.get("IForceActual")), 1'400, 40);
}

// ------------------------------------------------------------------------------------------------- Force, by load cell

/// The highest FA of a second.
double force_of_a_second(DriveBench& drive) {
    double most = 0;
    for (int i = 0; i < 200; ++i) {
        drive.run(5ms);
        most = std::max(most, std::abs(static_cast<double>(drive.get("ForceActual"))));
    }
    return most;
}

TEST(CommandDF, PressesWithTheForceOfItsDrive) {
    for (const bool positive : {true, false}) {
        DriveBench drive;
        drive.refer();
        drive.go(100'000);
        drive.inject(drive::event::PutObstacle{positive ? 110'000 : 90'000, 20, !positive});
        drive.set("ForceteqMode", 1);
        drive.set("PreselectedDriveIForceNumber", 2);
        drive.refuses_write("DriveForce", 2, Refusal::not_configured);  // it has no force yet
        drive.set("SpeedOfSelectedDriveIForce", 10'000);
        drive.set("DirectionOfSelectedDriveIForce", positive ? 0 : 1);
        drive.set("ForceOfSelectedDriveForce", 4'000);
        drive.set("DriveForce", 2);
        EXPECT_TRUE(drive.runs_until([&] { return drive.psr(psr::in_force); }, 5s));
        drive.run(700ms);
        EXPECT_TRUE(drive.psr(psr::force_limit));
        EXPECT_FALSE(drive.psr(psr::current_limit));
        const double sign = positive ? 1 : -1;
        EXPECT_NEAR(sign * static_cast<double>(drive.get("ForceActual")), 4'000, 200);
        EXPECT_LT(force_of_a_second(drive), 4'200);
        drive.set("ChangeLimitForce", 6'000);
        drive.run(1s);
        EXPECT_NEAR(sign * static_cast<double>(drive.get("ForceActual")), 6'000, 300);
        drive.go(100'000);
        EXPECT_NEAR(drive.position(), 100'000, 2);
        EXPECT_EQ(drive.get("ForceActual"), 0);
        EXPECT_FALSE(drive.psr(psr::force_limit));
        EXPECT_EQ(drive.get("TellError"), 0);
    }
}

TEST(ParameterLF, HoldsTheMeasuredForce) {
    DriveBench drive;
    drive.refer();
    drive.go(90'000);
    drive.inject(drive::event::PutObstacle{100'000, 20, false});
    drive.set("LimitForce", 5'000);
    drive.set("Speed", 10'000);
    drive.set("GoImmediately", 110'000);
    EXPECT_TRUE(drive.runs_until([&] { return drive.psr(psr::force_limit); }, 5s));
    drive.run(1s);
    EXPECT_NEAR(static_cast<double>(drive.get("ForceActual")), 5'000, 250);
    EXPECT_EQ(drive.get("TellError"), 0);
    EXPECT_FALSE(drive.bit("Statusword", 3));
    drive.set("LimitForce", 3'000);
    drive.run(1s);
    EXPECT_NEAR(static_cast<double>(drive.get("ForceActual")), 3'000, 250);
    drive.set("LimitForce", 8'000);  // more than twice as much
    drive.run(1s);
    EXPECT_NEAR(static_cast<double>(drive.get("ForceActual")), 8'000, 400);
}

TEST(ParameterLFRMS, IsTheHighestSpeedAfterTheForceLimit) {
    const auto fastest = [](std::int64_t limit) {
        DriveBench drive;
        drive.refer();
        drive.go(90'000);
        drive.inject(drive::event::PutObstacle{100'000, 20, false});
        drive.set("LimitForceReachedMaximumSpeed", limit);
        drive.set("LimitForce", 5'000);
        drive.set("Speed", 50'000);
        drive.set("GoImmediately", 200'000);
        drive.run(3s);
        EXPECT_TRUE(drive.psr(psr::force_limit));
        drive.inject(drive::event::RemoveObstacle{});  // it gives way
        double most = 0;
        for (int i = 0; i < 400; ++i) {
            drive.run(1ms);
            most = std::max(most, static_cast<double>(drive.get("TellVelocity")));
        }
        EXPECT_GT(drive.position(), 101'500);
        return most;
    };
    EXPECT_LT(fastest(10'000), 13'000);
    EXPECT_LT(fastest(40'000), 50'000);
    EXPECT_GT(fastest(0), 100'000) << "0: no such limit";
}

TEST(ParameterSQBW, FiltersTheForce) {
    const auto delay = [](std::int64_t bandwidth) {
        DriveBench drive;
        drive.set("SignateqBandwidth", bandwidth);
        drive.refer();
        drive.go(99'000);
        drive.inject(drive::event::PutObstacle{100'000, 1'000, false});
        drive.set("ForceteqMode", 1);
        drive.set("LimitIForce", 300);
        drive.set("GoImmediately", 101'000);
        drive.run(150ms);
        return static_cast<double>(drive.get("IForcePeak"));
    };
    EXPECT_GT(delay(5'000), 1.02 * delay(100));
}

TEST(ParameterBWFP, DecidesHowFastTheForceIsRegulated) {
    const auto settled_after = [](std::int64_t bandwidth) {
        DriveBench drive;
        drive.set("BandwidthForForceteqProController", bandwidth);
        drive.refer();
        drive.go(90'000);
        drive.inject(drive::event::PutObstacle{100'000, 20, false});
        drive.set("LimitForce", 5'000);
        drive.set("Speed", 10'000);
        drive.set("GoImmediately", 110'000);
        drive.run(3s);
        drive.set("LimitForce", 8'000);
        const auto begin = drive.now();
        EXPECT_TRUE(drive.runs_until([&] { return std::abs(drive.get("ForceActual") - 8'000) < 150; }, 20s));
        return drive.now() - begin;
    };
    EXPECT_GT(settled_after(5), 2 * settled_after(50));
    settled_after(1'000);
}

TEST(ForceOption, IsRefusedWithoutTheLoadCell) {
    for (const auto* variant : {"75v8", "48v8"}) {
        DriveBench drive(drive::AxisKind{}, variant);
        drive.refer();
        for (const auto* row :
             {"LimitForce", "DriveForce", "ChangeLimitForce", "ForceOfSelectedDriveForce", "ForceHigh", "ForceLow",
              "ForceteqMode", "LimitForceReachedMaximumSpeed", "BandwidthForForceteqProController"}) {
            drive.refuses_write(row, 1, Refusal::not_configured);
        }
        EXPECT_FALSE(drive.moving());
    }
}

// ------------------------------------------------------------------------------------------------- Sectors

TEST(ForceSectors, HaveTheirOwnPeaks) {
    DriveBench drive;
    drive.refer();
    drive.go(95'000);
    drive.inject(drive::event::PutObstacle{100'000, 2, false});
    drive.set("SetSectorOffset", 100'000);
    for (const std::int64_t sector : {1, 2, 10}) {
        drive.set("PreselectedSectorNumber", sector);
        drive.set("SectorIForceStart", sector == 10 ? -4'000 : 1'000 * (sector - 1));
        drive.set("SectorIForceEnd", sector == 10 ? -1'000 : 1'000 * sector);
        drive.set("IForceLow", sector == 2 ? 500 : -2'000);
        drive.set("IForceHigh", 2'000);
    }
    drive.set("SelectSectors", 0b10'0000'0011);
    drive.set("Speed", 5'000);
    drive.set("GoImmediately", 102'500);
    bool was_in_sector = false;
    EXPECT_TRUE(drive.runs_until(
        [&] {
            was_in_sector |= drive.psr(psr::in_sector);
            return !drive.moving();
        },
        5s));
    EXPECT_TRUE(was_in_sector);
    EXPECT_EQ(drive.get("SectorIForceCurveFailed"), 0b10) << "sector 2 asks for 5 A";
    EXPECT_FALSE(drive.psr(psr::force_in_sector));
    const auto peak = [&](std::int64_t sector) {
        drive.set("PreselectedSectorNumber", sector);
        return drive.get("IForcePeakSector");
    };
    EXPECT_GT(peak(2), peak(1) + 30);  // 2 N/mm are 56 x 10 mA to a millimetre
    EXPECT_LT(peak(10), peak(1));
    EXPECT_GE(drive.get("IForcePeak"), peak(2));
    EXPECT_EQ(peak(5), 0);
}

TEST(ForceSectors, CountMillinewtonsWithTheLoadCell) {
    DriveBench drive;
    drive.refer();
    drive.go(95'000);
    drive.inject(drive::event::PutObstacle{100'000, 2, false});
    drive.set("ForceteqMode", 1);
    drive.set("SectorIForceStart", 100'500);
    drive.set("SectorIForceEnd", 101'500);
    drive.set("ForceLow", 500);
    drive.set("ForceHigh", 3'500);
    drive.set("Speed", 5'000);
    drive.set("GoImmediately", 102'000);
    EXPECT_TRUE(drive.stands_within());
    EXPECT_TRUE(drive.psr(psr::force_in_sector));
    EXPECT_EQ(drive.get("SectorIForceCurveFailed"), 0);
    EXPECT_NEAR(static_cast<double>(drive.get("IForcePeakSector")), 3'000, 150);
    EXPECT_NEAR(static_cast<double>(drive.get("IForcePeak")), 4'000, 150);
    drive.go(95'000);
    drive.set("ForceHigh", 2'000);
    drive.set("GoImmediately", 102'000);
    EXPECT_TRUE(drive.stands_within());
    EXPECT_EQ(drive.get("SectorIForceCurveFailed"), 1);
}

// ------------------------------------------------------------------------------------------------- Trigger, outputs

TEST(CommandTGUAndTGD, PulseAnOutputInTheirDirection) {
    DriveBench drive;
    drive.refer();
    drive.go(70'000);
    drive.set("PreselectedOutputFunction", 5);
    drive.set("TypeOfOutputFunction", 10);
    drive.set("SetTriggerPositionUpward", 80'000);
    drive.set("SetTriggerPositionDownward", 75'000);
    const auto pulses_at = [&](std::int64_t target) {
        drive.set("GoImmediately", target);
        std::vector<double> places;
        bool before = false;
        EXPECT_TRUE(drive.runs_until(
            [&] {
                const bool now = drive.bit("TellOutputHex", 4);
                if (now && !before) places.push_back(drive.position());
                before = now;
                return !drive.moving();
            },
            5s));
        return places;
    };
    auto places = pulses_at(90'000);
    ASSERT_EQ(places.size(), 1U);
    EXPECT_NEAR(places[0], 80'000, 150);
    places = pulses_at(70'000);
    ASSERT_EQ(places.size(), 1U);
    EXPECT_NEAR(places[0], 75'000, 150);
    drive.run(10ms);
    EXPECT_FALSE(drive.bit("TellOutputHex", 4));
}

TEST(Outputs, AreWrittenInFourWays) {
    DriveBench drive;
    EXPECT_EQ(drive.get("TellOutputHex"), 0);
    drive.set("SetOutputNumber", 3);
    EXPECT_EQ(drive.get("TellOutputHex"), 0b100);
    EXPECT_EQ(drive.word("DigitalOutputsXENAX"), 0x0004'0000U);
    drive.set("SetOutputHexMask", 0xF0);
    EXPECT_EQ(drive.get("TellOutputHex"), 0xF0);
    drive.set("ClearOutputNumber", 8);
    EXPECT_EQ(drive.get("TellOutputHex"), 0x70);
    drive.set("DigitalOutputsXENAX", 0x0081'0000);
    EXPECT_EQ(drive.get("TellOutputHex"), 0x81);
}

TEST(Outputs, ShowTheFlagOfTheirFunction) {
    DriveBench drive;
    for (const std::int64_t output : {1, 2, 3, 4, 5, 6, 7, 8}) {
        drive.set("PreselectedOutputFunction", output);
        drive.set("TypeOfOutputFunction", std::array<std::int64_t, 8>{1, 2, 3, 4, 5, 9, 12, 0}[output - 1]);
    }
    const auto on = [&](unsigned output) { return drive.bit("TellOutputHex", output - 1); };
    EXPECT_EQ(drive.get("TellOutputHex"), 0b0001'0000);  // no program runs
    drive.refer();
    EXPECT_TRUE(on(2) && on(4) && on(6));
    EXPECT_FALSE(on(1) || on(3) || on(7));
    drive.command("JP");
    drive.run(10ms);
    EXPECT_TRUE(on(3));
    EXPECT_FALSE(on(4));
    drive.inject(drive::event::LoseEncoder{true});
    drive.run(10ms);
    EXPECT_TRUE(on(1));
    EXPECT_FALSE(on(6));
}

TEST(Outputs, ShowForceAndBrake) {
    DriveBench drive;
    drive.set("PreselectedOutputFunction", 1);
    drive.set("TypeOfOutputFunction", 11);
    drive.set("BrakeDelay", 50);
    drive.set("PreselectedOutputFunction", 2);
    drive.set("TypeOfOutputFunction", 6);
    drive.set("PreselectedOutputFunction", 3);
    drive.set("TypeOfOutputFunction", 13);
    const auto on = [&](unsigned output) { return drive.bit("TellOutputHex", output - 1); };
    EXPECT_FALSE(on(1));
    drive.refer();
    EXPECT_TRUE(on(1));
    drive.inject(drive::event::PutObstacle{drive.get("PositionActualValue") + 5'000, 100, false});
    drive.set("IForceLimitOfSelectedDriveIForce", 80);
    drive.set("SpeedOfSelectedDriveIForce", 20'000);
    drive.set("DriveIForce", 1);
    drive.run(2s);
    EXPECT_TRUE(on(2) && on(3));
    // While the brake closes, the motor still holds.
    drive.command("PQ");
    EXPECT_FALSE(on(1));
    drive.run(20ms);
    EXPECT_NE(drive.get("TellMotorCurrent"), 0);
    drive.run(60ms);
    EXPECT_EQ(drive.get("TellMotorCurrent"), 0);
}

// ------------------------------------------------------------------------------------------------- Inputs

TEST(Inputs, ShowTheirLevels) {
    DriveBench drive;
    drive.inject(drive::event::SetInput{1, true});
    drive.inject(drive::event::SetInput{12, true});
    EXPECT_EQ(drive.get("TellInputHex"), 0x801);
    EXPECT_EQ(drive.word("DigitalInputsXENAX"), 0x0801'0000U);
    drive.inject(drive::event::LimitSwitch{drive::event::Direction::negative, true});
    drive.inject(drive::event::LimitSwitch{drive::event::Direction::positive, true});
    EXPECT_EQ(drive.word("DigitalInputsXENAX"), 0x0801'0003U);
}

/// A drive whose input 2 has a function.
struct Function {
    DriveBench drive;
    Function(std::int64_t type, std::int64_t a = 0, std::int64_t b = 0, std::int64_t c = 0) {
        drive.set("PreselectedInputFunction", 2);
        drive.set("TypeOfInputFunction", type);
        drive.set("ParameterAOfInputFunction", a);
        drive.set("ParameterBOfInputFunction", b);
        drive.set("ParameterCOfInputFunction", c);
    }
    void on() { drive.inject(drive::event::SetInput{2, true}); }
    void off() { drive.inject(drive::event::SetInput{2, false}); }
    DriveBench* operator->() { return &drive; }
};

TEST(InputFunction, ReferencesAndSwitchesThePower) {
    Function reference(1);
    reference.on();
    EXPECT_TRUE(reference->runs_until([&] { return reference->psr(psr::reference); }, 5s));

    Function power_on(2);
    power_on.on();
    EXPECT_EQ(power_on->get("TellError"), 83) << "a linear axis needs REF first";
    power_on.off();
    power_on->refer();
    power_on->command("PQ");
    power_on.on();
    EXPECT_TRUE(power_on->psr(psr::power));

    Function power_off(3);
    power_off->refer();
    power_off.on();
    EXPECT_FALSE(power_off->psr(psr::power));

    Function both(4);
    both->refer();
    both.on();
    EXPECT_TRUE(both->psr(psr::power));
    both.off();
    EXPECT_FALSE(both->psr(psr::power));
    both.on();
    EXPECT_TRUE(both->psr(psr::power));
}

TEST(InputFunction, StartsAndStopsMotions) {
    Function stop(5);
    stop->refer();
    stop->command("JP");
    stop->run(100ms);
    stop.on();
    EXPECT_TRUE(stop->stands_within(500ms));

    Function position(6, 80'000, 20'000, 400);
    position.on();
    EXPECT_EQ(position->get("TellError"), 83);
    position.off();
    position->refer();
    position.on();
    EXPECT_NEAR(course_of(position.drive).fastest, 20'000, 1'000);
    EXPECT_NEAR(position->position(), 80'000, 2);

    Function way(7, -5'000);
    way->refer();
    const double from = way->position();
    way.on();
    EXPECT_TRUE(way->stands_within());
    way->run(50ms);
    EXPECT_NEAR(way->position(), from - 5'000, 3);

    Function index(9, 1, 2);
    index->set("DistanceOfSelectedIndex", 70'000);
    index->set("PreselectedIndexNumber", 2);
    index->set("DistanceOfSelectedIndex", 75'000);
    index->refer();
    index.on();
    EXPECT_TRUE(index->stands_within());
    EXPECT_NEAR(index->position(), 70'000, 50);
    index.off();
    EXPECT_TRUE(index->stands_within());
    EXPECT_NEAR(index->position(), 75'000, 50);

    for (const bool positive : {true, false}) {
        Function jog(positive ? 12 : 13);
        jog->refer();
        jog.on();
        jog->run(300ms);
        EXPECT_NEAR(static_cast<double>(jog->get("TellVelocity")), positive ? 100'000 : -100'000, 2'000);
        jog.off();
        EXPECT_TRUE(jog->stands_within(500ms));
    }

    Function force(14, 3);
    force->refer();
    force->set("PreselectedDriveIForceNumber", 3);
    force->set("IForceLimitOfSelectedDriveIForce", 80);
    force->set("SpeedOfSelectedDriveIForce", 10'000);
    force.on();
    force->run(300ms);
    EXPECT_NEAR(static_cast<double>(force->get("TellVelocity")), 10'000, 1'000);
}

TEST(InputFunction, ActsOnPositionsSignalsAndFaults) {
    Function capture(16);
    capture->refer();
    capture->go(70'000);
    capture.on();
    capture->run(1ms);
    EXPECT_NEAR(static_cast<double>(capture->get("TellCapturedPosition1")), 70'000, 2);

    Function offset(17);
    offset->refer();
    offset->go(70'000);
    offset.on();
    EXPECT_NEAR(static_cast<double>(offset->get("SetSectorOffset")), 70'000, 2);

    for (const bool positive : {false, true}) {
        Function limit(positive ? 19 : 18);
        limit->refer();
        limit->command(positive ? "JP" : "JN");
        limit->run(50ms);
        limit.on();
        limit->run(100ms);
        EXPECT_TRUE(limit->psr(positive ? psr::positive_limit_switch : psr::negative_limit_switch));
        EXPECT_EQ(limit->get("TellError"), positive ? 31 : 30);
        limit->command("PWC");
        limit->command(positive ? "JN" : "JP");  // and away from it
        limit->run(200ms);
        limit.off();
        EXPECT_EQ(limit->get("TellError"), 0);
    }

    Function exit(20);
    exit->refer();
    exit.on();
    exit->run(10ms);
    EXPECT_TRUE(exit->psr(psr::emergency_exit));
    EXPECT_FALSE(exit->psr(psr::power));
    exit->refuses("PWC");

    Function exit_power_on(21);
    exit_power_on->refer();
    exit_power_on->command("JP");
    exit_power_on->run(100ms);
    exit_power_on.on();
    EXPECT_TRUE(exit_power_on->stands_within(200ms));
    EXPECT_TRUE(exit_power_on->psr(psr::power));
    EXPECT_TRUE(exit_power_on->psr(psr::emergency_exit_power_on));
    exit_power_on->refuses("JP");

    Function reset(22);
    reset->refer();
    reset->inject(drive::event::LoseEncoder{true});
    reset->run(10ms);
    reset->inject(drive::event::LoseEncoder{false});
    EXPECT_EQ(reset->get("TellError"), 20);
    reset.on();
    EXPECT_EQ(reset->get("TellError"), 0);
}

TEST(InputFunction, ReadsLowActiveInputs) {
    for (const bool selective : {false, true}) {
        Function position(6, 80'000);
        position->refer();
        position.on();  // the level without effect
        EXPECT_TRUE(position->stands_within());
        position->set("InputLowActive", selective ? 2 : 1);
        position->set("InputLowActiveSelective", selective ? 0b10 : 0);
        position->go(60'000);
        position.off();
        EXPECT_TRUE(position->stands_within());
        position->run(50ms);
        EXPECT_NEAR(position->position(), 80'000, 3);
        EXPECT_EQ(position->get("TellInputHex"), 0) << "TIX shows levels";
    }
}

TEST(ParameterINH, NamesTheInputOfTheReferenceSensor) {
    auto kind = rotative();
    kind.sensor_width = 0;  // none but the wired one
    DriveBench drive(kind);
    drive.set("InputHomeSensor", 6);
    drive.set("ReferenceSpeedForExternalReferenceSensor", 20'000);
    drive.set("ReferenceSpeedForInternalZMark", 0);
    drive.command("REF");
    drive.run(300ms);
    EXPECT_TRUE(drive.moving());
    drive.inject(drive::event::SetInput{1, true});
    drive.run(50ms);
    EXPECT_FALSE(drive.psr(psr::reference));
    drive.inject(drive::event::SetInput{6, true});
    EXPECT_TRUE(drive.runs_until([&] { return drive.psr(psr::reference); }, 1s));
}

// ------------------------------------------------------------------------------------------------- Controller

TEST(ParameterML, IsWhatTheAxisCarries) {
    // With the payload told the feed forward fits; with a payload that nobody tells the axis stays behind.
    const auto largest_error = [](std::int64_t told, double real) {
        DriveBench drive;
        drive.refer();
        drive.go(60'000);
        drive.inject(drive::event::SetPayload{real});
        drive.set("MassLoad", told);
        drive.set("Acceleration", 5'000'000);
        drive.set("GoImmediately", 120'000);
        double most = 0;
        EXPECT_TRUE(drive.runs_until(
            [&] {
                most = std::max(most, std::abs(static_cast<double>(drive.get("ActualPositionFollowingError"))));
                return !drive.moving();
            },
            5s));
        return most;
    };
    const double right = largest_error(500, 0.5);
    EXPECT_GT(largest_error(0, 0.5), 3 * right);
    EXPECT_GT(largest_error(500, 0), 2 * right);
}

TEST(MotorParameters, ThatAreWrongShow) {
    const auto largest_error = [](const std::string& row, double share) {
        DriveBench drive;
        drive.refer();
        drive.go(60'000);
        if (!row.empty()) drive.set(row, static_cast<std::int64_t>(share * static_cast<double>(drive.get(row))));
        drive.set("Acceleration", 5'000'000);
        drive.set("GoImmediately", 120'000);
        double most = 0;
        EXPECT_TRUE(drive.runs_until(
            [&] {
                most = std::max(most, std::abs(static_cast<double>(drive.get("ActualPositionFollowingError"))));
                return !drive.moving();
            },
            5s));
        return most;
    };
    const double right = largest_error("", 1);
    EXPECT_GT(largest_error("MassMotor", 0.3), 2 * right);
    EXPECT_GT(largest_error("ForceConstantOfMotor", 2), 2 * right);
    EXPECT_GT(largest_error("FrictionForceDynamic", 0), 1.2 * right);
    EXPECT_GT(largest_error("BandwidthPositionController", 0.3), 2 * right);
    EXPECT_GT(largest_error("BandwidthCurrentController", 0.05), 1.5 * right);
}

// ------------------------------------------------------------------------------------------------- Cyclic

TEST(ParameterPCT, IsTheTimeToTheNextSetPoint) {
    for (const std::int64_t cycle : {1'000, 4'000}) {
        DriveBench drive;
        drive.reference(1, 8);
        drive.set("PDOCycleTime", cycle);
        drive.set("TargetPositionOrDistance", drive.get("PositionActualValue"));
        drive.set("Controlword", 0x1F);
        drive.set("TargetPositionOrDistance", drive.get("PositionActualValue") + 100);
        const auto begin = drive.now();
        EXPECT_TRUE(drive.runs_until([&] { return !drive.moving(); }, 1s));
        EXPECT_NEAR(seconds(drive.now() - begin), static_cast<double>(cycle) * 1e-6, 0.0011);
    }
}

TEST(ParameterFBCM, DelaysByACycleAndBridgesALateOne) {
    const auto slowest = [](std::int64_t buffered) {
        DriveBench drive;
        drive.reference(1, 8);
        drive.set("ForceBufferedCSPMode", buffered);
        drive.set("PDOCycleTime", 2'000);
        auto target = drive.get("PositionActualValue");
        drive.set("TargetPositionOrDistance", target);
        drive.set("Controlword", 0x1F);
        bool stood = false;
        for (int i = 0; i < 100; ++i) {
            target += 100;
            drive.set("TargetPositionOrDistance", target);
            drive.run(i % 10 == 5 ? 3ms : 2ms);  // one comes late, and the next one early
            if (i > 5) stood |= !drive.moving();
            if (i % 10 == 5) {
                target += 100;
                drive.set("TargetPositionOrDistance", target);
                drive.run(1ms);
            }
        }
        drive.run(100ms);
        EXPECT_NEAR(drive.position(), static_cast<double>(target), 5);
        return stood;
    };
    EXPECT_TRUE(slowest(0));
    EXPECT_FALSE(slowest(1));
}

TEST(ForceSectorsWithOffset, CountInCyclicMode) {
    DriveBench drive;
    drive.reference(1, 8);
    auto target = drive.get("PositionActualValue");
    drive.set("SetSectorOffset", target);
    drive.set("SectorIForceStart", 2'000);
    drive.set("SectorIForceEnd", 4'000);
    drive.set("IForceLow", -2'000);
    drive.set("IForceHigh", 2'000);
    drive.set("TargetPositionOrDistance", target);
    drive.set("Controlword", 0x1F);
    EXPECT_FALSE(drive.psr(psr::in_sector));
    drive.command("StartForceMonitoring");
    for (int i = 0; i < 60; ++i) {
        target += 50;
        drive.set("TargetPositionOrDistance", target);
        drive.run(1ms);
    }
    EXPECT_TRUE(drive.psr(psr::in_sector));
    drive.command("FinishForceMonitoring");
    EXPECT_EQ(drive.get("SectorIForceCurveFailed"), 1) << "only half of the width";
}

// ------------------------------------------------------------------------------------------------- Reference, gantry

TEST(ParameterPGMSO, IsTheOffsetOfAGantryWhileEGMSOSaysSo) {
    for (const std::int64_t enabled : {1, 0}) {
        DriveBench drive;
        drive.set("PresetGantryMasterSlaveOffset", 123);
        drive.set("EnableUserDefinedGantryMasterSlaveOffset", enabled);
        drive.set("DirectionReference", 2);
        drive.refer();
        EXPECT_EQ(drive.get("DetectedGantryMasterSlaveOffset"), enabled != 0 ? 123 : 0);
    }
}

TEST(ParameterSPAD, SwitchesTheAcknowledgeOff) {
    for (const std::int64_t disabled : {0, 1}) {
        DriveBench drive;
        drive.reference();
        drive.set("SetPointACKDisable", disabled);
        drive.set("TargetPositionOrDistance", 100'000);
        drive.set("Controlword", 0x1F);
        drive.run(10ms);
        EXPECT_EQ(drive.bit("Statusword", 12), disabled == 0);
    }
}

TEST(ParameterSOD, KeepsThePowerStageOffInTransition3) {
    for (const std::int64_t disabled : {0, 1}) {
        DriveBench drive;
        drive.set("P402SwitchOnAtTransition3Disable", disabled);
        drive.set("Controlword", 0x06);
        drive.set("Controlword", 0x07);
        EXPECT_EQ(drive.psr(psr::power), disabled == 0);
        drive.set("Controlword", 0x0F);
        EXPECT_TRUE(drive.psr(psr::power));
    }
}

// ------------------------------------------------------------------------------------------------- What it tells

TEST(Tells, TheMotion) {
    DriveBench drive;
    EXPECT_EQ(drive.get("TellStatus"), 0);
    EXPECT_EQ(drive.get("TellReferenceState"), 0);
    EXPECT_EQ(drive.get("TellTrajectoryState"), 0);
    drive.refer();
    EXPECT_EQ(drive.get("TellStatus"), 1);
    drive.go(60'000);
    drive.set("Acceleration", 200'000);
    drive.set("GoImmediately", 160'000);
    drive.run(250ms);
    EXPECT_EQ(drive.get("TellStatus"), 2);
    EXPECT_EQ(drive.get("TellTrajectoryState"), 1);
    drive.run(500ms);
    EXPECT_EQ(drive.get("TellTrajectoryState"), 2);
    EXPECT_NEAR(static_cast<double>(drive.get("TellVelocity")), 100'000, 1'500);
    EXPECT_EQ(drive.get("TellPosition"), drive.get("PositionActualValue"));
    drive.run(600ms);
    EXPECT_EQ(drive.get("TellTrajectoryState"), 3);
    EXPECT_TRUE(drive.stands_within());
    EXPECT_NEAR(static_cast<double>(drive.get("TellMotionTime")), 1'000 + 500 / 0.9, 10);
    EXPECT_EQ(drive.get("TellProcessTime"), drive.get("TellMotionTime"));
}

TEST(Tells, HeatCurrentAndVoltage) {
    DriveBench drive;
    drive.run(1ms);
    EXPECT_EQ(drive.get("TellTemperature"), 25);
    EXPECT_EQ(drive.get("TellTemperaturePowerStage"), 25);
    EXPECT_EQ(drive.get("TellVoltagePowerSupplyMotor"), 48'000);
    EXPECT_EQ(drive.get("LimitValue"), 1'000);
    EXPECT_EQ(drive.get("CalculatedValue"), 0);
    drive.inject(drive::event::SetTemperature{40});
    drive.inject(drive::event::SetSupply{36.5});
    EXPECT_EQ(drive.get("TellTemperature"), 40);
    EXPECT_EQ(drive.get("TellTemperaturePowerStage"), 40);
    EXPECT_EQ(drive.get("TellVoltagePowerSupplyMotor"), 36'500);
    drive.refer();
    drive.set("StopCurrent", 500);
    drive.inject(drive::event::PushAxis{-9});
    drive.run(10s);
    EXPECT_NEAR(static_cast<double>(drive.get("TellMotorCurrent")), 9'000 / 3.571, 500);
    EXPECT_GT(drive.get("TellTemperature"), 40);
    EXPECT_GT(drive.get("CalculatedValue"), 10);
}

TEST(Tells, WhichAxisItIs) {
    DriveBench linear(drive::shipped_kind("elax-ex-50f20"));
    EXPECT_EQ(linear.text("MotorType"), "50201");
    EXPECT_EQ(linear.get("LinearAxisResolution"), 32'767) << "two bytes hold no more";
    EXPECT_EQ(linear.get("LinearAxisStroke"), 32'767);
    EXPECT_EQ(linear.get("MassMotor"), 230);
    EXPECT_EQ(linear.get("ForceConstantOfMotor"), 8'333);
    EXPECT_EQ(linear.get("ResistancePhasePhase"), 5'200);
    EXPECT_EQ(linear.get("InductancePhasePhase"), 3'000);
    EXPECT_EQ(linear.get("FrictionForceDynamic"), 500);
    EXPECT_EQ(linear.get("FrictionForceStatic"), 550);
    EXPECT_EQ(linear.get("StopCurrent"), 240);
    DriveBench turning(rotative());
    EXPECT_EQ(turning.text("MotorType"), "rotative");
    EXPECT_EQ(turning.get("LinearAxisResolution"), 0);
    EXPECT_EQ(turning.get("EncoderIncrements"), 24'000);
    EXPECT_EQ(turning.get("PolePairs"), 4);
    EXPECT_EQ(turning.get("MassMotor"), 40'000);  // 1e-9 kg m2
}

TEST(Tells, TheErrorOfTheSafetyUnit) {
    DriveBench drive;
    drive.refer();
    EXPECT_EQ(drive.get("TellSMUError"), 0);
    drive.go(20'000);
    drive.set("Speed", 400'000);
    drive.set("Acceleration", 4'000'000);
    drive.inject(drive::event::SafetyStop{drive::event::SafetyFunction::sls, true});
    drive.run(600ms);
    drive.set("GoImmediately", 200'000);
    EXPECT_TRUE(drive.runs_until([&] { return drive.psr(psr::error); }, 2s));
    EXPECT_NE(drive.get("TellSMUError"), 0);
    EXPECT_EQ(drive.get("TellSMUErrorAlias"), drive.get("TellSMUError"));
}

TEST(Tells, ThatAMemoryIsEmpty) {
    DriveBench drive;
    drive.refer();
    drive.set("StartProgramNumber", 5);
    EXPECT_EQ(drive.get("TellError"), 81);
    drive.go(70'000);
    EXPECT_EQ(drive.get("TellError"), 0) << "a motion that begins takes the warning away";
    drive.set("StartProfileNumber", 5);
    EXPECT_EQ(drive.get("TellError"), 82);
    EXPECT_FALSE(drive.moving());
}

TEST(Events, AreTaken) {
    DriveBench drive;
    for (const std::int64_t input : {0, 12}) {
        drive.set("EventTrackInput", input);
        drive.set("DisableTrackInput", input);
    }
    drive.set("EventActivation", 1);
    drive.refuses_write("EventTrackInput", 13, Refusal::too_high);
}

}  // namespace
}  // namespace servobus
