#include "drive/heat.hpp"

#include <algorithm>
#include <cmath>

#include "drive/time.hpp"

namespace servobus::drive {

namespace {

/// Copper loss of a star of three phases: 3 phases, R / 2 each, and half the square of the amplitude.
constexpr double loss_factor = 0.75;
/// The power stage: 0.15 ohm on 2 K/W, 90 s.
constexpr double stage_kelvin_per_a2 = 0.3;
constexpr double stage_time = 90;
/// Above what the motor stands for ever.
constexpr double trip_factor = 1.1;
/// What is too little to be seen in any value: K, and A2.
constexpr double nothing = 1e-3;
constexpr double shortest_time = 1e-3;

}  // namespace

Heat::Heat(const AxisKind& kind)
    : motor_time_(std::max(kind.thermal_time, shortest_time)),
      winding_per_a2_(loss_factor * kind.resistance * kind.thermal_resistance),
      one_period_(progress_in(control_period_s)),
      i2t_limit_(trip_factor * kind.nominal_current * kind.nominal_current) {}

Heat::Progress Heat::progress_in(double seconds) const {
    return {-std::expm1(-seconds / motor_time_), -std::expm1(-seconds / stage_time)};
}

void Heat::step(double current, double seconds) {
    const Progress progress = seconds == control_period_s ? one_period_ : progress_in(std::max(seconds, 0.0));
    const double square = current * current;
    winding_rise_ += progress.motor * (winding_per_a2_ * square - winding_rise_);
    stage_rise_ += progress.stage * (stage_kelvin_per_a2 * square - stage_rise_);
    i2t_ += progress.motor * (square - i2t_);
}

bool Heat::at_rest() const { return winding_rise_ < nothing && stage_rise_ < nothing && i2t_ < nothing; }

}  // namespace servobus::drive
