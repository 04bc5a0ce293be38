#include "drive/force_drives.hpp"

#include <cmath>

namespace servobus::drive {

namespace {

MotionLimits limits(double speed, double acceleration) {
    return {speed, acceleration, jerk_of(acceleration, speed, 20)};
}

}  // namespace

Procedure::Progress ThereAndBack::step(Axis& axis, const ProcedureInputs&) {
    switch (stage_) {
        case Stage::starting:
            begin_ = axis.set_point().position;
            stage_ = Stage::forward;
            axis.move_to(begin_ + way_, limits(speed_, acceleration_));
            return Progress::running;
        case Stage::forward:
            if (axis.moving()) return Progress::running;
            stage_ = Stage::back;
            axis.move_to(begin_, limits(speed_, acceleration_));
            return Progress::running;
        case Stage::back:
            return axis.moving() ? Progress::running : Progress::done;
    }
    return Progress::failed;
}

bool ThereAndBack::at_speed(const Axis& axis) const {
    return stage_ != Stage::starting && std::abs(axis.set_point().velocity) >= 0.99 * speed_;
}

Procedure::Progress DriftCompensation::step(Axis& axis, const ProcedureInputs& inputs) {
    if (at_speed(axis)) {
        sum_ += axis.force_current();
        ++samples_;
    }
    return ThereAndBack::step(axis, inputs);
}

Procedure::Progress ForceDrive::step(Axis& axis, const ProcedureInputs&) {
    if (!started_) {
        started_ = true;
        axis.run_at(velocity_, acceleration_, jerk_of(acceleration_, std::abs(velocity_), 1));
        return Progress::running;
    }
    if (!stall_.stalled(axis)) return Progress::running;
    // The set point stays ahead of the axis, so that it goes on pressing.
    axis.stop(acceleration_, jerk_of(acceleration_, std::abs(velocity_), 1));
    return Progress::done;
}

}  // namespace servobus::drive
