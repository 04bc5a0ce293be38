// A sequence of motions that the drive runs by itself after one command: reference, calibration, a drive with limited
// force. One instance is one run.
#pragma once

#include "drive/axis.hpp"

namespace servobus::drive {

/// What a procedure sees of the wires.
struct ProcedureInputs {
    bool reference_sensor = false;
    bool negative_limit = false;
    bool positive_limit = false;
};

class Procedure {
public:
    enum class Progress : std::uint8_t { running, done, failed };

    virtual ~Procedure() = default;
    /// Called once in each control period, before the axis' own step. The axis is on.
    [[nodiscard]] virtual Progress step(Axis& axis, const ProcedureInputs& inputs) = 0;

protected:
    Procedure() = default;
    Procedure(const Procedure&) = default;
    Procedure& operator=(const Procedure&) = default;
};

/// Notices that an axis which should move does not: it has met a stop, or something holds it.
class StallDetector {
public:
    /// True when the axis has been slower than a tenth of its set point for `patience`.
    [[nodiscard]] bool stalled(const Axis& axis) {
        const double wanted = axis.set_point().velocity;
        const bool slow = wanted * axis.velocity() < 0.1 * wanted * wanted;
        periods_ = slow && wanted != 0 ? periods_ + 1 : 0;
        return periods_ > patience;
    }
    void reset() { periods_ = 0; }

private:
    static constexpr int patience = 300;  // control periods: 30 ms
    int periods_ = 0;
};

}  // namespace servobus::drive
