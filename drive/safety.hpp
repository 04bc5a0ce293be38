// The safety motion unit: which functions are requested, and whether the axis keeps to them (004 §3.3.7, §3.4.6).
#pragma once

#include <cstdint>

#include "drive/event.hpp"

namespace servobus::drive {

/// The limits that the unit supervises; its configuration tool sets them on a real drive.
struct SafetySettings {
    std::int64_t sls_timeout_ms = 500;     ///< until the axis has to be slower than sls_speed
    std::int64_t sls_speed = 250'000;      ///< increment/s
    std::int64_t stop_timeout_ms = 500;    ///< until it has to stand after SS1 and SS2
    std::int64_t position_window = 1'000;  ///< increments that it may leave its place under SS2
};

class Safety {
public:
    [[nodiscard]] const SafetySettings& settings() const { return settings_; }

    void request(event::SafetyFunction function, bool active);
    [[nodiscard]] bool sto() const { return sto_ || ss1_over_; }
    [[nodiscard]] bool ss1() const { return ss1_; }
    [[nodiscard]] bool ss2() const { return ss2_; }
    [[nodiscard]] bool sls() const { return sls_; }
    [[nodiscard]] bool ss2_hit() const { return ss2_hit_; }
    [[nodiscard]] bool sls_speed_hit() const { return sls_speed_hit_; }
    /// No new motion may begin.
    [[nodiscard]] bool blocks_motion() const { return sto() || ss1_ || ss2_; }
    [[nodiscard]] bool any() const { return sto_ || ss1_ || ss2_ || sls_; }

    /// One control period.
    void step(double position, double velocity);
    /// After a fault reset. SS2 then watches the place where the axis stands.
    void forget_hits();

private:
    SafetySettings settings_;
    bool sto_ = false;
    bool ss1_ = false;
    bool ss1_over_ = false;
    bool ss2_ = false;
    bool sls_ = false;
    bool ss2_hit_ = false;
    bool sls_speed_hit_ = false;
    std::int64_t ss1_periods_ = 0;
    std::int64_t ss2_periods_ = 0;
    std::int64_t sls_periods_ = 0;
    bool watches_position_ = false;
    double held_position_ = 0;
};

}  // namespace servobus::drive
