// The position controller: set point and encoder in, current out. A state controller with feed forward of speed and
// acceleration, an integral part, and the limits of current and voltage.
#pragma once

#include "drive/axis_kind.hpp"
#include "drive/profile.hpp"

namespace servobus::drive {

/// What the drive's parameters make of the controller.
struct ServoSettings {
    double mass = 0.32;                 ///< kg or kg m2 that the controller reckons with: the motor's and ML
    double bandwidth = 50;              ///< Hz of the position loop (BWP)
    double current_bandwidth = 1500;    ///< Hz of the current loop (BWC)
    double friction = 1.2;              ///< N or Nm that it compensates in motion (FFDY)
    double stop_limit = 10;             ///< A at standstill (IS)
    double run_limit = 10;              ///< A in motion (IR)
    double force_limit = 0;             ///< A; 0: no limitation (LIF)
    double search_limit = 0;            ///< A; 0: none. Holds back like the force limit, but nobody is told
    bool cogging_compensation = false;  ///< after a force calibration
    bool position_control = true;       ///< off: only what a calibration has learned flows (FCT1, FCT2)

    friend bool operator==(const ServoSettings&, const ServoSettings&) = default;
};

/// With the bandwidth w (rad/s, lowered to what current loop and control period can bear), and moving:
///
///     F = m (a_ref + 2 w (v_ref - v) + w^2 (x_ref - x)) + friction sign(v_ref) + viscous v_ref + integral
///
/// While the set point stands, the friction is what a small error may add, and the integral stops inside a dead band of
/// one increment, which grows when friction lets the axis find no rest in it.
///
/// Voltage: the supply can be put between two phases, whose back EMF is 2 / sqrt(3) times force_constant and whose
/// resistance counts sqrt(3) / 2, both for a current that is given as amplitude.
class Servo {
public:
    explicit Servo(const AxisKind& kind);

    /// The current in A for the next control period. `cogging` is the force that a calibration has learned for here.
    [[nodiscard]] double step(const MotionState& set_point, bool moving, double position, double velocity,
                              double cogging, double supply_voltage, const ServoSettings& settings);
    void reset();

    /// The force limit held the current back in the last step.
    [[nodiscard]] bool at_force_limit() const { return at_force_limit_; }
    /// Motor or supply gave no more in the last step.
    [[nodiscard]] bool saturated() const { return saturated_; }
    /// The same inputs again would give the same current, and change nothing here.
    [[nodiscard]] bool settled() const { return settled_; }
    [[nodiscard]] const ServoSettings& settings() const { return settings_; }  ///< of the last step

private:
    /// What the settings come to, so that a step need not reckon it.
    struct Gains {
        double position;  ///< N or Nm for each unit
        double velocity;  ///< N or Nm for each unit/s
        double integral;  ///< N or Nm for each unit and control period
        double current;   ///< part of the way to the wanted current in one control period
    };
    struct Range {
        double low;
        double high;
    };

    void adopt(const ServoSettings& settings);
    void tune();
    [[nodiscard]] double force(const MotionState& set_point, bool moving, double error, double velocity) const;
    [[nodiscard]] double moving_force(const MotionState& set_point, double error, double velocity) const;
    [[nodiscard]] double standing_force(double error, double velocity) const;
    [[nodiscard]] Range current_range(bool moving, double velocity, double supply_voltage) const;
    [[nodiscard]] double limited(double wanted, double learned, const Range& range);
    void integrate(bool moving, double error, double velocity, double held_back);
    void integrate_standing(double error, double velocity);

    AxisKind kind_;
    double unit_;        ///< units for each increment
    double back_emf_;    ///< V for each unit/s
    double resistance_;  ///< V for each A
    double integral_limit_;
    ServoSettings settings_{};
    Gains gains_{};
    double current_ = 0;
    double integral_ = 0;
    int restless_ = 0;  ///< control periods of integration since the set point stands
    int quiet_ = 0;     ///< control periods in which nothing changed, up to what settled means
    bool settled_ = false;
    bool at_force_limit_ = false;
    bool saturated_ = false;
};

}  // namespace servobus::drive
