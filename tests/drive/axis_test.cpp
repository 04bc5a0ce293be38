#include "drive/axis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>

#include "drive/time.hpp"
#include "tests/support/axis_kinds.hpp"

namespace servobus::drive {
namespace {

constexpr double speed = 1e5;
constexpr double acceleration = 1e6;
constexpr double window = 2'000;

MotionLimits default_limits() { return {speed, acceleration, jerk_of(acceleration, speed, 20)}; }

void run(Axis& axis, double seconds) {
    for (int i = 0; i < std::lround(seconds / control_period_s); ++i) {
        axis.step();
    }
}

/// Until it rests; the time that it took.
double settle(Axis& axis, double at_most = 0.3) {
    int periods = 0;
    while (!axis.at_rest() && periods * control_period_s < at_most) {
        axis.step();
        ++periods;
    }
    EXPECT_TRUE(axis.at_rest()) << "error " << axis.following_error() << ", current " << axis.current();
    return periods * control_period_s;
}

Axis standing(const AxisKind& kind = {}, std::uint64_t seed = 1) {
    Axis axis(kind, seed);
    axis.switch_on();
    settle(axis);
    return axis;
}

/// While the set point moves; the largest following error.
double finish(Axis& axis, double at_most = 20) {
    double worst = 0;
    for (int i = 0; axis.moving() && i * control_period_s < at_most; ++i) {
        axis.step();
        worst = std::max(worst, std::abs(axis.following_error()));
    }
    EXPECT_FALSE(axis.moving());
    return worst;
}

double move_by(Axis& axis, double way) {
    axis.move_to(axis.set_point().position + way, default_limits());
    return finish(axis);
}

class EveryKind : public testing::TestWithParam<AxisKind> {};

TEST_P(EveryKind, DefaultMovesEndWhereTheyShould) {
    Axis axis = standing(GetParam());
    const double stroke = GetParam().has_stops ? GetParam().travel : 100'000;
    for (const double way : {0.3 * stroke, -0.2 * stroke, 500.0, -40.0, 7.0, 1.0, -1.0}) {
        const double target = axis.set_point().position + way;
        EXPECT_LT(move_by(axis, way), 50) << way;
        settle(axis);
        EXPECT_LE(std::abs(target - static_cast<double>(axis.position())), 2) << way;
        EXPECT_EQ(axis.set_point().position, target);
    }
}

TEST_P(EveryKind, ThereAndBackIsWhereItWas) {
    Axis axis = standing(GetParam());
    const auto start = axis.position();
    for (int i = 0; i < 4; ++i) {
        move_by(axis, i % 2 == 0 ? 15'000 : -15'000);
        settle(axis);
    }
    EXPECT_NEAR(static_cast<double>(axis.position()), static_cast<double>(start), 2);
}

TEST_P(EveryKind, BearsThreeTimesTheMassThatItKnows) {
    Axis axis = standing(GetParam());
    axis.plant().set_payload(2 * GetParam().moving_mass);
    EXPECT_LT(move_by(axis, 15'000), window / 4);
    settle(axis);
    EXPECT_LE(std::abs(axis.following_error()), 2);
}

TEST_P(EveryKind, StaysCoolEnoughAtItsNominalCurrent) {
    Heat heat(GetParam());
    heat.step(GetParam().nominal_current, 1e6);
    EXPECT_LT(heat.winding(), GetParam().temperature_limit);
    EXPECT_LT(heat.power_stage(), 80);
}

TEST_P(EveryKind, CanDoTenTimesTheDefaultAcceleration) {
    const AxisKind& kind = GetParam();
    const double force = kind.force_constant * kind.peak_current - kind.friction_static - kind.cogging;
    EXPECT_GT(force / kind.moving_mass * kind.increments_per_unit, 10 * acceleration);
    EXPECT_LT(kind.cogging, kind.friction_static) << "it would not stay where it is without power";
}

INSTANTIATE_TEST_SUITE_P(Axis, EveryKind, testing::ValuesIn(shipped_kinds()), [](const auto& each) {
    std::string name = each.param.key;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
});

TEST(AxisFiles, TheDefaultOfAxisKindIsTheLinaxLxc) {
    const AxisKind file = shipped_kind("linax-lxc-230f10");
    const AxisKind standard;
    for (const auto& [name, member] : numbers_of_axes()) {
        EXPECT_DOUBLE_EQ(file.*member, standard.*member) << name;
    }
    EXPECT_EQ(file.name, standard.name);
    EXPECT_EQ(file.motor_type, standard.motor_type);
    EXPECT_EQ(file.family, standard.family);
    EXPECT_EQ(file.motion, standard.motion);
    EXPECT_EQ(file.reference, standard.reference);
    EXPECT_EQ(file.has_stops, standard.has_stops);
    EXPECT_EQ(file.pole_pairs, standard.pole_pairs);
}

TEST(AxisFiles, RotativeAxesCountRadian) {
    for (const AxisKind& kind : shipped_kinds()) {
        if (kind.motion == AxisKind::Motion::rotative) {
            EXPECT_NEAR(kind.increments_per_unit * 2 * std::numbers::pi, kind.increments_per_turn, 1e-6) << kind.key;
            EXPECT_GE(kind.start_position, 0);
            EXPECT_LT(kind.start_position, kind.increments_per_turn);
        }
    }
}

TEST(Axis, TheEncoderCountsFromZeroUnlessItIsAbsolute) {
    EXPECT_EQ(Axis(AxisKind{}, 1).position(), 0);
    EXPECT_EQ(Axis(AxisKind{}, 1).encoder_offset(), -60'000);
    AxisKind kind = shipped_kind("rotax-rxhq-50-12t0-3");
    EXPECT_EQ(Axis(kind, 1).position(), 87'000);
    EXPECT_EQ(Axis(kind, 1).encoder_offset(), 0);
}

TEST(Axis, OffItCoasts) {
    Axis axis = standing();
    axis.run_at(speed, acceleration, 1e8);
    run(axis, 0.3);
    axis.switch_off();
    EXPECT_FALSE(axis.moving());
    EXPECT_EQ(axis.current(), 0);
    const auto begin = axis.position();
    settle(axis);
    EXPECT_GT(axis.position(), begin + 100);
    EXPECT_EQ(axis.following_error(), 0);
    axis.move_to(0, default_limits());
    EXPECT_FALSE(axis.moving());
}

TEST(Axis, SwitchedOnItHoldsAgainstGravity) {
    Axis axis(AxisKind{}, 1);
    axis.set_brake(true);
    axis.plant().set_external_force(-8);
    axis.switch_on();
    settle(axis);
    axis.set_brake(false);
    EXPECT_FALSE(axis.at_rest());
    settle(axis);
    EXPECT_LE(std::abs(axis.following_error()), 2);
    EXPECT_NEAR(axis.current() * axis.kind().force_constant, 8, 2);
}

TEST(Axis, APushIsMadeGood) {
    Axis axis = standing();
    axis.plant().set_external_force(5);
    EXPECT_FALSE(axis.at_rest());
    settle(axis);
    EXPECT_LE(std::abs(axis.following_error()), 2);
}

TEST(Axis, AnImpossibleRampLeavesTheWindow) {
    Axis axis = standing();
    const double impossible = 2e8;
    axis.move_to(150'000, {2e6, impossible, jerk_of(impossible, 2e6, 20)});
    EXPECT_GT(finish(axis), window);
    settle(axis);
    EXPECT_LE(std::abs(axis.following_error()), 2);
}

TEST(Axis, ABlockedAxisIsLeftBehind) {
    Axis axis = standing();
    axis.plant().set_blocked(true);
    axis.run_at(speed, acceleration, 1e8);
    double before = 0;
    for (int i = 0; i < 20; ++i) {
        run(axis, 0.01);
        EXPECT_GT(axis.following_error(), before);
        before = axis.following_error();
    }
    EXPECT_GT(before, window);
    axis.stop(acceleration, 1e8);
    finish(axis);
    settle(axis);
    axis.hold();
    EXPECT_LE(std::abs(axis.following_error()), 1);
}

TEST(Axis, PressesWithItsForceLimit) {
    for (const double limit : {1.0, 2.0, 5.0}) {
        for (const double stiffness : {2'000.0, 50'000.0, 1e7}) {
            Axis axis = standing();
            axis.plant().set_obstacle(Obstacle{80'000, stiffness, false});
            axis.settings().force_limit = limit;
            axis.run_at(20'000, acceleration, 1e8);
            run(axis, 1.5);
            EXPECT_TRUE(axis.at_force_limit());
            axis.stop(acceleration, 1e8);
            finish(axis);
            settle(axis);
            const double force = limit * axis.kind().force_constant;
            const double friction = axis.kind().friction_static + axis.kind().cogging;
            EXPECT_NEAR(axis.contact_force(), force, 0.1 * force + friction) << limit << ' ' << stiffness;
            EXPECT_TRUE(axis.at_force_limit());
            EXPECT_NEAR(axis.force_current(), limit, 1e-3);
        }
    }
}

TEST(Axis, FourNewtonsOnAnElax) {
    Axis axis = standing(shipped_kind("elax-ex-50f20"));
    axis.plant().set_obstacle(Obstacle{25'000, 50'000, false});
    axis.settings().force_limit = 0.48;  // 48 x 10 mA
    axis.settings().cogging_compensation = true;
    axis.run_at(10'000, acceleration, 1e8);
    run(axis, 1.2);
    axis.stop(acceleration, 1e8);
    finish(axis);
    settle(axis);
    EXPECT_TRUE(axis.at_force_limit());
    EXPECT_NEAR(axis.contact_force(), 4, axis.kind().friction_static);
    EXPECT_NEAR(axis.force_current(), 0.48, 1e-3);
}

TEST(Axis, BackFromAnObstacleNothingHasWoundUp) {
    Axis axis = standing();
    axis.plant().set_obstacle(Obstacle{70'000, 50'000, false});
    axis.settings().force_limit = 2;
    move_by(axis, 15'000);
    run(axis, 2);
    ASSERT_TRUE(axis.at_force_limit());
    axis.settings().force_limit = 0;
    axis.move_to(0, default_limits());
    finish(axis);
    settle(axis);
    EXPECT_LE(std::abs(axis.following_error()), 2);
}

TEST(Axis, LearnedCoggingIsLeftOutOfTheForce) {
    AxisKind kind;
    kind.cogging = 1.2;
    Axis plain = standing(kind);
    Axis calibrated = standing(kind);
    calibrated.settings().cogging_compensation = true;
    const auto spread = [](Axis& axis) {
        axis.run_at(speed, acceleration, 1e8);
        run(axis, 0.3);
        double low = 1e9;
        double high = -1e9;
        for (int i = 0; i < 6'000; ++i) {
            axis.step();
            low = std::min(low, axis.force_current());
            high = std::max(high, axis.force_current());
        }
        return high - low;
    };
    EXPECT_GT(spread(plain), 0.5);
    EXPECT_LT(spread(calibrated), 0.05);
}

TEST(Axis, FollowsAStreamOfSetPoints) {
    Axis axis = standing();
    const double cycle = 0.002;
    double worst = 0;
    for (int i = 1; i <= 500; ++i) {
        axis.follow(80 * i, cycle);
        for (int k = 0; k < 20; ++k) {
            axis.step();
            EXPECT_TRUE(axis.moving());
            worst = std::max(worst, i > 25 ? std::abs(axis.following_error()) : 0);
        }
        EXPECT_EQ(axis.set_point().position, 80 * i);
        EXPECT_NEAR(axis.set_point().velocity, 40'000, 1e-3);
    }
    EXPECT_LT(worst, 30);
    axis.step();
    EXPECT_FALSE(axis.moving());
    EXPECT_EQ(axis.set_point().position, 40'000);
    settle(axis);
    EXPECT_LE(std::abs(axis.following_error()), 2);
}

TEST(Axis, FollowsASine) {
    Axis axis = standing();
    double worst = 0;
    for (int i = 0; i < 2'000; ++i) {
        axis.follow(std::round(20'000 * std::sin(2 * std::numbers::pi * i * 0.001)), 0.001);
        for (int k = 0; k < 10; ++k) {
            axis.step();
            worst = std::max(worst, i > 50 ? std::abs(axis.following_error()) : 0);
        }
    }
    EXPECT_LT(worst, 60);
}

TEST(Axis, FollowingWhereItStandsIsNoMotion) {
    Axis axis = standing();
    for (int i = 0; i < 50; ++i) {
        axis.follow(0, 0.001);
        EXPECT_FALSE(axis.moving());
        run(axis, 0.001);
    }
    EXPECT_EQ(axis.position(), 0);
}

TEST(Axis, JogsAndChangesItsMindOnTheFly) {
    Axis axis = standing();
    double before = 0;
    double last_velocity = 0;
    for (const double velocity : {50'000.0, 120'000.0, -80'000.0, 10'000.0}) {
        axis.run_at(velocity, acceleration, 1e8);
        EXPECT_TRUE(axis.moving());
        for (int i = 0; i < 4'000; ++i) {
            axis.step();
            ASSERT_LE(std::abs(axis.set_point().velocity - last_velocity), acceleration * control_period_s * 1.01);
            ASSERT_LE(std::abs(axis.set_point().position - before), 120'001 * control_period_s);
            ASSERT_LT(std::abs(axis.following_error()), 100);
            last_velocity = axis.set_point().velocity;
            before = axis.set_point().position;
        }
        EXPECT_NEAR(axis.set_point().velocity, velocity, 1e-6);
        EXPECT_NEAR(axis.velocity(), velocity, 0.02 * std::abs(velocity) + 200);
    }
    axis.stop(acceleration, 1e8);
    finish(axis);
    settle(axis);
}

TEST(Axis, StopsQuickly) {
    Axis axis = standing();
    axis.move_to(150'000, default_limits());
    run(axis, 0.5);
    const auto begin = axis.position();
    axis.stop(1e7, 1e10);
    finish(axis);
    EXPECT_NEAR(static_cast<double>(axis.position() - begin), speed * speed / 2e7, 60);
    settle(axis);
    EXPECT_FALSE(axis.moving());
}

TEST(Axis, TheSupplyLimitsItsSpeed) {
    Axis axis = standing(shipped_kind("third-party-rotative"));
    const double free_speed = 1.32e6;  // 48 V over 2 / sqrt(3) x 0.12 Vs
    axis.run_at(2 * free_speed, 2e7, 1e10);
    run(axis, 2);
    EXPECT_LT(axis.velocity(), free_speed);
    EXPECT_GT(axis.velocity(), 0.8 * free_speed);
    EXPECT_GT(axis.following_error(), window);
}

TEST(Axis, WithoutSupplyItCannotHold) {
    Axis axis = standing();
    axis.plant().set_external_force(-5);
    settle(axis);
    axis.set_supply_voltage(0);
    EXPECT_FALSE(axis.at_rest());
    run(axis, 0.2);
    EXPECT_GT(axis.following_error(), window);
}

TEST(Axis, ALostEncoderSaysWhatItSaidLast) {
    for (const char* key : {"linax-lxc-230f10", "rotax-rxhq-50-12t0-3"}) {
        Axis axis = standing(shipped_kind(key));
        axis.run_at(20'000, acceleration, 1e8);
        run(axis, 0.2);
        axis.set_encoder_lost(true);
        const auto frozen = axis.position();
        axis.switch_off();
        run(axis, 0.2);
        EXPECT_EQ(axis.position(), frozen);
        EXPECT_EQ(axis.velocity(), 0);
        axis.set_encoder_lost(false);
        const bool absolute = axis.kind().reference == AxisKind::Reference::absolute;
        EXPECT_EQ(axis.position() != frozen, absolute) << key;
    }
}

TEST(Axis, SettingThePositionMovesNothing) {
    Axis axis = standing();
    move_by(axis, 5'000);
    settle(axis);
    const double error = axis.following_error();
    const double truth = axis.plant().position();
    axis.set_position(-123'456);
    EXPECT_EQ(axis.position(), -123'456);
    EXPECT_EQ(axis.following_error(), error);
    run(axis, 0.1);
    EXPECT_EQ(axis.plant().position(), truth);
}

TEST(Axis, OnlyNoiseAndWarmthChangeAtRest) {
    Axis axis = standing();
    axis.plant().set_external_force(-6);
    settle(axis);
    const double truth = axis.plant().position();
    const double current = axis.current();
    const double force_current = axis.force_current();
    for (int i = 0; i < 5'000; ++i) {
        axis.step();
        ASSERT_TRUE(axis.at_rest());
        ASSERT_EQ(axis.plant().position(), truth);
        ASSERT_EQ(axis.current(), current);
        ASSERT_EQ(axis.force_current(), force_current);
        ASSERT_NEAR(axis.measured_current(), current, 0.01);
    }
}

TEST(Axis, RestingIsTheSameAsStepping) {
    Axis stepped = standing();
    Axis rested = standing();
    stepped.plant().set_external_force(-6);
    rested.plant().set_external_force(-6);
    settle(stepped);
    settle(rested);
    run(stepped, 0.5);
    rested.rest(4'000);
    rested.rest(1'000);
    EXPECT_EQ(stepped.measured_current(), rested.measured_current());
    EXPECT_NEAR(stepped.heat().winding(), rested.heat().winding(), 1e-9);
    move_by(stepped, 10'000);
    move_by(rested, 10'000);
    EXPECT_EQ(stepped.plant().position(), rested.plant().position());
    EXPECT_EQ(stepped.measured_current(), rested.measured_current());
}

TEST(Axis, ChangedSettingsEndTheRest) {
    Axis axis = standing();
    axis.settings().force_limit = 1;
    EXPECT_FALSE(axis.at_rest());
    settle(axis);
}

TEST(Axis, TheSameSeedIsTheSameRun) {
    const auto trace = [](std::uint64_t seed) {
        Axis axis = standing(AxisKind{}, seed);
        axis.move_to(20'000, default_limits());
        std::vector<double> values;
        for (int i = 0; i < 5'000; ++i) {
            axis.step();
            values.insert(values.end(), {axis.measured_current(), axis.plant().position(), axis.heat().winding()});
        }
        return values;
    };
    EXPECT_EQ(trace(7), trace(7));
    EXPECT_NE(trace(7), trace(8));
}

TEST(Axis, MeasuredCurrentIsNoisyOnlyWhileOn) {
    Axis axis(AxisKind{}, 3);
    run(axis, 0.1);
    EXPECT_EQ(axis.measured_current(), 0);
    axis.switch_on();
    double sum = 0;
    double squares = 0;
    for (int i = 0; i < 10'000; ++i) {
        axis.step();
        const double noise = axis.measured_current() - axis.current();
        sum += noise;
        squares += noise * noise;
    }
    EXPECT_NEAR(sum / 10'000, 0, 1e-4);
    EXPECT_NEAR(std::sqrt(squares / 10'000), 0.0025, 0.001);
}

// Anything at any time: numbers stay finite, and the position goes no further than the velocity says.

class Chance {
public:
    explicit Chance(std::uint32_t seed) : random_(seed) {}

    int pick(int count) { return static_cast<int>(random_() % static_cast<std::uint32_t>(count)); }
    double between(double low, double high) {
        return low + (high - low) * static_cast<double>(random_()) / 4294967295.0;
    }

private:
    std::mt19937 random_;
};

void disturb(Axis& axis, Chance& chance) {
    const double position = chance.between(-300'000, 300'000);
    switch (chance.pick(7)) {
        case 0:
            axis.plant().set_payload(std::pow(10, chance.between(-4, 5)));
            break;
        case 1:
            axis.plant().set_obstacle(Obstacle{position, std::pow(10, chance.between(0, 7)), chance.pick(2) == 0});
            break;
        case 2:
            axis.plant().set_obstacle(std::nullopt);
            axis.plant().set_payload(0);
            break;
        case 3:
            axis.plant().set_blocked(chance.pick(2) == 0);
            break;
        case 4:
            axis.plant().set_external_force(chance.between(-50, 50));
            break;
        case 5:
            axis.set_encoder_lost(chance.pick(3) == 0);
            break;
        default:
            axis.set_supply_voltage(chance.between(0, 80));
            break;
    }
}

void retune(Axis& axis, Chance& chance) {
    ServoSettings& settings = axis.settings();
    settings.bandwidth = std::pow(10, chance.between(0, 3.7));
    settings.current_bandwidth = std::pow(10, chance.between(0.7, 3.7));
    settings.mass = axis.kind().moving_mass * std::pow(10, chance.between(-2, 5));
    settings.friction = chance.between(0, 10);
    settings.force_limit = chance.pick(2) == 0 ? chance.between(0, 5) : 0;
    settings.run_limit = chance.between(0.1, 20);
    settings.stop_limit = chance.between(0.1, 20);
    settings.cogging_compensation = chance.pick(2) == 0;
    settings.position_control = chance.pick(5) != 0;
}

void command(Axis& axis, Chance& chance) {
    const double target = chance.between(-300'000, 300'000);
    const double rate = std::pow(10, chance.between(3, 9));
    const double velocity = chance.between(-1e6, 1e6);
    switch (chance.pick(8)) {
        case 0:
            chance.pick(2) == 0 ? axis.switch_off() : axis.switch_on();
            break;
        case 1:
            if (!axis.moving()) {
                axis.move_to(target, {std::abs(velocity) + 1, rate, rate * 100});
            }
            break;
        case 2:
            axis.run_at(velocity, rate, rate * 10);
            break;
        case 3:
            axis.stop(rate, rate * 10);
            break;
        case 4:
            axis.follow(axis.set_point().position + velocity / 100, chance.between(0, 0.02));
            break;
        case 5:
            axis.hold();
            break;
        case 6:
            axis.set_brake(chance.pick(2) == 0);
            break;
        default:
            retune(axis, chance);
            break;
    }
}

void check_step(Axis& axis) {
    const double before = axis.plant().position();
    const bool rested = axis.at_rest();
    const double current = axis.current();
    axis.step();
    const double way = axis.plant().position() - before;
    for (const double value : {axis.plant().position(), axis.velocity(), axis.current(), axis.measured_current(),
                               axis.force_current(), axis.contact_force(), axis.heat().winding(), axis.heat().i2t(),
                               axis.set_point().position, axis.set_point().velocity, axis.set_point().acceleration}) {
        ASSERT_TRUE(std::isfinite(value));
    }
    ASSERT_NEAR(way, axis.plant().velocity() * control_period_s, 1e-6 + 1e-9 * std::abs(before));
    ASSERT_LE(std::abs(axis.current()), axis.kind().peak_current + 1e-9);
    if (rested) {
        ASSERT_EQ(way, 0);
        ASSERT_EQ(axis.current(), current);
        ASSERT_TRUE(axis.at_rest());
    }
}

TEST(Axis, BearsAnything) {
    std::uint32_t seed = 1;
    for (const AxisKind& kind : shipped_kinds()) {
        for (int round = 0; round < 3; ++round) {
            Chance chance(seed++);
            Axis axis(kind, seed);
            for (int i = 0; i < 60'000; ++i) {
                if (chance.pick(100) == 0) {
                    command(axis, chance);
                } else if (chance.pick(300) == 0) {
                    disturb(axis, chance);
                }
                check_step(axis);
                if (testing::Test::HasFatalFailure()) {
                    FAIL() << kind.key << ", seed " << seed << ", period " << i;
                }
            }
        }
    }
}

}  // namespace
}  // namespace servobus::drive
