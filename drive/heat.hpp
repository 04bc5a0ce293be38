// How warm motor and power stage become, and the I2t model that protects them. All three are first-order lags:
// winding: copper loss 3/4 R I^2 (R phase to phase, I the amplitude), thermal_resistance and thermal_time of the kind;
// power stage: a resistor of its own; I2t: the mean square of the current with the time constant thermal_time. It
// trips at 1.1 times the square of the nominal current.
#pragma once

#include "drive/axis_kind.hpp"

namespace servobus::drive {

class Heat {
public:
    explicit Heat(const AxisKind& kind);

    /// `seconds` under a current in A; exact for any length of time.
    void step(double current, double seconds);

    [[nodiscard]] double winding() const { return surroundings_ + winding_rise_; }    ///< degree Celsius
    [[nodiscard]] double power_stage() const { return surroundings_ + stage_rise_; }  ///< degree Celsius
    /// Mean square of the current over the motor's thermal time, A2, and where it trips.
    [[nodiscard]] double i2t() const { return i2t_; }
    [[nodiscard]] double i2t_limit() const { return i2t_limit_; }
    /// `surroundings`: degree Celsius.
    void set_surroundings(double surroundings) { surroundings_ = surroundings; }
    /// Nothing changes any more while no current flows.
    [[nodiscard]] bool at_rest() const;

private:
    /// Which part of the way to its final value each model goes in a length of time.
    struct Progress {
        double motor;
        double stage;
    };

    [[nodiscard]] Progress progress_in(double seconds) const;

    double motor_time_;      ///< s
    double winding_per_a2_;  ///< K for each A2
    Progress one_period_;    ///< almost every step is one control period
    double surroundings_ = 25;
    double winding_rise_ = 0;
    double stage_rise_ = 0;
    double i2t_ = 0;
    double i2t_limit_ = 0;
};

}  // namespace servobus::drive
