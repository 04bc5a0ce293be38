#include "drive/servo.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace servobus::drive {
namespace {

/// The current that it comes to when nothing moves.
double steady_current(Servo& servo, const ServoSettings& settings, double error, double velocity = 0,
                      double supply = 48, bool moving = false, double cogging = 0) {
    double current = 0;
    for (int i = 0; i < 200; ++i) {
        current = servo.step({error, 0, 0}, moving, 0, velocity, cogging, supply, settings);
    }
    return current;
}

TEST(Servo, TheLimitsForStandstillAndMotion) {
    Servo servo((AxisKind()));
    ServoSettings settings;
    settings.stop_limit = 2;
    settings.run_limit = 5;
    EXPECT_NEAR(steady_current(servo, settings, 1e6), 2, 1e-6);
    EXPECT_NEAR(steady_current(servo, settings, -1e6, 0, 48, true), -5, 1e-6);
    EXPECT_TRUE(servo.saturated());
    EXPECT_FALSE(servo.at_force_limit());
}

TEST(Servo, NoMoreThanTheMotorStands) {
    Servo servo((AxisKind()));
    ServoSettings settings;
    settings.stop_limit = 20;
    EXPECT_NEAR(steady_current(servo, settings, 1e6), AxisKind{}.peak_current, 1e-6);
}

TEST(Servo, TheForceLimitLeavesCoggingOut) {
    Servo servo((AxisKind()));
    ServoSettings settings;
    settings.force_limit = 0.5;
    settings.cogging_compensation = true;
    const double learned = -0.6 / AxisKind{}.force_constant;
    EXPECT_NEAR(steady_current(servo, settings, 1e5, 0, 48, false, 0.6), 0.5 + learned, 1e-6);
    EXPECT_TRUE(servo.at_force_limit());
    EXPECT_TRUE(servo.settled());
}

TEST(Servo, NothingWindsUpAtTheForceLimit) {
    Servo servo((AxisKind()));
    ServoSettings settings;
    settings.force_limit = 0.5;
    for (int i = 0; i < 100; ++i) {
        steady_current(servo, settings, 1e5);
    }
    EXPECT_LT(std::abs(steady_current(servo, settings, 0)), 0.05);
}

TEST(Servo, BackEmfAndSupplyLimitTheCurrent) {
    const AxisKind kind;
    Servo servo(kind);
    const ServoSettings settings;
    const double free_speed = 48 / (kind.force_constant * 2 / std::numbers::sqrt3) * kind.increments_per_unit;
    EXPECT_NEAR(steady_current(servo, settings, 1e9, 0.99 * free_speed, 48, true), 0.01 * 48 / (2.5 * 0.8660254), 1e-4);
    EXPECT_NEAR(steady_current(servo, settings, 1e9, 1.5 * free_speed, 48, true), 0, 1e-6);
    EXPECT_NEAR(steady_current(servo, settings, -1e9, free_speed, 48, true), -10, 1e-6);
}

TEST(Servo, WithoutSupplyThereIsNoCurrent) {
    Servo servo((AxisKind()));
    EXPECT_EQ(steady_current(servo, ServoSettings{}, 1e6, 0, 0), 0);
    EXPECT_TRUE(servo.saturated());
}

TEST(Servo, InsideTheDeadBandItIsQuiet) {
    Servo servo((AxisKind()));
    const ServoSettings settings;
    EXPECT_EQ(steady_current(servo, settings, 0.9), steady_current(servo, settings, 0.9));
    EXPECT_TRUE(servo.settled());
    steady_current(servo, settings, 20);
    EXPECT_FALSE(servo.settled());
}

TEST(Servo, WithoutPositionControlOnlyCoggingIsMadeUpFor) {
    Servo servo((AxisKind()));
    ServoSettings settings;
    settings.position_control = false;
    EXPECT_EQ(steady_current(servo, settings, 1e5), 0);
    settings.cogging_compensation = true;
    EXPECT_NEAR(steady_current(servo, settings, 1e5, 0, 48, false, 0.6), -0.6 * 0.28, 1e-9);
    EXPECT_TRUE(servo.settled());
}

TEST(Servo, TheSearchLimitIsNoForceLimit) {
    Servo servo((AxisKind()));
    ServoSettings settings;
    settings.search_limit = 0.7;
    EXPECT_NEAR(steady_current(servo, settings, 1e5), 0.7, 1e-6);
    EXPECT_FALSE(servo.at_force_limit());
}

}  // namespace
}  // namespace servobus::drive
