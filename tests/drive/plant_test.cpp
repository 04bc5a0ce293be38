#include "drive/plant.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drive/time.hpp"

namespace servobus::drive {
namespace {

AxisKind smooth_kind() {
    AxisKind kind;
    kind.cogging = 0;
    return kind;
}

void run(Plant& plant, double seconds, double current = 0, bool brake = false) {
    for (int i = 0; i < std::lround(seconds / control_period_s); ++i) {
        plant.step(current, brake);
    }
}

/// Pushed for a moment, then let go.
Plant pushed(const AxisKind& kind, double force, double seconds) {
    Plant plant(kind);
    plant.set_external_force(force);
    run(plant, seconds);
    plant.set_external_force(0);
    return plant;
}

TEST(Plant, AcceleratesAsMassAndFrictionSay) {
    AxisKind kind = smooth_kind();
    kind.friction_viscous = 0;
    Plant plant(kind);
    run(plant, 0.1, 1.0);
    const double acceleration = (kind.force_constant - kind.friction_dynamic) / kind.moving_mass;
    EXPECT_NEAR(plant.velocity(), acceleration * 0.1 * 1e6, 0.01 * plant.velocity());
}

TEST(Plant, FrictionStopsItWhereItsEnergyIsUsedUp) {
    AxisKind kind = smooth_kind();
    kind.friction_viscous = 0;
    Plant plant = pushed(kind, 10, 0.01);
    const double start = plant.position();
    const double speed = plant.velocity() * 1e-6;
    run(plant, 1);
    const double way = kind.moving_mass * speed * speed / 2 / kind.friction_dynamic;
    EXPECT_NEAR((plant.position() - start) * 1e-6, way, 0.01 * way);
    EXPECT_EQ(plant.velocity(), 0);
    EXPECT_TRUE(plant.at_rest());
}

TEST(Plant, StictionHolds) {
    Plant plant(smooth_kind());
    plant.set_external_force(1.29);
    run(plant, 1);
    EXPECT_EQ(plant.position(), 60'000);
    EXPECT_TRUE(plant.at_rest());
    plant.set_external_force(1.31);
    EXPECT_FALSE(plant.at_rest());
    run(plant, 0.1);
    EXPECT_GT(plant.position(), 60'000);
}

TEST(Plant, CoastsToRestWithoutTrembling) {
    Plant plant = pushed(AxisKind{}, 20, 0.01);
    double before = plant.position();
    while (!plant.at_rest()) {
        plant.step(0, false);
        ASSERT_GE(plant.position(), before);
        before = plant.position();
    }
    run(plant, 0.1);
    EXPECT_EQ(plant.position(), before);
}

TEST(Plant, CoggingPushesTowardsItsRestPlaces) {
    AxisKind kind;
    kind.cogging = 5;
    const Plant plant(kind);
    EXPECT_NEAR(plant.cogging_at(kind.cogging_period / 4), 5, 1e-9);
    EXPECT_NEAR(plant.cogging_at(-kind.cogging_period / 4), -5, 1e-9);
    kind.start_position = kind.cogging_period / 4;
    EXPECT_FALSE(Plant(kind).at_rest());
}

TEST(Plant, StopsHoldAgainstAnyMass) {
    for (const double payload : {0.0, 1.0, 100'000.0}) {
        for (const double current : {-20.0, 20.0}) {
            Plant plant(smooth_kind());
            plant.set_payload(payload);
            run(plant, payload > 10 ? 120 : 3, current);
            const double force = smooth_kind().force_constant * current;
            EXPECT_NEAR(plant.contact_force(), force, 0.05 * std::abs(force) + 1.3) << payload;
            const double stop = current > 0 ? 231'500 : -1'500;
            EXPECT_NEAR(plant.position(), stop, 1'000) << payload;
        }
    }
}

TEST(Plant, AnObstacleIsASpring) {
    for (const double stiffness : {1'000.0, 50'000.0, 1e7}) {
        Plant plant(smooth_kind());
        plant.set_obstacle(Obstacle{70'000, stiffness, false});
        run(plant, 2, 2.0);
        EXPECT_TRUE(plant.at_rest()) << stiffness;
        EXPECT_NEAR(plant.contact_force(), stiffness * (plant.position() - 70'000) * 1e-6, 1e-6) << stiffness;
        EXPECT_NEAR(plant.contact_force(), 2 / 0.28, 1.31) << stiffness;
    }
}

TEST(Plant, AnObstacleFromAboveHindersTheOtherDirection) {
    Plant plant(smooth_kind());
    plant.set_obstacle(Obstacle{50'000, 50'000, true});
    run(plant, 1, -2.0);
    EXPECT_NEAR(plant.contact_force(), -2 / 0.28, 1.31);
    EXPECT_NEAR(plant.position(), 50'000, 200);
    run(plant, 0.05, 2.0);
    EXPECT_EQ(plant.contact_force(), 0);
    EXPECT_GT(plant.position(), 50'000);
}

TEST(Plant, AnObstaclePutIntoTheAxisOnlyTouchesIt) {
    Plant plant(smooth_kind());
    plant.set_obstacle(Obstacle{50'000, 50'000, false});
    run(plant, 0.1);
    EXPECT_EQ(plant.position(), 60'000);
    run(plant, 0.5, 2.0);
    EXPECT_NEAR(plant.position(), 60'000, 200);
    run(plant, 0.2, -2.0);
    ASSERT_LT(plant.position(), 50'000);
    run(plant, 1, 2.0);
    EXPECT_NEAR(plant.position(), 50'000, 200);
}

TEST(Plant, RemovingTheObstacleReleasesTheAxis) {
    Plant plant(smooth_kind());
    plant.set_obstacle(Obstacle{70'000, 50'000, false});
    run(plant, 1, 2.0);
    ASSERT_TRUE(plant.at_rest());
    plant.set_obstacle(std::nullopt);
    EXPECT_FALSE(plant.at_rest());
    run(plant, 0.1, 2.0);
    EXPECT_GT(plant.position(), 75'000);
}

TEST(Plant, ABlockedAxisStandsStill) {
    Plant plant = pushed(AxisKind{}, 20, 0.01);
    plant.set_blocked(true);
    const double position = plant.position();
    run(plant, 0.1, 10);
    EXPECT_EQ(plant.position(), position);
    EXPECT_EQ(plant.velocity(), 0);
    EXPECT_TRUE(plant.at_rest());
    plant.set_blocked(false);
    EXPECT_FALSE(plant.at_rest());
    run(plant, 0.1, 10);
    EXPECT_GT(plant.position(), position);
}

TEST(Plant, TheBrakeStopsAndHolds) {
    Plant braked = pushed(AxisKind{}, 20, 0.02);
    Plant free = braked;
    const double start = braked.position();
    run(braked, 1, 0, true);
    run(free, 1);
    EXPECT_LT(braked.position() - start, (free.position() - start) / 5);
    const double position = braked.position();
    braked.set_external_force(500);
    run(braked, 1, 0, true);
    EXPECT_EQ(braked.position(), position);
}

TEST(Plant, StaysFiniteWhateverHappens) {
    for (const double payload : {0.0, 3.0, 100'000.0, -5.0, 1e300}) {
        for (const double stiffness : {0.0, 1e4, 1e7, 1e300}) {
            Plant plant((AxisKind()));
            plant.set_payload(payload);
            plant.set_obstacle(Obstacle{61'000, stiffness, false});
            for (int i = 0; i < 3'000; ++i) {
                plant.step((i / 500) % 2 == 0 ? 20 : -20, i % 700 == 0);
                ASSERT_TRUE(std::isfinite(plant.position()) && std::isfinite(plant.contact_force()));
            }
        }
    }
}

}  // namespace
}  // namespace servobus::drive
