#include "drive/force_limiter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drive/time.hpp"

namespace servobus::drive {

namespace {

/// The share of a step that a first-order filter takes over in one control period.
double share(double bandwidth) {
    const double x = 2 * std::numbers::pi * bandwidth * control_period_s;
    return x / (1 + x);
}

// Within this of the limit it counts as reached.
constexpr double reached_at = 0.97;

}  // namespace

void ForceLimiter::measure(double force, double bandwidth) { measured_ += share(bandwidth) * (force - measured_); }

double ForceLimiter::step(double measured, double limit, double bandwidth) {
    // What friction takes from the motor's force is given to it on top; the rest is up to the loop.
    const double start = (limit + kind_.friction_dynamic) / kind_.force_constant;
    if (current_ < 0) current_ = start;
    const double gain = 2 * std::numbers::pi * std::min(bandwidth, 200.0) * control_period_s;
    const double contact = std::abs(measured);
    if (contact > 0.5 * limit) current_ += gain * 0.1 * (limit - contact) / kind_.force_constant;
    current_ = std::clamp(current_, 0.2 * start, 2 * start);
    reached_ = contact >= reached_at * limit;
    return std::min(current_, kind_.peak_current);
}

}  // namespace servobus::drive
