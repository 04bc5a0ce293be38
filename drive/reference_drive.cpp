#include "drive/reference_drive.hpp"

#include <algorithm>
#include <cmath>

namespace servobus::drive {

namespace {

// A linear drive of this family takes about 1.5 s for the electrical angle and a tenth of a second to settle.
constexpr int phasing_periods = 15'000;
constexpr int settling_periods = 1'200;
// Farther than this without finding anything, and there is nothing to be found.
constexpr double sensor_turns = 2.2;
constexpr double z_mark_turns = 1.2;

double search_jerk(double acceleration, double speed) { return jerk_of(acceleration, speed, 20); }

void run(Axis& axis, bool positive, double speed, double acceleration) {
    axis.run_at(positive ? speed : -speed, acceleration, search_jerk(acceleration, speed));
}

/// How many marks of a grid lie between two positions.
int marks_between(double from, double to, double distance) {
    return static_cast<int>(std::abs(std::floor(to / distance) - std::floor(from / distance)));
}

}  // namespace

LinearReference::LinearReference(bool positive, bool phasing, double speed, double acceleration)
    : speed_(speed),
      acceleration_(acceleration),
      positive_(positive),
      stage_(Stage::phasing),
      periods_(phasing ? phasing_periods : 0) {}

void LinearReference::search(Axis& axis, bool positive) {
    positive_ = positive;
    stage_ = Stage::searching;
    marks_ = 0;
    last_position_ = axis.plant().position();
    stall_.reset();
    run(axis, positive, speed_, acceleration_);
}

Procedure::Progress LinearReference::step(Axis& axis, const ProcedureInputs& inputs) {
    switch (stage_) {
        case Stage::phasing:
            if (periods_-- <= 0) search(axis, positive_);
            return Progress::running;
        case Stage::searching:
            return look(axis, inputs);
        case Stage::stopping:
            if (axis.moving()) return Progress::running;
            stage_ = Stage::settling;
            periods_ = settling_periods;
            return Progress::running;
        case Stage::settling:
            if (periods_-- > 0) return Progress::running;
            axis.set_position(std::lround(axis.plant().position()));
            return Progress::done;
    }
    return Progress::failed;
}

Procedure::Progress LinearReference::look(Axis& axis, const ProcedureInputs& inputs) {
    const bool at_switch = positive_ ? inputs.positive_limit : inputs.negative_limit;
    if (at_switch || stall_.stalled(axis)) {
        if (turned_) return Progress::failed;
        turned_ = true;
        axis.hold();
        search(axis, !positive_);
        return Progress::running;
    }
    const double position = axis.plant().position();
    marks_ += marks_between(last_position_, position, axis.kind().mark_distance);
    last_position_ = position;
    if (marks_ >= 2) {
        axis.stop(acceleration_, search_jerk(acceleration_, speed_));
        stage_ = Stage::stopping;
    }
    return Progress::running;
}

Procedure::Progress RotativeReference::step(Axis& axis, const ProcedureInputs& inputs) {
    const double turn = axis.kind().increments_per_turn;
    switch (stage_) {
        case Stage::starting:
            begin_ = axis.plant().position();
            zero_ = begin_;
            if (search_.sensor_speed > 0) {
                stage_ = inputs.reference_sensor ? Stage::leaving_sensor : Stage::sensor;
                // Who stands on the sensor backs off first, so that the same edge counts each time.
                const bool away = stage_ == Stage::leaving_sensor;
                run(axis, away != search_.positive, search_.sensor_speed, search_.acceleration);
            } else {
                start_z_mark(axis);
            }
            return Progress::running;
        case Stage::leaving_sensor:
            if (!inputs.reference_sensor) {
                begin_ = axis.plant().position();
                stage_ = Stage::sensor;
                run(axis, search_.positive, search_.sensor_speed, search_.acceleration);
            }
            return stall_.stalled(axis) || std::abs(axis.plant().position() - begin_) > sensor_turns * turn
                       ? Progress::failed
                       : Progress::running;
        case Stage::sensor:
            return find_sensor(axis, inputs);
        case Stage::z_mark:
            return find_z_mark(axis);
        case Stage::stopping:
            if (axis.moving()) return Progress::running;
            axis.set_position(std::lround(axis.plant().position() - zero_));
            return Progress::done;
    }
    return Progress::failed;
}

Procedure::Progress RotativeReference::find_sensor(Axis& axis, const ProcedureInputs& inputs) {
    if (inputs.reference_sensor) {
        zero_ = axis.plant().position();
        start_z_mark(axis);
        return Progress::running;
    }
    const bool too_far = std::abs(axis.plant().position() - begin_) > sensor_turns * axis.kind().increments_per_turn;
    return too_far || stall_.stalled(axis) ? Progress::failed : Progress::running;
}

void RotativeReference::start_z_mark(Axis& axis) {
    if (search_.z_mark_speed <= 0) {
        found(axis, zero_);
        return;
    }
    const double turn = axis.kind().increments_per_turn;
    const double position = axis.plant().position();
    bool positive = search_.z_mark == ZMarkSearch::positive;
    if (search_.z_mark == ZMarkSearch::shortest) {
        const double ahead = std::fmod(std::fmod(axis.kind().z_mark - position, turn) + turn, turn);
        positive = ahead <= turn / 2;
    }
    stage_ = Stage::z_mark;
    begin_ = position;
    last_position_ = position;
    stall_.reset();
    run(axis, positive, search_.z_mark_speed, search_.acceleration);
}

Procedure::Progress RotativeReference::find_z_mark(Axis& axis) {
    const double turn = axis.kind().increments_per_turn;
    const double position = axis.plant().position();
    const double last = std::floor((last_position_ - axis.kind().z_mark) / turn);
    const double now = std::floor((position - axis.kind().z_mark) / turn);
    last_position_ = position;
    if (last != now) {
        found(axis, axis.kind().z_mark + turn * std::max(last, now));
        return Progress::running;
    }
    const bool too_far = std::abs(position - begin_) > z_mark_turns * turn;
    return too_far || stall_.stalled(axis) ? Progress::failed : Progress::running;
}

void RotativeReference::found(Axis& axis, double zero) {
    zero_ = zero;
    stage_ = Stage::stopping;
    // Both speeds are 0 where there is neither sensor nor Z-mark: the axis stands, and its place becomes 0.
    const double speed = std::max({search_.z_mark_speed, search_.sensor_speed, 1.0});
    axis.stop(search_.acceleration, search_jerk(search_.acceleration, speed));
}

Procedure::Progress LimitStopReference::step(Axis& axis, const ProcedureInputs&) {
    if (!started_) {
        started_ = true;
        begin_ = axis.plant().position();
        run(axis, positive_, speed_, acceleration_);
        return Progress::running;
    }
    if (stall_.stalled(axis)) {
        axis.hold();
        axis.set_position(position_);
        return Progress::done;
    }
    // An axis without stops would go on for ever.
    const double longest = 1.2 * (axis.kind().stop_positive - axis.kind().stop_negative);
    return axis.kind().has_stops && std::abs(axis.plant().position() - begin_) < longest ? Progress::running
                                                                                         : Progress::failed;
}

Procedure::Progress LimitCalibration::step(Axis& axis, const ProcedureInputs&) {
    switch (stage_) {
        case Stage::starting:
            if (!axis.kind().has_stops) return Progress::failed;
            begin_ = axis.position();
            stage_ = Stage::negative;
            run(axis, false, speed_, acceleration_);
            return Progress::running;
        case Stage::negative:
            if (!stall_.stalled(axis)) return Progress::running;
            axis.hold();
            negative_ = axis.position();
            stage_ = Stage::positive;
            stall_.reset();
            run(axis, true, speed_, acceleration_);
            return Progress::running;
        case Stage::positive:
            if (!stall_.stalled(axis)) return Progress::running;
            axis.hold();
            positive_ = axis.position();
            stage_ = Stage::back;
            axis.move_to(static_cast<double>(begin_), {speed_, acceleration_, search_jerk(acceleration_, speed_)});
            return Progress::running;
        case Stage::back:
            return axis.moving() ? Progress::running : Progress::done;
    }
    return Progress::failed;
}

}  // namespace servobus::drive
