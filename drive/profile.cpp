#include "drive/profile.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace servobus::drive {

namespace {

/// Stretches shorter than this part of their neighbours are rounding, not motion: an S-curve of 100 % holds its
/// acceleration for no time, whatever the last bits say.
constexpr double nothing = 1e-12;

MotionState moved(const MotionState& from, double jerk, double seconds) {
    const double acceleration = from.acceleration + jerk * seconds;
    const double velocity = from.velocity + seconds * (from.acceleration + seconds * jerk / 2);
    const double position =
        from.position + seconds * (from.velocity + seconds * (from.acceleration / 2 + seconds * jerk / 6));
    return {position, velocity, acceleration};
}

/// From standstill to a speed: jerk, constant acceleration, jerk back.
struct Ramp {
    double jerk_time;
    double hold_time;

    [[nodiscard]] double duration() const { return 2 * jerk_time + hold_time; }
};

Ramp ramp_to(double speed, double acceleration, double jerk) {
    const double jerk_time = acceleration / jerk;
    const double hold_time = speed / acceleration - jerk_time;
    if (hold_time > nothing * jerk_time) {
        return {jerk_time, hold_time};
    }
    return {std::sqrt(speed / jerk), 0};  // the acceleration stays below its limit
}

/// The speed at which speeding up and slowing down alone cover the distance. A ramp covers speed * duration / 2.
double peak_of(double distance, double acceleration, double jerk) {
    const double jerk_time = acceleration / jerk;
    if (distance > 2 * acceleration * jerk_time * jerk_time) {
        // speed * (speed / acceleration + jerk_time) = distance, solved without a difference of like numbers
        return 2 * distance / (jerk_time + std::sqrt(jerk_time * jerk_time + 4 * distance / acceleration));
    }
    const double time = std::cbrt(distance / (2 * jerk));
    return jerk * time * time;
}

}  // namespace

// A ramp of T seconds with the part s = percent / 100 rounded off changes its acceleration for sT/2 at its start and
// for sT/2 at its end, and holds it between. It gains v = aT(1 - s/2), so
//     jerk = a / (sT/2) = 2 a^2 (1 - s/2) / (s v)
// The manual says no more than "S-curve in percent" (000 §2.3.1.1). With this reading a ramp takes 1 / (1 - s/2) of
// the time of a trapezoid: 11 % more with the default of 20 %, twice the time with 100 %.
double jerk_of(double acceleration, double speed, double percent) {
    assert(acceleration > 0 && speed > 0 && percent > 0 && percent <= 100);
    const double part = percent / 100;
    return 2 * acceleration * acceleration * (1 - part / 2) / (part * speed);
}

Profile::Profile(const MotionState& start) : end_(start) { starts_[0] = start; }

void Profile::add(double seconds, double jerk, const MotionState& after) {
    if (!(seconds > 0)) {
        return;
    }
    phases_[count_] = {seconds, jerk};
    times_[count_] = duration_;
    duration_ += seconds;
    ++count_;
    starts_[count_] = after;
}

// The second half is the first one mirrored, reckoned back from the end: whatever rounding leaves over then shows in
// the middle, where the axis is fastest, and not at the target.
Profile Profile::to_position(double from, double to, const MotionLimits& limits) {
    assert(limits.speed > 0 && limits.acceleration > 0 && limits.jerk > 0);
    Profile profile(from);
    profile.end_ = {to, 0, 0};
    const double distance = std::abs(to - from);
    if (distance == 0) {
        return profile;
    }
    const double direction = to > from ? 1 : -1;

    double speed = std::min(limits.speed, peak_of(distance, limits.acceleration, limits.jerk));
    const Ramp ramp = ramp_to(speed, limits.acceleration, limits.jerk);
    double jerk = limits.jerk;
    double cruise_time = distance / speed - ramp.duration();
    if (cruise_time <= nothing * ramp.duration()) {
        cruise_time = 0;
        // What rounding left over goes into the speed, and the jerk that makes it.
        const double mended = distance / ramp.duration();
        jerk *= mended / speed;
        speed = mended;
    }

    // The ramp as seen from where the axis stands: after the rise of the acceleration, after holding it, at speed.
    const MotionState risen = moved({}, jerk, ramp.jerk_time);
    const MotionState held = moved(risen, 0, ramp.hold_time);
    const MotionState fast{speed * ramp.duration() / 2, speed, 0};
    const auto after_start = [&](const MotionState& state) {
        return MotionState{from + direction * state.position, direction * state.velocity,
                           direction * state.acceleration};
    };
    const auto before_end = [&](const MotionState& state) {
        return MotionState{to - direction * state.position, direction * state.velocity,
                           -direction * state.acceleration};
    };

    profile.add(ramp.jerk_time, direction * jerk, after_start(risen));
    profile.add(ramp.hold_time, 0, after_start(held));
    profile.add(ramp.jerk_time, -direction * jerk, cruise_time > 0 ? after_start(fast) : before_end(fast));
    profile.add(cruise_time, 0, before_end(fast));
    profile.add(ramp.jerk_time, -direction * jerk, before_end(held));
    profile.add(ramp.hold_time, 0, before_end(risen));
    profile.add(ramp.jerk_time, direction * jerk, profile.end_);
    return profile;
}

Profile Profile::to_velocity(const MotionState& from, double velocity, double acceleration, double jerk) {
    assert(acceleration > 0 && jerk > 0);
    Profile profile(from);
    MotionState state = from;
    const auto go = [&](double seconds, double signed_jerk, double acceleration_after) {
        if (seconds > 0) {
            state = moved(state, signed_jerk, seconds);
            state.acceleration = acceleration_after;
            profile.add(seconds, signed_jerk, state);
        }
    };

    if (const double excess = std::abs(state.acceleration) - acceleration; excess > 0) {
        go(excess / jerk, -std::copysign(jerk, state.acceleration), std::copysign(acceleration, state.acceleration));
    }

    // Where the velocity ends when the acceleration goes straight to 0 decides in which direction to accelerate.
    const double straight = state.velocity + state.acceleration * std::abs(state.acceleration) / (2 * jerk);
    const double direction = velocity >= straight ? 1 : -1;
    const double gain = direction * (velocity - state.velocity);
    const double now = direction * state.acceleration;

    // From `now` to `peak` the velocity gains (peak^2 - now^2) / 2j, from `peak` to 0 another peak^2 / 2j.
    const double peak = std::min(acceleration, std::sqrt(std::max(0.0, gain * jerk + now * now / 2)));
    const double hold_time = (gain - (peak * peak - now * now / 2) / jerk) / acceleration;
    go((peak - now) / jerk, direction * jerk, direction * peak);
    if (peak == acceleration && hold_time > nothing * peak / jerk) {
        go(hold_time, 0, direction * peak);
    }
    go(peak / jerk, -direction * jerk, 0);

    profile.end_ = {state.position, velocity, 0};
    return profile;
}

MotionState Profile::at(double seconds) const {
    if (seconds >= duration_) {
        MotionState state = end_;
        if (state.velocity != 0) {  // at rest also when `seconds` is infinite
            state.position += state.velocity * (seconds - duration_);
        }
        return state;
    }
    if (!(seconds > 0)) {
        return starts_[0];
    }
    std::size_t phase = count_ - 1;
    while (seconds < times_[phase]) {
        --phase;
    }
    return moved(starts_[phase], phases_[phase].jerk, seconds - times_[phase]);
}

}  // namespace servobus::drive
