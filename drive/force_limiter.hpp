// Force limitation with the load cell (LF, 004 §6.2.2): the current that keeps the measured force at its limit.
#pragma once

#include "drive/axis_kind.hpp"

namespace servobus::drive {

class ForceLimiter {
public:
    explicit ForceLimiter(const AxisKind& kind) : kind_(kind) {}

    /// One control period: measured force and limit in N or Nm, the bandwidths in Hz. Returns the highest current in A.
    [[nodiscard]] double step(double measured, double limit, double bandwidth);
    /// The load cell's reading through its filter; `bandwidth` in Hz (SQBW).
    void measure(double force, double bandwidth);
    [[nodiscard]] double measured() const { return measured_; }
    void reset() {
        current_ = -1;
        limit_ = 0;
    }
    /// The limit was reached in the last step.
    [[nodiscard]] bool reached() const { return reached_; }
    void release() { reached_ = false; }

private:
    AxisKind kind_;
    double current_ = -1;  ///< A; below 0: not started
    double limit_ = 0;     ///< N or Nm, of the last step
    double measured_ = 0;
    bool reached_ = false;
};

}  // namespace servobus::drive
