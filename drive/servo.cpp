#include "drive/servo.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drive/time.hpp"

namespace servobus::drive {

namespace {

constexpr double dt = control_period_s;
constexpr double pi = std::numbers::pi;

/// Bandwidth times delay, in rad: what leaves a phase margin of more than 45 degrees.
constexpr double highest_delay_angle = 0.2;
/// Corner of the integral part, as a part of the bandwidth.
constexpr double integral_corner = 0.2;
/// An axis that sticks may be pushed faster, since nothing oscillates there: at least from nothing to its static
/// friction in this time.
constexpr double stuck_gain = 4;
constexpr double stuck_time = 0.1;  // s
constexpr double stuck_below = 50;  // increment/s
/// How much stiffer than the position loop the friction makes it around a set point that stands.
constexpr double standing_stiffness = 4;

/// Control periods after which it is settled, and after which the dead band grows.
constexpr int quiet_enough = 200;
constexpr double held_by_friction = 0.7;
constexpr double release = 0.97;  // of the integral stays, in each control period
constexpr int second_increment_after = 800;
constexpr int growing_after = 2000;
constexpr int growing_each = 200;
constexpr double largest_dead_band = 66;  // increments; more than that is an oscillation, and may be seen
/// So many increments beyond the dead band somebody has pushed the axis.
constexpr double disturbed = 2;

/// A; less is the tail of an exponential.
constexpr double no_current = 1e-7;

double sign(double value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

/// Increments.
double dead_band(int restless) {
    if (restless < second_increment_after) {
        return 1;
    }
    const int growth = std::max(0, restless - growing_after) / growing_each;
    return std::min(2 + static_cast<double>(growth) * growth, largest_dead_band);
}

}  // namespace

Servo::Servo(const AxisKind& kind)
    : kind_(kind),
      unit_(1 / kind.increments_per_unit),
      back_emf_(kind.force_constant * 2 / std::numbers::sqrt3),
      resistance_(std::max(kind.resistance, 1e-3) * std::numbers::sqrt3 / 2),
      integral_limit_(kind.force_constant * kind.peak_current) {
    tune();
}

void Servo::reset() {
    current_ = 0;
    integral_ = 0;
    restless_ = 0;
    quiet_ = 0;
    settled_ = false;
    at_force_limit_ = false;
    saturated_ = false;
}

void Servo::adopt(const ServoSettings& settings) {
    const bool same_loop = settings.mass == settings_.mass && settings.bandwidth == settings_.bandwidth &&
                           settings.current_bandwidth == settings_.current_bandwidth;
    settings_ = settings;
    quiet_ = 0;
    if (!same_loop) {
        tune();
    }
}

void Servo::tune() {
    const double current_rate = 2 * pi * std::max(settings_.current_bandwidth, 1.0);
    const double delay = 1.5 * dt + 1 / current_rate;
    const double rate = std::min(2 * pi * std::max(settings_.bandwidth, 0.1), highest_delay_angle / delay);
    gains_.position = settings_.mass * rate * rate;
    gains_.velocity = settings_.mass * rate * 2;
    gains_.integral = gains_.position * rate * integral_corner * dt;
    gains_.current = -std::expm1(-current_rate * dt);
    restless_ = 0;
}

double Servo::force(const MotionState& set_point, bool moving, double error, double velocity) const {
    if (!settings_.position_control) {
        return 0;
    }
    return integral_ + (moving ? moving_force(set_point, error, velocity) : standing_force(error, velocity));
}

double Servo::moving_force(const MotionState& set_point, double error, double velocity) const {
    const double speed = set_point.velocity * unit_;
    return settings_.mass * set_point.acceleration * unit_ + gains_.velocity * (speed - velocity) +
           gains_.position * error + settings_.friction * sign(speed) + kind_.friction_viscous * speed;
}

double Servo::standing_force(double error, double velocity) const {
    const double most = std::max(settings_.friction, 0.0);
    const double push = std::clamp(standing_stiffness * gains_.position * error, -most, most);
    return gains_.position * error - gains_.velocity * velocity + push;
}

Servo::Range Servo::current_range(bool moving, double velocity, double supply_voltage) const {
    const double most = std::clamp(moving ? settings_.run_limit : settings_.stop_limit, 0.0, kind_.peak_current);
    const double supply = std::max(supply_voltage, 0.0);
    const double emf = back_emf_ * velocity;
    // Braking is always possible: then the back EMF helps.
    return {std::max(-most, std::min((-supply - emf) / resistance_, 0.0)),
            std::min(most, std::max((supply - emf) / resistance_, 0.0))};
}

/// `learned`: the current that only makes up for cogging. It does not count as force.
double Servo::limited(double wanted, double learned, const Range& range) {
    double force = wanted;
    if (settings_.force_limit > 0) {
        force = std::clamp(wanted, learned - settings_.force_limit, learned + settings_.force_limit);
    }
    at_force_limit_ = force != wanted;
    if (settings_.search_limit > 0) {
        force = std::clamp(force, learned - settings_.search_limit, learned + settings_.search_limit);
    }
    const double current = std::clamp(force, range.low, range.high);
    saturated_ = current != force;
    return current;
}

void Servo::integrate_standing(double error, double velocity) {
    const double increments = std::abs(error) * kind_.increments_per_unit;
    if (quiet_ == quiet_enough && increments > dead_band(restless_) + disturbed) {
        restless_ = 0;
    }
    if (increments > dead_band(restless_)) {
        const bool stuck = std::abs(velocity) < stuck_below;
        const double push = gains_.integral * error;
        const double least = std::copysign(kind_.friction_static * dt / stuck_time, error);
        integral_ += !stuck      ? push
                     : error > 0 ? std::max(stuck_gain * push, least)
                                 : std::min(stuck_gain * push, least);
        restless_ = std::min(restless_ + 1, 1'000'000);
    } else if (velocity == 0 && std::abs(integral_) < held_by_friction * settings_.friction) {
        // Friction holds the axis as well; a current for nothing would only warm the motor.
        integral_ *= release;
        if (std::abs(integral_) < no_current * kind_.force_constant) {
            integral_ = 0;
        }
    }
}

/// `held_back`: what the limits took away; an integral that pushed on against them would have to be unwound later.
void Servo::integrate(bool moving, double error, double velocity, double held_back) {
    const double before = integral_;
    if (moving) {
        restless_ = 0;
    }
    if (!settings_.position_control) {
        integral_ = 0;
    } else if (held_back * error <= 0) {
        if (moving) {
            integral_ += gains_.integral * error;
        } else {
            integrate_standing(error, velocity);
        }
        integral_ = std::clamp(integral_, -integral_limit_, integral_limit_);
    }
    const bool quiet = !moving && velocity == 0 && integral_ == before;
    quiet_ = quiet ? std::min(quiet_ + 1, quiet_enough) : 0;
}

double Servo::step(const MotionState& set_point, bool moving, double position, double velocity, double cogging,
                   double supply_voltage, const ServoSettings& settings) {
    if (settings != settings_) {
        adopt(settings);
    }
    const double error = (set_point.position - position) * unit_;
    const double speed = velocity * unit_;
    const double learned = settings_.cogging_compensation ? -cogging / kind_.force_constant : 0;
    const double wanted = force(set_point, moving, error, speed) / kind_.force_constant + learned;
    const double target = limited(wanted, learned, current_range(moving, speed, supply_voltage));
    integrate(moving, error, velocity, wanted - target);

    current_ += gains_.current * (target - current_);
    if (std::abs(target - current_) < no_current) {
        current_ = target;
    }
    settled_ = quiet_ == quiet_enough && current_ == target;
    return current_;
}

}  // namespace servobus::drive
