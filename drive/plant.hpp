// The mechanics behind the drive: a mass that a current pushes against friction, stops and obstacles. It is the truth;
// what the drive knows of it comes through its encoder.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "drive/axis_kind.hpp"

namespace servobus::drive {

/// Something in the way: it pushes back with `stiffness` (N or Nm per unit) from `position` (increments) on, against
/// motion in positive direction, or in negative direction when `from_above` is set. One that is put where the axis
/// already is begins at the axis: it touches but does not push, and follows the axis back to `position`.
struct Obstacle {
    double position = 0;
    double stiffness = 50'000;
    bool from_above = false;
};

class Plant {
public:
    explicit Plant(const AxisKind& kind);

    /// One control period under a current in A. `brake`: the holding brake is closed.
    void step(double current, bool brake);

    [[nodiscard]] double position() const { return position_; }  ///< increments from the mechanical zero
    [[nodiscard]] double velocity() const { return velocity_; }  ///< increment/s
    /// Force with which obstacle or stops push back, N or Nm; positive when it is pressed in positive direction. This
    /// is what a load cell would measure.
    [[nodiscard]] double contact_force() const { return contact_force_; }
    /// The last step moved nothing and the next one with the same current would not either.
    [[nodiscard]] bool at_rest() const { return at_rest_; }

    /// Cogging force at a position, N or Nm.
    [[nodiscard]] double cogging_at(double position) const;
    /// Cogging force where the axis stands, N or Nm.
    [[nodiscard]] double cogging() const { return cogging_; }

    void set_payload(double mass);  ///< kg or kg m2 on top of the motor's own
    [[nodiscard]] double mass() const { return kind_.moving_mass + payload_; }
    void set_obstacle(std::optional<Obstacle> obstacle);
    [[nodiscard]] const std::optional<Obstacle>& obstacle() const { return obstacle_; }
    void set_blocked(bool blocked);  ///< as if it were clamped
    [[nodiscard]] bool blocked() const { return blocked_; }
    void set_external_force(double force);  ///< N or Nm: gravity, a spring, a person

private:
    /// A one-sided spring: stops and obstacle.
    struct Contact {
        double place = 0;          ///< increments
        double side = 1;           ///< 1: against motion in positive direction; -1: in negative direction
        double stiffness = 0;      ///< N or Nm for each unit
        double damping_ratio = 0;  ///< of the spring with the mass of the axis
    };
    /// What a period brings, before contacts: an impulse, what resists it, and how fast it becomes.
    struct Push {
        double impulse;
        double inertia;
        double friction;
        [[nodiscard]] double speed() const;
    };

    [[nodiscard]] double depth(const Contact& contact, double position) const;
    [[nodiscard]] double resting_contact_force() const;
    [[nodiscard]] double speed_after(const Push& push);
    [[nodiscard]] double speed_in_contact(const Push& push, std::array<bool, 3> active);
    void move(double speed);
    void retreat_obstacle();
    void rebuild_contacts();

    AxisKind kind_;
    double unit_;           ///< units for each increment
    double cogging_phase_;  ///< radian for each increment
    std::array<Contact, 3> contacts_{};
    std::size_t contact_count_ = 0;
    double payload_ = 0;
    double external_force_ = 0;
    std::optional<Obstacle> obstacle_{};
    bool blocked_ = false;
    double position_ = 0;
    double velocity_ = 0;
    double contact_force_ = 0;
    double cogging_ = 0;
    double obstacle_place_ = 0;  ///< increments; see Obstacle
    bool at_rest_ = true;
};

}  // namespace servobus::drive
