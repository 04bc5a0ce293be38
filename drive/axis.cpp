#include "drive/axis.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drive/time.hpp"

namespace servobus::drive {

namespace {

constexpr double dt = control_period_s;
constexpr double pi = std::numbers::pi;

/// Noise of the measured current, A: the highest value; most are less than half of it.
constexpr double noise_amplitude = 0.006;

/// I_Force is filtered with 200 Hz. The part of the way it goes in a control period: 1 - exp(-2 pi 200 dt).
const double force_filter = -std::expm1(-2 * pi * 200 * dt);
constexpr double no_current = 1e-7;  // A

/// A set point from the bus is whole increments: a second difference of it is mostly rounding. So much of a new one
/// counts.
constexpr double follow_filter = 0.3;
constexpr double longest_follow = 1e6;  // s

/// splitmix64: a number for each period, so that periods can be skipped.
std::uint64_t hash(std::uint64_t value) {
    value *= 0x9E3779B97F4A7C15U;
    value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9U;
    value = (value ^ (value >> 27)) * 0x94D049BB133111EBU;
    return value ^ (value >> 31);
}

/// From -1 to 1, small values more often: the sum of two even distributions.
double triangular(std::uint64_t bits) {
    constexpr double scale = 1.0 / 4'294'967'296.0;
    return static_cast<double>(bits >> 32) * scale + static_cast<double>(bits & 0xFFFFFFFFU) * scale - 1;
}

double first_offset(const AxisKind& kind) {
    return kind.reference == AxisKind::Reference::absolute ? 0 : -std::round(kind.start_position);
}

}  // namespace

Axis::Axis(const AxisKind& kind, std::uint64_t seed)
    : kind_(kind),
      plant_(kind),
      servo_(kind),
      heat_(kind),
      noise_(hash(seed + 1)),
      supply_voltage_(kind.supply_voltage),
      encoder_offset_(first_offset(kind)) {
    settings_.mass = kind.moving_mass;
    settings_.friction = kind.friction_dynamic;
    stand(static_cast<double>(position()));
}

// Power and wires

void Axis::switch_on() {
    if (on_) {
        return;
    }
    on_ = true;
    servo_.reset();
    hold();
}

void Axis::switch_off() {
    on_ = false;
    touched_ = true;
    current_ = 0;
    measured_current_ = 0;
    force_current_ = 0;
    force_current_steady_ = true;
    stand(static_cast<double>(position()));
}

void Axis::set_brake(bool closed) {
    touched_ = touched_ || closed != brake_;
    brake_ = closed;
}

void Axis::set_supply_voltage(double volts) {
    touched_ = touched_ || volts != supply_voltage_;
    supply_voltage_ = volts;
}

void Axis::set_encoder_lost(bool lost) {
    if (lost == encoder_lost_) {
        return;
    }
    frozen_position_ = static_cast<double>(position());
    encoder_lost_ = lost;
    touched_ = true;
    if (!lost && kind_.reference != AxisKind::Reference::absolute) {
        encoder_offset_ += frozen_position_ - static_cast<double>(position());
    }
}

std::int64_t Axis::position() const { return std::llround(measured_position()); }

/// What the controller sees is finer than the whole increments that the encoder tells everybody else.
double Axis::measured_position() const {
    return encoder_lost_ ? frozen_position_ : plant_.position() + encoder_offset_;
}

void Axis::set_position(std::int64_t value) {
    const double shift = static_cast<double>(value - position());
    encoder_offset_ += shift;
    frozen_position_ += shift;
    touched_ = true;
    stand(set_point_.position + shift);
}

// Set point

void Axis::stand(double position) {
    source_ = Source::hold;
    moving_ = false;
    set_point_ = {position, 0, 0};
}

void Axis::start(const Profile& profile) {
    profile_ = profile;
    profile_periods_ = 0;
    profile_time_ = 0;
    source_ = Source::profile;
    moving_ = profile_.duration() > 0 || profile_.end().velocity != 0;
    touched_ = true;
}

void Axis::move_to(double position, const MotionLimits& limits) {
    if (on_) {
        start(Profile::to_position(set_point_.position, position, limits));
    }
}

void Axis::run_at(double velocity, double acceleration, double jerk) {
    if (on_) {
        start(Profile::to_velocity(set_point_, velocity, acceleration, jerk));
    }
}

void Axis::stop(double acceleration, double jerk) { run_at(0, acceleration, jerk); }

/// Between two set points the velocity is constant. The acceleration is the change of velocity since the set point
/// before, filtered, and no more than the motor can do.
void Axis::follow(double target, double seconds) {
    if (!on_) {
        return;
    }
    const double periods = std::round(std::clamp(seconds, 0.0, longest_follow) / dt);
    follow_left_ = std::max<std::int64_t>(1, static_cast<std::int64_t>(periods));
    const double time = static_cast<double>(follow_left_) * dt;
    const double velocity = (target - set_point_.position) / time;
    const double most = kind_.force_constant * kind_.peak_current / kind_.moving_mass * kind_.increments_per_unit;
    const double acceleration = std::clamp((velocity - set_point_.velocity) / time, -most, most);
    const double before = source_ == Source::follow ? follow_acceleration_ : 0;
    follow_acceleration_ = before + follow_filter * (acceleration - before);
    follow_target_ = target;
    source_ = Source::follow;
    moving_ = velocity != 0 || set_point_.velocity != 0;
    touched_ = true;
}

void Axis::hold() {
    touched_ = true;
    stand(static_cast<double>(position()));
}

void Axis::catch_up() {
    touched_ = true;
    stand(static_cast<double>(position()));
    set_point_.velocity = velocity();
}

void Axis::advance_profile() {
    ++profile_periods_;
    profile_time_ = static_cast<double>(profile_periods_) * dt;
    set_point_ = profile_.at(profile_time_);
    moving_ = profile_time_ < profile_.duration() || set_point_.velocity != 0;
    if (!moving_) {
        stand(profile_.end().position);
    }
}

void Axis::advance_follow() {
    if (follow_left_ == 0) {
        stand(follow_target_);
        return;
    }
    const double way = (follow_target_ - set_point_.position) / static_cast<double>(follow_left_);
    --follow_left_;
    set_point_.position = follow_left_ == 0 ? follow_target_ : set_point_.position + way;
    set_point_.velocity = way / dt;
    set_point_.acceleration = follow_acceleration_;
    moving_ = set_point_.velocity != 0;
}

void Axis::advance_set_point() {
    switch (source_) {
        case Source::hold:
            return;
        case Source::profile:
            advance_profile();
            return;
        case Source::follow:
            advance_follow();
            return;
    }
}

// Time

double Axis::learned_current() const {
    return settings_.cogging_compensation ? -plant_.cogging() / kind_.force_constant : 0;
}

void Axis::control() {
    advance_set_point();
    current_ =
        servo_.step(set_point_, moving_, measured_position(), velocity(), plant_.cogging(), supply_voltage_, settings_);
}

void Axis::measure() {
    const double missing = current_ - learned_current() - force_current_;
    force_current_steady_ = std::abs(missing) < no_current;
    if (!force_current_steady_) {
        force_current_ += force_filter * missing;
    }
    add_noise(1);
}

void Axis::add_noise(std::int64_t periods) {
    noise_ += static_cast<std::uint64_t>(periods);
    measured_current_ = current_ + noise_amplitude * triangular(hash(noise_));
}

void Axis::step() {
    touched_ = false;
    if (on_) {
        control();
    }
    plant_.step(current_, brake_);
    heat_.step(current_, dt);
    if (on_) {
        measure();
    } else {
        stand(static_cast<double>(position()));
    }
}

void Axis::rest(std::int64_t periods) {
    if (periods <= 0) {
        return;
    }
    heat_.step(current_, static_cast<double>(periods) * dt);
    if (on_) {
        add_noise(periods);
    }
}

bool Axis::at_rest() const {
    if (touched_ || !plant_.at_rest()) {
        return false;
    }
    return !on_ ||
           (source_ == Source::hold && servo_.settled() && force_current_steady_ && servo_.settings() == settings_);
}

}  // namespace servobus::drive
