// Motion profiles, over random parameters: what may not be exceeded, where they end, and that nothing is faster. The
// references know no phases: they ask how far any motion within the limits could have come.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "drive/profile.hpp"

namespace servobus::drive {
namespace {

constexpr double rounding = 1e-9;

class Random {
public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}

    double between(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }
    /// As many small numbers as large ones.
    double magnitude(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
    bool chance(double probability) { return between(0, 1) < probability; }
    double sign() { return chance(0.5) ? 1 : -1; }

private:
    std::mt19937_64 engine_;
};

struct Move {
    double from;
    double to;
    MotionLimits limits;

    [[nodiscard]] double distance() const { return std::abs(to - from); }
};

struct Change {
    MotionState from;
    double velocity;
    double acceleration;
    double jerk;
};

std::string text(std::uint64_t seed, int index, const Move& move) {
    std::ostringstream out;
    out.precision(17);
    out << "seed " << seed << ", case " << index << ": " << move.from << " to " << move.to << ", speed "
        << move.limits.speed << ", acceleration " << move.limits.acceleration << ", jerk " << move.limits.jerk;
    return out.str();
}

std::string text(std::uint64_t seed, int index, const Change& change) {
    std::ostringstream out;
    out.precision(17);
    out << "seed " << seed << ", case " << index << ": from " << change.from.velocity << " and "
        << change.from.acceleration << " to " << change.velocity << ", acceleration " << change.acceleration
        << ", jerk " << change.jerk;
    return out.str();
}

MotionLimits random_limits(Random& random) {
    const double speed = random.magnitude(10, 1e8);
    const double acceleration = random.magnitude(2e3, 1e9);
    const double percent = std::floor(random.between(1, 101));
    return {speed, acceleration, jerk_of(acceleration, speed, std::min(percent, 100.0))};
}

/// Whole increments, as a drive is told; both ends within what 32 bits hold.
Move random_move(Random& random) {
    constexpr double furthest = 2'147'483'647;
    Move move{0, 0, random_limits(random)};
    const double distance = std::round(random.magnitude(1, 2 * furthest));
    const double low = std::round(random.between(-furthest, furthest - distance));
    move.from = low;
    move.to = low + distance;
    if (random.chance(0.5)) {
        std::swap(move.from, move.to);
    }
    return move;
}

/// Any state, now and then one that the limits would not have allowed.
Change random_change(Random& random) {
    const MotionLimits limits = random_limits(random);
    Change change{{random.between(-2e9, 2e9), 0, 0}, 0, limits.acceleration, limits.jerk};
    change.from.velocity = random.chance(0.1) ? 0 : random.between(-1, 1) * limits.speed;
    change.from.acceleration =
        random.chance(0.2) ? 0 : random.between(-1, 1) * limits.acceleration * (random.chance(0.2) ? 5 : 1);
    change.velocity = random.chance(0.3) ? 0 : random.between(-1, 1) * limits.speed;
    return change;
}

/// Evenly over the whole time and a little beyond, and close around every border of a phase.
std::vector<double> moments_of(const Profile& profile, int count) {
    std::vector<double> moments{-1, 0, profile.duration(), 2 * profile.duration() + 1};
    for (int i = 0; i <= count; ++i) {
        moments.push_back(profile.duration() * 1.05 * i / count);
    }
    double border = 0;
    for (const Phase& phase : profile.phases()) {
        border += phase.seconds;
        for (const double step : {-1e-6, -1e-12, 0.0, 1e-12, 1e-6}) {
            moments.push_back(border + step * phase.seconds);
        }
    }
    return moments;
}

/// What a position can be off by rounding.
double position_rounding(double largest_position, double speed, double duration) {
    constexpr double epsilon = std::numeric_limits<double>::epsilon();
    return 1e-9 + 32 * epsilon * (largest_position + speed * duration);
}

/// What a time can be off by rounding; in that time the velocity changes by the acceleration, and so on.
double time_rounding(double duration) { return 8 * std::numeric_limits<double>::epsilon() * duration; }

// --- References ---------------------------------------------------------------------------------------------------

/// The furthest that any motion from rest to rest comes in `seconds`, in small steps. Time-reversed, a motion covers
/// the same distance within the same limits, and so does the mean of both; that one has no acceleration halfway. So up
/// to there the acceleration is at most what the jerk has built up since the start, what it can take away until
/// halfway, and what it can take away before the speed is too high.
double furthest(double seconds, const MotionLimits& limits) {
    constexpr int steps = 1500;
    const double step = seconds / 2 / steps;
    double velocity = 0;
    double distance = 0;
    for (int i = 0; i < steps; ++i) {
        const double time = (i + 0.5) * step;
        const double acceleration =
            std::min({limits.acceleration, limits.jerk * time, limits.jerk * (seconds / 2 - time),
                      std::sqrt(2 * limits.jerk * (limits.speed - velocity))});
        const double before = velocity;
        velocity = std::min(limits.speed, velocity + acceleration * step);
        distance += (before + velocity) / 2 * step;
    }
    return 2 * distance;
}

/// Which velocities any motion from a state can have, with no acceleration, after exactly `seconds`. They have no gaps,
/// as the mean of two such motions is another. Empty when low > high. Narrower than true by what the steps may err.
struct Interval {
    double low;
    double high;
};

Interval reachable(const Change& change, double seconds) {
    constexpr int steps = 400;
    const double start = change.from.acceleration;
    const double jerk = change.jerk;
    if (jerk * seconds < std::abs(start)) {
        return {1, 0};
    }
    const double step = seconds / steps;
    double low = change.from.velocity;
    double high = change.from.velocity;
    for (int i = 0; i < steps; ++i) {
        const double time = (i + 0.5) * step;
        // An acceleration above the limit comes down first, and no slower than it can.
        const double above = std::max(change.acceleration, start - jerk * time);
        const double below = std::min(-change.acceleration, start + jerk * time);
        high += step * std::min({above, start + jerk * time, jerk * (seconds - time)});
        low += step * std::max({below, start - jerk * time, -jerk * (seconds - time)});
    }
    const double error = jerk * step * step + 1e-12 * (std::abs(low) + std::abs(high));
    return {low + error, high - error};
}

// --- The S-curve ----------------------------------------------------------------------------------------------------

TEST(ProfileJerk, RoundsOffItsPartOfTheRamp) {
    Random random(1);
    for (int i = 0; i < 1000; ++i) {
        const double speed = random.magnitude(10, 1e8);
        const double acceleration = random.magnitude(2e3, 1e9);
        const double percent = random.between(1, 99);
        const double jerk = jerk_of(acceleration, speed, percent);
        const auto profile = Profile::to_velocity({}, speed, acceleration, jerk);
        ASSERT_EQ(profile.phases().size(), 3U);
        const double rounded = profile.phases()[0].seconds + profile.phases()[2].seconds;
        EXPECT_NEAR(rounded / profile.duration(), percent / 100, rounding) << "case " << i;
        EXPECT_NEAR(profile.phases()[0].seconds, profile.phases()[2].seconds, rounding * rounded);
        EXPECT_NEAR(profile.at(profile.duration() / 2).acceleration / acceleration, 1, rounding);
    }
}

TEST(ProfileJerk, OnePercentIsNearlyATrapezoid) {
    const MotionLimits limits{100'000, 1'000'000, jerk_of(1'000'000, 100'000, 1)};
    const auto profile = Profile::to_position(0, 50'000, limits);
    const double trapezoid = 50'000 / limits.speed + limits.speed / limits.acceleration;
    EXPECT_GT(profile.duration(), trapezoid);
    EXPECT_LT(profile.duration(), trapezoid * 1.002);
}

TEST(ProfileJerk, AHundredPercentNeverHoldsItsAcceleration) {
    Random random(2);
    for (int i = 0; i < 1000; ++i) {
        const double speed = random.magnitude(10, 1e8);
        const double acceleration = random.magnitude(2e3, 1e9);
        const MotionLimits limits{speed, acceleration, jerk_of(acceleration, speed, 100)};
        const auto profile = Profile::to_position(0, random.magnitude(1, 4e9), limits);
        for (const Phase& phase : profile.phases()) {
            if (phase.jerk == 0) {
                ASSERT_NEAR(profile.at(profile.duration() / 2).acceleration, 0, rounding * acceleration);
            }
        }
        ASSERT_LE(profile.phases().size(), 5U);
        const auto jog = Profile::to_velocity({}, speed, acceleration, limits.jerk);
        ASSERT_EQ(jog.phases().size(), 2U) << "case " << i;
    }
}

TEST(ProfileJerk, ThePercentageStretchesTheRamp) {
    const auto ramp = [](double percent) {
        return Profile::to_velocity({}, 1e5, 1e6, jerk_of(1e6, 1e5, percent)).duration();
    };
    EXPECT_NEAR(ramp(20), 0.1 / 0.9, 1e-12);
    EXPECT_NEAR(ramp(100), 0.2, 1e-12);
}

// --- From rest to rest -----------------------------------------------------------------------------------------------

TEST(ProfileToPosition, ALongMoveHasSevenPhases) {
    const MotionLimits limits{100'000, 1'000'000, jerk_of(1'000'000, 100'000, 20)};
    const auto profile = Profile::to_position(0, 50'000, limits);
    ASSERT_EQ(profile.phases().size(), 7U);
    EXPECT_NEAR(profile.duration(), 0.5 + 0.1 / 0.9, 1e-12);
    EXPECT_NEAR(profile.at(0.1 / 0.9 + 0.001).velocity, 100'000, 1e-6);
    EXPECT_NEAR(profile.at(profile.duration() / 2).position, 25'000, 1e-6);
}

TEST(ProfileToPosition, ShortMovesHaveFewerPhases) {
    const MotionLimits limits{100'000, 1'000'000, jerk_of(1'000'000, 100'000, 20)};
    EXPECT_EQ(Profile::to_position(0, 1'000, limits).phases().size(), 6U) << "the speed is not reached";
    EXPECT_EQ(Profile::to_position(0, 10, limits).phases().size(), 4U) << "the acceleration is not reached either";
    const MotionLimits slow{1'000, 1'000'000, jerk_of(1'000'000, 100'000, 20)};
    EXPECT_EQ(Profile::to_position(0, 1'000, slow).phases().size(), 5U) << "only the speed is reached";
}

TEST(ProfileToPosition, NoDistanceTakesNoTime) {
    const auto profile = Profile::to_position(17, 17, {100, 1000, 10'000});
    EXPECT_TRUE(profile.phases().empty());
    EXPECT_EQ(profile.duration(), 0);
    for (const double seconds : {-1.0, 0.0, 1.0}) {
        EXPECT_EQ(profile.at(seconds), (MotionState{17, 0, 0}));
    }
}

TEST(ProfileToPosition, NoPhaseOfTheDefaultProfile) {
    const Profile profile;
    EXPECT_TRUE(profile.phases().empty());
    EXPECT_EQ(profile.at(5), MotionState{});
    EXPECT_EQ(Profile(4).end(), (MotionState{4, 0, 0}));
}

TEST(ProfileToPosition, KeepsItsLimitsAndEndsOnItsTarget) {
    constexpr std::uint64_t seed = 3;
    Random random(seed);
    for (int i = 0; i < 4000; ++i) {
        const Move move = random_move(random);
        SCOPED_TRACE(text(seed, i, move));
        const auto profile = Profile::to_position(move.from, move.to, move.limits);
        const double off =
            position_rounding(std::max(std::abs(move.from), std::abs(move.to)), move.limits.speed, profile.duration());
        const auto [low, high] = std::minmax(move.from, move.to);
        for (const double moment : moments_of(profile, 100)) {
            const MotionState state = profile.at(moment);
            ASSERT_LE(std::abs(state.velocity), move.limits.speed * (1 + rounding)) << moment;
            ASSERT_LE(std::abs(state.acceleration), move.limits.acceleration * (1 + rounding)) << moment;
            ASSERT_GE(state.position, low - off) << moment;
            ASSERT_LE(state.position, high + off) << moment;
            ASSERT_GE(state.velocity * (move.to - move.from), -rounding * move.limits.speed * move.distance());
        }
        for (const Phase& phase : profile.phases()) {
            ASSERT_GT(phase.seconds, 0);
            ASSERT_LE(std::abs(phase.jerk), move.limits.jerk * (1 + rounding));
        }
        const MotionState target{move.to, 0, 0};
        ASSERT_EQ(profile.start(), (MotionState{move.from, 0, 0}));
        ASSERT_EQ(profile.at(0), profile.start());
        ASSERT_EQ(profile.at(-1), profile.start());
        ASSERT_EQ(profile.end(), target);
        ASSERT_EQ(profile.at(profile.duration()), target);
        ASSERT_EQ(profile.at(2 * profile.duration()), target);
        ASSERT_EQ(profile.at(std::numeric_limits<double>::infinity()), target);
    }
}

/// The phases alone, integrated with more digits, lead to the target and along the states that at() gives.
TEST(ProfileToPosition, ItsPhasesLeadToTheTarget) {
    constexpr std::uint64_t seed = 4;
    Random random(seed);
    for (int i = 0; i < 4000; ++i) {
        const Move move = random_move(random);
        SCOPED_TRACE(text(seed, i, move));
        const auto profile = Profile::to_position(move.from, move.to, move.limits);
        const double off =
            position_rounding(std::max(std::abs(move.from), std::abs(move.to)), move.limits.speed, profile.duration());
        const double late = time_rounding(profile.duration());
        long double time = 0;
        long double position = move.from;
        long double velocity = 0;
        long double acceleration = 0;
        for (const Phase& phase : profile.phases()) {
            const MotionState state = profile.at(static_cast<double>(time));
            ASSERT_NEAR(state.position, static_cast<double>(position), off);
            ASSERT_NEAR(state.velocity, static_cast<double>(velocity),
                        rounding * move.limits.speed + late * move.limits.acceleration);
            ASSERT_NEAR(state.acceleration, static_cast<double>(acceleration),
                        rounding * move.limits.acceleration + late * move.limits.jerk);
            const long double t = phase.seconds;
            const long double j = phase.jerk;
            position += velocity * t + acceleration * t * t / 2 + j * t * t * t / 6;
            velocity += acceleration * t + j * t * t / 2;
            acceleration += j * t;
            time += t;
        }
        ASSERT_NEAR(static_cast<double>(position), move.to, off);
        ASSERT_NEAR(static_cast<double>(velocity), 0, rounding * move.limits.speed + late * move.limits.acceleration);
        ASSERT_NEAR(static_cast<double>(acceleration), 0,
                    rounding * move.limits.acceleration + late * move.limits.jerk);
        ASSERT_NEAR(static_cast<double>(time), profile.duration(), rounding * profile.duration());
    }
}

TEST(ProfileToPosition, IsContinuousAtItsBorders) {
    constexpr std::uint64_t seed = 5;
    Random random(seed);
    for (int i = 0; i < 4000; ++i) {
        const Move move = random_move(random);
        SCOPED_TRACE(text(seed, i, move));
        const auto profile = Profile::to_position(move.from, move.to, move.limits);
        const double off =
            position_rounding(std::max(std::abs(move.from), std::abs(move.to)), move.limits.speed, profile.duration());
        double border = 0;
        for (const Phase& phase : profile.phases()) {
            border += phase.seconds;
            // The next few numbers around the border: more than the sum may err, and no time for anything to move.
            const double step = time_rounding(profile.duration());
            const MotionState before = profile.at(border - step);
            const MotionState after = profile.at(border + step);
            ASSERT_NEAR(before.position, after.position, off);
            ASSERT_NEAR(before.velocity, after.velocity,
                        rounding * move.limits.speed + 3 * step * move.limits.acceleration);
            ASSERT_NEAR(before.acceleration, after.acceleration,
                        rounding * move.limits.acceleration + 3 * step * move.limits.jerk);
        }
    }
}

TEST(ProfileToPosition, IsSymmetric) {
    constexpr std::uint64_t seed = 6;
    Random random(seed);
    for (int i = 0; i < 4000; ++i) {
        const Move move = random_move(random);
        SCOPED_TRACE(text(seed, i, move));
        const auto profile = Profile::to_position(move.from, move.to, move.limits);
        const auto phases = profile.phases();
        for (std::size_t k = 0; k < phases.size(); ++k) {
            ASSERT_EQ(phases[k].seconds, phases[phases.size() - 1 - k].seconds);
            ASSERT_EQ(std::abs(phases[k].jerk), std::abs(phases[phases.size() - 1 - k].jerk));
        }
        const double off =
            position_rounding(std::max(std::abs(move.from), std::abs(move.to)), move.limits.speed, profile.duration());
        for (int k = 0; k <= 20; ++k) {
            const double moment = profile.duration() * k / 40;
            const MotionState early = profile.at(moment);
            const MotionState late = profile.at(profile.duration() - moment);
            ASSERT_NEAR(early.position - move.from, move.to - late.position, 2 * off);
            ASSERT_NEAR(early.velocity, late.velocity,
                        rounding * move.limits.speed + time_rounding(profile.duration()) * move.limits.acceleration);
        }
    }
}

TEST(ProfileToPosition, ThereAndBackAgain) {
    constexpr std::uint64_t seed = 7;
    Random random(seed);
    for (int i = 0; i < 2000; ++i) {
        const Move move = random_move(random);
        SCOPED_TRACE(text(seed, i, move));
        const auto there = Profile::to_position(move.from, move.to, move.limits);
        const auto back = Profile::to_position(there.end().position, move.from, move.limits);
        ASSERT_EQ(back.end().position, move.from);
        ASSERT_EQ(back.duration(), there.duration());
        const double off =
            position_rounding(std::max(std::abs(move.from), std::abs(move.to)), move.limits.speed, there.duration());
        for (int k = 0; k <= 20; ++k) {
            const double moment = there.duration() * k / 20;
            ASSERT_NEAR(there.at(moment).position - move.from, move.to - back.at(moment).position, 2 * off);
            ASSERT_EQ(there.at(moment).velocity, -back.at(moment).velocity);
            ASSERT_EQ(there.at(moment).acceleration, -back.at(moment).acceleration);
        }
    }
}

TEST(ProfileToPosition, NothingWithinTheLimitsIsFaster) {
    constexpr std::uint64_t seed = 8;
    Random random(seed);
    for (int i = 0; i < 3000; ++i) {
        const Move move = random_move(random);
        const double duration = Profile::to_position(move.from, move.to, move.limits).duration();
        ASSERT_LT(furthest(0.99 * duration, move.limits), move.distance()) << text(seed, i, move);
        ASSERT_GT(furthest(1.01 * duration, move.limits), move.distance()) << text(seed, i, move);
    }
}

TEST(ProfileToPosition, MoreOfALimitIsNeverSlower) {
    constexpr std::uint64_t seed = 9;
    Random random(seed);
    for (int i = 0; i < 2000; ++i) {
        const Move move = random_move(random);
        const double duration = Profile::to_position(move.from, move.to, move.limits).duration();
        const auto with = [&](double speed, double acceleration, double jerk) {
            const MotionLimits limits{move.limits.speed * speed, move.limits.acceleration * acceleration,
                                      move.limits.jerk * jerk};
            return Profile::to_position(move.from, move.to, limits).duration();
        };
        const double longest = duration * (1 + rounding);
        ASSERT_LE(with(1.5, 1, 1), longest) << text(seed, i, move);
        ASSERT_LE(with(1, 1.5, 1), longest) << text(seed, i, move);
        ASSERT_LE(with(1, 1, 1.5), longest) << text(seed, i, move);
    }
}

/// Where one kind of profile passes into another, duration and end do not jump.
TEST(ProfileToPosition, PassesSmoothlyFromShortToLongMoves) {
    const MotionLimits limits{100'000, 1'000'000, jerk_of(1'000'000, 100'000, 20)};
    const double ramp_time = limits.acceleration / limits.jerk;
    const double holds = 2 * limits.acceleration * ramp_time * ramp_time;
    const double cruises = limits.speed * (limits.speed / limits.acceleration + ramp_time);
    for (const double distance : {holds, cruises}) {
        const double duration = Profile::to_position(0, distance, limits).duration();
        for (const double part : {-1e-9, -1e-11, -1e-12, -1e-13, -1e-15, 1e-15, 1e-13, 1e-12, 1e-11, 1e-9}) {
            const auto profile = Profile::to_position(0, distance * (1 + part), limits);
            EXPECT_NEAR(profile.duration(), duration, 1e-8 * duration) << distance << ", " << part;
            const double middle = profile.at(profile.duration() / 2).position;
            EXPECT_NEAR(middle, distance * (1 + part) / 2, 1e-9 * distance) << distance << ", " << part;
        }
    }
}

TEST(ProfileToPosition, TheCornersOfItsRange) {
    for (const double distance : {1.0, 4e9}) {
        for (const double speed : {10.0, 1e8}) {
            for (const double acceleration : {2e3, 1e9}) {
                for (const double percent : {1.0, 100.0}) {
                    const MotionLimits limits{speed, acceleration, jerk_of(acceleration, speed, percent)};
                    const auto profile = Profile::to_position(-2e9, -2e9 + distance, limits);
                    const double duration = profile.duration();
                    EXPECT_EQ(profile.at(duration).position, -2e9 + distance);
                    EXPECT_LT(furthest(0.99 * duration, limits), distance) << speed << " " << acceleration;
                    EXPECT_GT(furthest(1.01 * duration, limits), distance) << speed << " " << acceleration;
                }
            }
        }
    }
}

// --- To a velocity ---------------------------------------------------------------------------------------------------

TEST(ProfileToVelocity, FromRestItTakesThreePhases) {
    const double jerk = jerk_of(1e6, 1e5, 20);
    const auto profile = Profile::to_velocity({5, 0, 0}, -1e5, 1e6, jerk);
    ASSERT_EQ(profile.phases().size(), 3U);
    EXPECT_EQ(profile.end().velocity, -1e5);
    EXPECT_EQ(profile.end().acceleration, 0);
    EXPECT_NEAR(profile.end().position, 5 - 1e5 * profile.duration() / 2, 1e-6);
    const MotionState later = profile.at(profile.duration() + 2);
    EXPECT_NEAR(later.position, profile.end().position - 2e5, 1e-6);
    EXPECT_EQ(later.velocity, -1e5);
    EXPECT_EQ(later.acceleration, 0);
}

TEST(ProfileToVelocity, TheSameVelocityTakesNoTime) {
    const auto profile = Profile::to_velocity({5, 100, 0}, 100, 1000, 1e4);
    EXPECT_TRUE(profile.phases().empty());
    EXPECT_EQ(profile.at(2), (MotionState{205, 100, 0}));
    EXPECT_EQ(profile.at(-1), (MotionState{5, 100, 0}));
}

TEST(ProfileToVelocity, AnAccelerationAboveTheLimitComesDownFirst) {
    const auto profile = Profile::to_velocity({0, 1000, 5000}, 0, 1000, 1e5);
    EXPECT_NEAR(profile.at(0.04).acceleration, 1000, 1e-6);
    EXPECT_NEAR(profile.at(0.06).acceleration, -1000, 1e-6);
    EXPECT_EQ(profile.end().velocity, 0);
    const auto onwards = Profile::to_velocity({0, 0, 5000}, 1e5, 1000, 1e5);
    EXPECT_NEAR(onwards.at(0.04).acceleration, 1000, 1e-6);
    EXPECT_NEAR(onwards.at(onwards.duration() / 2).acceleration, 1000, 1e-6);
}

TEST(ProfileToVelocity, KeepsItsLimitsAndEndsAtItsVelocity) {
    constexpr std::uint64_t seed = 10;
    Random random(seed);
    for (int i = 0; i < 4000; ++i) {
        const Change change = random_change(random);
        SCOPED_TRACE(text(seed, i, change));
        const auto profile = Profile::to_velocity(change.from, change.velocity, change.acceleration, change.jerk);
        const double start = std::abs(change.from.acceleration);
        ASSERT_LE(profile.phases().size(), start > change.acceleration ? 4U : 3U);
        for (const double moment : moments_of(profile, 100)) {
            // Above the limit only for as long as the jerk needs to bring it down.
            const double highest = std::max(change.acceleration, start - change.jerk * std::max(0.0, moment));
            ASSERT_LE(std::abs(profile.at(moment).acceleration), highest + rounding * (start + change.acceleration))
                << moment;
        }
        for (const Phase& phase : profile.phases()) {
            ASSERT_GT(phase.seconds, 0);
            ASSERT_LE(std::abs(phase.jerk), change.jerk * (1 + rounding));
        }
        ASSERT_EQ(profile.start(), change.from);
        ASSERT_EQ(profile.at(0), change.from);
        ASSERT_EQ(profile.end().velocity, change.velocity);
        ASSERT_EQ(profile.end().acceleration, 0);
        ASSERT_EQ(profile.at(profile.duration()), profile.end());
        ASSERT_EQ(profile.at(profile.duration() * 2).velocity, change.velocity);
    }
}

TEST(ProfileToVelocity, ItsPhasesLeadToTheVelocity) {
    constexpr std::uint64_t seed = 11;
    Random random(seed);
    for (int i = 0; i < 4000; ++i) {
        const Change change = random_change(random);
        SCOPED_TRACE(text(seed, i, change));
        const auto profile = Profile::to_velocity(change.from, change.velocity, change.acceleration, change.jerk);
        const double start = std::abs(change.from.acceleration);
        const double highest = std::max(start, change.acceleration);
        const double fastest = std::abs(change.from.velocity) + std::abs(change.velocity) + start * start / change.jerk;
        const double off = position_rounding(std::abs(change.from.position), fastest, profile.duration());
        const double late = time_rounding(profile.duration());
        long double time = 0;
        long double position = change.from.position;
        long double velocity = change.from.velocity;
        long double acceleration = change.from.acceleration;
        const auto compare = [&](const MotionState& state) {
            ASSERT_NEAR(state.position, static_cast<double>(position), off);
            ASSERT_NEAR(state.velocity, static_cast<double>(velocity), rounding * fastest + 2 * late * highest);
            ASSERT_NEAR(state.acceleration, static_cast<double>(acceleration),
                        rounding * highest + 2 * late * change.jerk);
        };
        for (const Phase& phase : profile.phases()) {
            compare(profile.at(static_cast<double>(time)));
            const long double t = phase.seconds;
            const long double j = phase.jerk;
            position += velocity * t + acceleration * t * t / 2 + j * t * t * t / 6;
            velocity += acceleration * t + j * t * t / 2;
            acceleration += j * t;
            time += t;
            // From this side of the border, too.
            const MotionState before = profile.at(static_cast<double>(time) - late);
            ASSERT_NEAR(before.position, static_cast<double>(position), off);
            ASSERT_NEAR(before.velocity, static_cast<double>(velocity), rounding * fastest + 2 * late * highest);
            ASSERT_NEAR(before.acceleration, static_cast<double>(acceleration),
                        rounding * highest + 2 * late * change.jerk);
        }
        compare(profile.end());
    }
}

TEST(ProfileToVelocity, NothingWithinTheLimitsIsFaster) {
    constexpr std::uint64_t seed = 12;
    Random random(seed);
    for (int i = 0; i < 1500; ++i) {
        const Change change = random_change(random);
        SCOPED_TRACE(text(seed, i, change));
        const double duration =
            Profile::to_velocity(change.from, change.velocity, change.acceleration, change.jerk).duration();
        if (duration == 0) {
            ASSERT_EQ(change.from.velocity, change.velocity);
            ASSERT_EQ(change.from.acceleration, 0);
            continue;
        }
        // What can be reached does not only grow with time, so all shorter times are tried.
        constexpr int tries = 40;
        for (int k = 1; k <= tries; ++k) {
            const Interval interval = reachable(change, 0.99 * duration * k / tries);
            ASSERT_FALSE(interval.low <= change.velocity && change.velocity <= interval.high)
                << "in " << 0.99 * k / tries << " of the time";
        }
    }
}

/// A jog whose speed and direction change at any moment, each time from where the one before has led.
TEST(ProfileToVelocity, ChangesOnTheFly) {
    constexpr std::uint64_t seed = 13;
    Random random(seed);
    const MotionLimits limits{1e5, 1e6, jerk_of(1e6, 1e5, 20)};
    Profile profile(0);
    for (int i = 0; i < 3000; ++i) {
        const MotionState state = profile.at(random.between(0, 1.2) * profile.duration());
        const double velocity = random.chance(0.2) ? state.velocity : random.between(-1, 1) * limits.speed;
        profile = Profile::to_velocity(state, velocity, limits.acceleration, limits.jerk);
        ASSERT_EQ(profile.at(0), state) << "seed " << seed << ", case " << i;
        ASSERT_EQ(profile.end().velocity, velocity);
        ASSERT_LE(profile.phases().size(), 4U);
        for (const double moment : moments_of(profile, 20)) {
            ASSERT_LE(std::abs(profile.at(moment).acceleration), limits.acceleration * (1 + rounding));
        }
    }
}

/// Told again and again to stop, an axis stops in the time that the first order needed.
TEST(ProfileToVelocity, RepeatedOrdersDoNotDelay) {
    constexpr std::uint64_t seed = 14;
    Random random(seed);
    for (int i = 0; i < 300; ++i) {
        const MotionLimits limits = random_limits(random);
        const MotionState start{0, random.between(-1, 1) * limits.speed, random.between(-1, 1) * limits.acceleration};
        const auto once = Profile::to_velocity(start, 0, limits.acceleration, limits.jerk);
        constexpr int orders = 50;
        MotionState state = start;
        for (int k = 0; k < orders; ++k) {
            const auto again = Profile::to_velocity(state, 0, limits.acceleration, limits.jerk);
            ASSERT_NEAR(again.duration(), once.duration() * (orders - k) / orders, 1e-6 * once.duration())
                << "seed " << seed << ", case " << i << ", order " << k;
            state = again.at(once.duration() / orders);
        }
        ASSERT_NEAR(state.velocity, 0, 1e-9 * limits.speed) << "seed " << seed << ", case " << i;
    }
}

}  // namespace
}  // namespace servobus::drive
