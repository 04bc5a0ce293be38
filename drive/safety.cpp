#include "drive/safety.hpp"

#include <cmath>

#include "drive/time.hpp"

namespace servobus::drive {

namespace {

// Slower than this is standing, increment/s.
constexpr double standstill = 500;

}  // namespace

void Safety::request(event::SafetyFunction function, bool active) {
    switch (function) {
        case event::SafetyFunction::sto:
            sto_ = active;
            return;
        case event::SafetyFunction::ss1:
            ss1_ = active;
            ss1_over_ = false;
            ss1_periods_ = 0;
            return;
        case event::SafetyFunction::ss2:
            ss2_ = active;
            ss2_periods_ = 0;
            watches_position_ = false;
            return;
        case event::SafetyFunction::sls:
            sls_ = active;
            sls_periods_ = 0;
            return;
    }
}

void Safety::step(double position, double velocity) {
    const bool stands = std::abs(velocity) < standstill;
    if (ss1_ && !ss1_over_) {
        ss1_over_ = ++ss1_periods_ >= settings_.stop_timeout_ms * periods_per_ms || (stands && ss1_periods_ > 1);
    }
    if (ss2_ && !watches_position_) {
        watches_position_ =
            ++ss2_periods_ >= settings_.stop_timeout_ms * periods_per_ms || (stands && ss2_periods_ > 1);
        held_position_ = position;
    } else if (ss2_ && std::abs(position - held_position_) > static_cast<double>(settings_.position_window)) {
        ss2_hit_ = true;
    }
    if (sls_ && sls_periods_ < settings_.sls_timeout_ms * periods_per_ms) {
        ++sls_periods_;
    } else if (sls_ && std::abs(velocity) > static_cast<double>(settings_.sls_speed)) {
        sls_speed_hit_ = true;
    }
}

void Safety::forget_hits() {
    ss2_hit_ = sls_speed_hit_ = false;
    watches_position_ = false;
    ss2_periods_ = 0;
}

}  // namespace servobus::drive
