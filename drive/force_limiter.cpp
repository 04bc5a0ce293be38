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

// More than this, and the loop swings with the mass on what it presses against. Hz.
constexpr double highest_bandwidth = 60;
// Within this of the limit it counts as reached.
constexpr double reached_at = 0.97;

}  // namespace

void ForceLimiter::measure(double force, double bandwidth) { measured_ += share(bandwidth) * (force - measured_); }

double ForceLimiter::step(double measured, double limit, double bandwidth) {
    // What friction takes from the motor's force is given to it on top; the rest is up to the loop.
    const double start = (limit + kind_.friction_dynamic) / kind_.force_constant;
    if (current_ < 0) current_ = start;
    // A new limit is met at once as far as it can be foreseen.
    if (limit_ > 0 && limit != limit_) current_ += (limit - limit_) / kind_.force_constant;
    limit_ = limit;
    const double gain = 2 * std::numbers::pi * std::min(bandwidth, highest_bandwidth) * control_period_s * 0.1;
    const double contact = std::abs(measured);
    // On the way to the contact nothing is to be learned; what was learned at another place is forgotten.
    current_ += gain * (contact > 0.5 * limit ? (limit - contact) / kind_.force_constant : start - current_);
    current_ = std::clamp(current_, 0.2 * start, 2 * start);
    reached_ = contact >= reached_at * limit;
    return std::min(current_, kind_.peak_current);
}

}  // namespace servobus::drive
