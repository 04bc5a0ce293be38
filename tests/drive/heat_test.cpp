#include "drive/heat.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drive/time.hpp"

namespace servobus::drive {
namespace {

TEST(Heat, FollowsTheClosedForm) {
    const AxisKind kind;
    Heat heat(kind);
    heat.step(3, 100);
    const double part = 1 - std::exp(-100 / kind.thermal_time);
    EXPECT_NEAR(heat.winding(), 25 + 0.75 * kind.resistance * 9 * kind.thermal_resistance * part, 1e-9);
    EXPECT_NEAR(heat.i2t(), 9 * part, 1e-12);
    EXPECT_GT(heat.power_stage(), 25);
}

TEST(Heat, ManyShortStepsAreOneLongOne) {
    const AxisKind kind;
    Heat once(kind);
    Heat often(kind);
    once.step(4, 10);
    for (int i = 0; i < 100'000; ++i) {
        often.step(4, control_period_s);
    }
    EXPECT_NEAR(once.winding(), often.winding(), 1e-6);
    EXPECT_NEAR(once.power_stage(), often.power_stage(), 1e-6);
    EXPECT_NEAR(once.i2t(), often.i2t(), 1e-6);
}

TEST(Heat, TheNominalCurrentIsStoodForEver) {
    const AxisKind kind;
    Heat heat(kind);
    heat.step(kind.nominal_current, 1e6);
    EXPECT_LT(heat.i2t(), heat.i2t_limit());
    EXPECT_LT(heat.winding(), kind.temperature_limit);
    heat.step(1.1 * kind.nominal_current, 1e6);
    EXPECT_GT(heat.i2t(), heat.i2t_limit());
}

TEST(Heat, CoolsDownToRest) {
    Heat heat((AxisKind()));
    EXPECT_TRUE(heat.at_rest());
    heat.step(10, 60);
    EXPECT_FALSE(heat.at_rest());
    heat.step(0, 1e5);
    EXPECT_TRUE(heat.at_rest());
    heat.set_surroundings(40);
    EXPECT_NEAR(heat.winding(), 40, 1e-2);
}

}  // namespace
}  // namespace servobus::drive
