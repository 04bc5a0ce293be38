// Jerk-limited motion: where the set point of an axis is at each moment.
//
//     const MotionLimits limits{100'000, 1'000'000, jerk_of(1'000'000, 100'000, 20)};
//     const auto profile = Profile::to_position(0, 50'000, limits);
//     profile.at(0.1).velocity;  // increments per second, a tenth of a second after the start
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace servobus::drive {

/// What a set point may not exceed: increment/s, increment/s2, increment/s3; all above 0.
struct MotionLimits {
    double speed = 0;
    double acceleration = 0;
    double jerk = 0;
};

/// Where a set point is: increment, increment/s, increment/s2.
struct MotionState {
    double position = 0;
    double velocity = 0;
    double acceleration = 0;

    friend bool operator==(const MotionState&, const MotionState&) = default;
};

/// The jerk at which `percent` of the ramp from standstill to `speed` is rounded off, half of it at each end, while its
/// highest acceleration is `acceleration` (000 §2.3.1.1, docs/motion.md). 1 % is nearly a trapezoid, 100 % never holds
/// its acceleration.
[[nodiscard]] double jerk_of(double acceleration, double speed, double percent);

/// A stretch of constant jerk.
struct Phase {
    double seconds;
    double jerk;
};

/// Up to seven phases, then constant velocity for ever. Copying is cheap; nothing allocates.
class Profile {
public:
    static constexpr std::size_t max_phases = 7;

    /// At rest.
    explicit Profile(double position = 0) : Profile(MotionState{position, 0, 0}) {}

    /// From rest to rest, in the shortest time that the limits allow. The end is `to`, to the last bit.
    [[nodiscard]] static Profile to_position(double from, double to, const MotionLimits& limits);

    /// From any state to a velocity, in the shortest time; the position is where that leads. When the state's own
    /// acceleration is above the limit, that is brought down first. The sign of `velocity` is the direction.
    [[nodiscard]] static Profile to_velocity(const MotionState& from, double velocity, double acceleration,
                                             double jerk);

    /// The state `seconds` after the start; before 0 it is the start, after the end the velocity of the end goes on.
    [[nodiscard]] MotionState at(double seconds) const;

    /// The time that the phases take.
    [[nodiscard]] double duration() const { return duration_; }
    [[nodiscard]] const MotionState& start() const { return starts_[0]; }
    [[nodiscard]] const MotionState& end() const { return end_; }
    /// Without those that take no time.
    [[nodiscard]] std::span<const Phase> phases() const { return {phases_.data(), count_}; }

private:
    explicit Profile(const MotionState& start);
    void add(double seconds, double jerk, const MotionState& after);

    std::array<Phase, max_phases> phases_{};
    std::array<double, max_phases> times_{};            ///< when each phase starts
    std::array<MotionState, max_phases + 1> starts_{};  ///< where; behind the last one: where that leads
    std::size_t count_ = 0;
    double duration_ = 0;
    MotionState end_{};
};

}  // namespace servobus::drive
