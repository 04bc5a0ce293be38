#include "drive/plant.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drive/time.hpp"

namespace servobus::drive {

namespace {

constexpr double dt = control_period_s;
constexpr double stop_damping = 0.3;
constexpr double obstacle_damping = 0.1;
/// Slower than this, friction is what it is at standstill. Without it an axis whose friction is in balance with its
/// current would creep on for ever, ever slower.
constexpr double creeping_below = 5;  // increment/s
/// Below this the brake's teeth are in, above it only rubs: unit/s.
constexpr double brake_holds_below = 0.002;
/// A rubbing brake, in peak forces of the motor.
constexpr double brake_strength = 1.5;
/// Nothing real is beyond these; they keep arithmetic finite whatever a scenario asks for.
constexpr double highest_payload = 1e6;
constexpr double highest_force = 1e9;
constexpr double highest_stiffness = 1e12;
constexpr double highest_speed = 1e4;  // unit/s

double finite_within(double value, double low, double high) {
    return std::isfinite(value) ? std::clamp(value, low, high) : low;
}

}  // namespace

Plant::Plant(const AxisKind& kind)
    : kind_(kind),
      unit_(1 / kind.increments_per_unit),
      cogging_phase_(kind.cogging_period > 0 ? 2 * std::numbers::pi / kind.cogging_period : 0),
      position_(kind.start_position) {
    rebuild_contacts();
    cogging_ = cogging_at(position_);
    at_rest_ = std::abs(cogging_) <= kind_.friction_static;
}

double Plant::cogging_at(double position) const { return kind_.cogging * std::sin(cogging_phase_ * position); }

void Plant::set_payload(double mass) {
    const double payload = finite_within(mass, 0, highest_payload);
    at_rest_ = at_rest_ && payload == payload_;
    payload_ = payload;
}

void Plant::set_obstacle(std::optional<Obstacle> obstacle) {
    obstacle_ = obstacle;
    if (obstacle_) {
        obstacle_->stiffness = finite_within(obstacle_->stiffness, 0, highest_stiffness);
        obstacle_place_ =
            obstacle_->from_above ? std::min(obstacle_->position, position_) : std::max(obstacle_->position, position_);
    }
    rebuild_contacts();
    at_rest_ = false;
}

void Plant::set_blocked(bool blocked) {
    at_rest_ = at_rest_ && blocked == blocked_;
    blocked_ = blocked;
}

void Plant::set_external_force(double force) {
    const double finite = std::isfinite(force) ? std::clamp(force, -highest_force, highest_force) : 0;
    at_rest_ = at_rest_ && finite == external_force_;
    external_force_ = finite;
}

void Plant::rebuild_contacts() {
    contact_count_ = 0;
    if (kind_.has_stops) {
        contacts_[contact_count_++] = {kind_.stop_negative, -1, kind_.stop_stiffness, stop_damping};
        contacts_[contact_count_++] = {kind_.stop_positive, 1, kind_.stop_stiffness, stop_damping};
    }
    if (obstacle_) {
        const double side = obstacle_->from_above ? -1 : 1;
        contacts_[contact_count_++] = {obstacle_place_, side, obstacle_->stiffness, obstacle_damping};
    }
}

/// An obstacle that had to give way when it was put comes back as far as the axis lets it.
void Plant::retreat_obstacle() {
    if (!obstacle_ || obstacle_place_ == obstacle_->position) {
        return;
    }
    obstacle_place_ = obstacle_->from_above ? std::min(obstacle_->position, std::max(obstacle_place_, position_))
                                            : std::max(obstacle_->position, std::min(obstacle_place_, position_));
    rebuild_contacts();
}

double Plant::depth(const Contact& contact, double position) const {
    return contact.side * (position - contact.place) * unit_;
}

double Plant::resting_contact_force() const {
    double force = 0;
    for (std::size_t i = 0; i < contact_count_; ++i) {
        force += contacts_[i].side * contacts_[i].stiffness * std::max(0.0, depth(contacts_[i], position_));
    }
    return force;
}

/// Coulomb friction solved exactly: an impulse that it can take up ends in standstill, not in a change of sign.
double Plant::Push::speed() const {
    if (std::abs(impulse) <= friction) {
        return 0;
    }
    return (impulse - std::copysign(friction, impulse)) / inertia;
}

double Plant::speed_after(const Push& push) {
    const double free = push.speed();
    const double end = position_ + free * dt * kind_.increments_per_unit;
    std::array<bool, 3> active{};
    bool any = false;
    for (std::size_t i = 0; i < contact_count_; ++i) {
        active[i] = depth(contacts_[i], end) > 0;
        any = any || active[i];
    }
    if (!any) {
        contact_force_ = 0;
        return free;
    }
    return speed_in_contact(push, active);
}

/// Springs and dampers at the end of the period, not at its start: that stays stable however stiff they are. None of
/// them pulls: where one would, first its damper is left out, then the spring.
double Plant::speed_in_contact(const Push& push, std::array<bool, 3> active) {
    std::array<double, 3> damping{};
    for (std::size_t i = 0; i < contact_count_; ++i) {
        damping[i] = 2 * contacts_[i].damping_ratio * std::sqrt(contacts_[i].stiffness * mass());
    }
    while (true) {
        Push held = push;
        for (std::size_t i = 0; i < contact_count_; ++i) {
            if (active[i]) {
                const Contact& contact = contacts_[i];
                held.impulse -= contact.side * dt * contact.stiffness * depth(contact, position_);
                held.inertia += dt * (dt * contact.stiffness + damping[i]);
            }
        }
        const double speed = held.speed();
        bool pulls = false;
        contact_force_ = 0;
        for (std::size_t i = 0; i < contact_count_; ++i) {
            const Contact& contact = contacts_[i];
            const double approach = contact.side * speed;
            const double force =
                contact.stiffness * (depth(contact, position_) + approach * dt) + damping[i] * approach;
            if (active[i] && force < 0) {
                pulls = true;
                active[i] = damping[i] > 0;
                damping[i] = 0;
            } else if (active[i]) {
                contact_force_ += contact.side * force;
            }
        }
        if (!pulls) {
            return speed;
        }
    }
}

void Plant::move(double speed) {
    const double limited = std::clamp(speed, -highest_speed, highest_speed);
    const double before = velocity_;
    velocity_ = limited * kind_.increments_per_unit;
    at_rest_ = before == 0 && velocity_ == 0;
    if (velocity_ != 0) {
        position_ += velocity_ * dt;
        cogging_ = cogging_at(position_);
        retreat_obstacle();
    }
}

void Plant::step(double current, bool brake) {
    const double speed = velocity_ * unit_;
    if (blocked_ || (brake && std::abs(speed) <= brake_holds_below)) {
        contact_force_ = resting_contact_force();
        move(0);
        return;
    }
    const double motor = kind_.force_constant;
    double friction = std::abs(velocity_) < creeping_below ? kind_.friction_static : kind_.friction_dynamic;
    if (brake) {
        friction += brake_strength * motor * kind_.peak_current;
    }
    const double force = motor * current + cogging_ + external_force_;
    move(speed_after({mass() * speed + dt * force, mass() + dt * kind_.friction_viscous, dt * friction}));
}

}  // namespace servobus::drive
