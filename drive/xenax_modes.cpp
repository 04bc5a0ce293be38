// What control word and modes make the axis of the XENAX do (000 §3.2, 004 §5).
#include <algorithm>
#include <cmath>

#include "drive/reference_drive.hpp"
#include "drive/xenax_drive.hpp"

namespace servobus::drive {

namespace {

constexpr std::uint16_t start_bit = 1U << 4;
constexpr std::uint16_t relative_or_positive_bit = 1U << 6;
constexpr std::uint16_t halt_bit = 1U << 8;

// S-curves are profile position mode's (004 §3.3.1); every other ramp is as straight as this makes it.
constexpr double straight_ramp = 1;
// A linear axis searches its marks at this speed, increment/s, and with this acceleration, increment/s2.
constexpr double mark_search_speed = 5'000;
constexpr double mark_search_acceleration = 400'000;
// The part of the nominal current with which a stop is met.
constexpr double stop_search_share = 0.6;

double ramp_jerk(double acceleration, double speed) {
    return jerk_of(acceleration, std::max(std::abs(speed), 1.0), straight_ramp);
}

bool is_linear_gantry(std::int64_t method) { return method >= 3 && method <= 6; }

}  // namespace

void XenaxDrive::on_control_word(std::uint16_t word) {
    if (start_bit_is_old_) {
        start_bit_is_old_ = (word & start_bit) != 0;
        word = static_cast<std::uint16_t>(word & ~start_bit);
    }
    const auto before = machine_.control_word();
    machine_.on_control_word(word, *this);
    // Whoever does not want operation any more need not wait for the brake.
    const bool wants_operation = (word & 0x008F) == 0x000F;
    if (brake_periods_ > 0 && machine_.state() == Ds402::State::switched_on && !wants_operation) {
        disable_axis();
        inverter_on_ = v_.switch_on_disable.get() == 0;
    }
    if (machine_.state() != Ds402::State::operation_enabled) return;
    start_in_mode(word, static_cast<std::uint16_t>(word & ~before), static_cast<std::uint16_t>(before & ~word));
}

void XenaxDrive::start_in_mode(std::uint16_t word, std::uint16_t rising, std::uint16_t falling) {
    const bool halt = (word & halt_bit) != 0;
    switch (v_.mode_displayed.get()) {
        case mode::profile_position:
            if (halt && motion_ == Motion::positioning) {
                begin_stop();
            } else if ((rising & start_bit) != 0 && !halt) {
                new_set_point((word & relative_or_positive_bit) != 0);
            }
            break;
        case mode::reference:
            if (((falling & start_bit) != 0 || halt) && procedure_kind_ == ProcedureKind::reference) {
                begin_stop();
            } else if ((rising & start_bit) != 0 && !halt) {
                begin_reference(static_cast<int>(v_.reference_method.get()));
            }
            break;
        case mode::jog:
            update_jog();
            break;
        case mode::cyclic_position:
            update_following((word & start_bit) != 0 && !halt);
            break;
        default:
            break;
    }
}

/// "A new position set point will only be accepted if the running profile reached the target" (004 §5.2): what comes
/// earlier is lost.
void XenaxDrive::new_set_point(bool relative) {
    if (motion_ != Motion::none || axis_.moving() || !may_move()) return;
    const double base = relative ? base_of_way() : 0;
    begin_move({base + static_cast<double>(v_.target.get()), static_cast<double>(v_.speed.get()),
                static_cast<double>(v_.acceleration.get())});
}

/// Jog runs while bit 4 is set and halt is not; speed, acceleration and direction count at once (004 §5.4). While halt
/// stops the axis, bit 6 does not count (errata X-29).
void XenaxDrive::update_jog() {
    if (v_.mode_displayed.get() != mode::jog || machine_.state() != Ds402::State::operation_enabled) {
        if (motion_ == Motion::jog) begin_jog(jog_positive_);
        return;
    }
    const auto word = machine_.control_word();
    const bool run = (word & start_bit) != 0 && (word & halt_bit) == 0;
    if (run && is_linear_gantry(v_.reference_method.get())) {
        report(xenax::message("jog_in_gantry"));
    } else if (run && (motion_ == Motion::jog || motion_ == Motion::stopping || motion_ == Motion::none)) {
        begin_jog((word & relative_or_positive_bit) != 0);
    } else if (!run && motion_ == Motion::jog) {
        begin_stop();
    }
}

void XenaxDrive::update_following(bool on) {
    if (on && motion_ == Motion::none && may_move()) {
        begin_motion(Motion::following);
        on_new_target();
    } else if (!on && motion_ == Motion::following) {
        buffered_target_.reset();
        begin_stop();
    }
}

/// A set point of cyclic synchronous position. Buffered, each is driven to one cycle later, so that one that comes late
/// leaves no gap (FBCM).
void XenaxDrive::on_new_target() {
    if (motion_ != Motion::following) return;
    const double target = limited(static_cast<double>(v_.target.get()));
    const double cycle = static_cast<double>(v_.cycle_time.get()) * 1e-6;
    if (v_.force_buffered_csp.get() != 0 && axis_.moving()) {
        if (buffered_target_) axis_.follow(*buffered_target_, cycle);
        buffered_target_ = target;
    } else {
        axis_.follow(target, cycle);
    }
}

/// The mode that is asked for becomes the mode that is shown when the axis stands.
void XenaxDrive::change_mode_if_standing() {
    const auto wanted = v_.mode_requested.get();
    if (wanted == v_.mode_displayed.get()) return;
    if (motion_ == Motion::following && !axis_.moving()) {
        buffered_target_.reset();
        motion_ = Motion::none;
    }
    if (motion_ != Motion::none || axis_.moving()) return;
    v_.mode_displayed.set(wanted);
    target_reached_ = has_target_ = false;
    reference_done_ = reference_done_ && wanted == mode::reference;
    reference_failed_ = false;
    const bool by_itself = v_.automatic_reference.get() != 0 && !referenced_;
    if (wanted == mode::reference && by_itself && machine_.state() == Ds402::State::operation_enabled) {
        begin_reference(static_cast<int>(v_.reference_method.get()));
    }
}

/// A linear axis does not know its electrical angle before the reference (004 §5.1.1).
bool XenaxDrive::needs_reference() const { return axis_.kind().reference == AxisKind::Reference::distance_coded_marks; }

bool XenaxDrive::may_move() {
    if (machine_.state() != Ds402::State::operation_enabled || brake_periods_ > 0) return false;
    if (!may_be_moved()) {
        report(xenax::message("command_not_now"));
        return false;
    }
    if (!referenced_ && needs_reference()) {
        report(xenax::message("reference_missing"));
        return false;
    }
    return true;
}

/// SP as the override leaves it.
double XenaxDrive::set_speed() const { return static_cast<double>(v_.speed.get()) * override_share(); }

/// Where a distance begins: at the set point, or where the axis stands when it presses and will never get there.
double XenaxDrive::base_of_way() const {
    return in_force_ ? static_cast<double>(axis_.position()) : axis_.set_point().position;
}

MotionLimits XenaxDrive::limits_of(double speed, double acceleration) const {
    return {speed, acceleration, jerk_of(acceleration, speed, static_cast<double>(v_.scurve.get()))};
}

bool XenaxDrive::soft_limits() const {
    return referenced_ && v_.soft_limit_negative.get() < v_.soft_limit_positive.get();
}

/// "Every new target position shall be checked against these limits" (004 §4.2.14): the axis goes as far as it may.
double XenaxDrive::limited(double target) {
    limited_ = false;
    withdraw(xenax::message("soft_limit"));
    if (!soft_limits()) return target;
    const double allowed = std::clamp(target, static_cast<double>(v_.soft_limit_negative.get()),
                                      static_cast<double>(v_.soft_limit_positive.get()));
    limited_ = allowed != target;
    if (limited_) report(xenax::message("soft_limit"));
    return allowed;
}

/// A jog, and a force drive that meets nothing, brake in time to stand at the limit.
void XenaxDrive::watch_soft_limits() {
    if (motion_ == Motion::none || !soft_limits()) return;
    const double velocity = axis_.set_point().velocity;
    if (velocity == 0) return;
    const double acceleration = static_cast<double>(v_.acceleration.get());
    const auto limit = static_cast<double>(velocity > 0 ? v_.soft_limit_positive.get() : v_.soft_limit_negative.get());
    const double left = std::abs(limit - axis_.set_point().position);
    const bool past = (velocity > 0) == (axis_.set_point().position > limit);
    const auto braking = Profile::to_velocity(axis_.set_point(), 0, acceleration, ramp_jerk(acceleration, velocity));
    const double needed = std::abs(braking.end().position - braking.start().position);
    if (!past && left > needed + 2 * std::abs(velocity) * control_period_s) return;
    limited_ = true;
    report(xenax::message("soft_limit"));
    begin_stop();
}

void XenaxDrive::begin_motion(Motion motion) {
    motion_ = motion;
    if (in_force_) axis_.hold();  // the set point of a force drive is somewhere ahead
    motion_current_limit_.reset();
    motion_force_limit_.reset();
    measured_limit_met_ = false;
    target_reached_ = false;
    in_force_ = false;
    following_failed_ = false;
    window_periods_ = 0;
    has_target_ = true;
    motion_periods_ = process_periods_ = 0;
    // What a warning said about an earlier command is over when one succeeds.
    if (warning_ != nullptr && !cause_remains(*warning_)) warning_ = nullptr;
    if (information_ != nullptr && !cause_remains(*information_)) information_ = nullptr;
    apply_settings();
}

void XenaxDrive::begin_move(const Move& move) {
    if (!may_move()) return;
    begin_motion(Motion::positioning);
    monitor_.start();
    Move wanted = move;
    wanted.target = limited(move.target);
    if (v_.override.get() == 0) {  // it holds the motion back
        waiting_move_ = wanted;
        return;
    }
    axis_.move_to(wanted.target, limits_of(wanted.speed * override_share(), wanted.acceleration));
}

void XenaxDrive::begin_jog(bool positive) {
    if (!may_move()) return;
    const double position = axis_.set_point().position;
    const bool at_limit =
        soft_limits() && (positive ? position >= static_cast<double>(v_.soft_limit_positive.get()) - 1
                                   : position <= static_cast<double>(v_.soft_limit_negative.get()) + 1);
    if (at_limit) {
        limited_ = true;
        report(xenax::message("soft_limit"));
        return;
    }
    if (motion_ != Motion::jog) begin_motion(Motion::jog);
    jog_positive_ = positive;
    limited_ = false;
    withdraw(xenax::message("soft_limit"));
    const double acceleration = static_cast<double>(v_.acceleration.get());
    const double speed = set_speed();
    axis_.run_at(positive ? speed : -speed, acceleration, ramp_jerk(acceleration, speed));
}

/// With the acceleration of this moment (004 §5.2.3); rounded off as the motion was, if that was a positioning.
void XenaxDrive::begin_stop() {
    const double acceleration = static_cast<double>(v_.acceleration.get());
    const double speed = std::max(std::abs(axis_.set_point().velocity), 10.0);
    const bool curved = motion_ == Motion::positioning;
    abort_motion();
    motion_ = Motion::stopping;
    axis_.stop(acceleration, curved ? limits_of(speed, acceleration).jerk : ramp_jerk(acceleration, speed));
}

void XenaxDrive::quick_stop_ramp() {
    const double deceleration = static_cast<double>(v_.quick_stop_deceleration.get());
    abort_motion();
    motion_ = Motion::quick_stop;
    axis_.stop(deceleration, ramp_jerk(deceleration, std::max(std::abs(axis_.set_point().velocity), 10.0)));
}

/// The method that the drive's own parameters describe: DRHR for linear axes (errata X-37), DRH and DRZ for others.
int XenaxDrive::reference_method_of_rows() const {
    if (axis_.kind().motion == AxisKind::Motion::linear) return static_cast<int>(v_.direction_reference.get()) + 1;
    const bool clockwise = v_.home_direction.get() == 1;
    const auto z_mark = v_.z_mark_direction.get();
    if (z_mark == 3) return clockwise ? 14 : 15;
    const bool z_clockwise = z_mark == 1;
    return clockwise ? (z_clockwise ? 11 : 10) : (z_clockwise ? 13 : 12);
}

void XenaxDrive::begin_reference(int method) {
    if (machine_.state() != Ds402::State::operation_enabled || motion_ != Motion::none || axis_.moving()) return;
    if (!may_be_moved()) return report(xenax::message("command_not_now"));
    const bool linear = axis_.kind().motion == AxisKind::Motion::linear;
    reference_done_ = reference_failed_ = false;
    if (axis_.kind().reference == AxisKind::Reference::absolute) {  // nothing to search (004 §5.1.8)
        referenced_ = reference_done_ = true;
        return;
    }
    const bool shortest = method >= 14;
    const bool fits =
        linear ? method <= 6 : method >= 10 && (!shortest || axis_.kind().family == AxisKind::Family::rotax_rxvp);
    if (!fits) {
        reference_failed_ = true;
        return report(xenax::message("command_not_now"));
    }
    if (linear) {
        const bool positive = method % 2 == 1;
        begin_procedure(ProcedureKind::reference, std::make_unique<LinearReference>(
                                                      positive, !phased_, mark_search_speed, mark_search_acceleration));
    } else {
        RotativeReference::Search search;
        search.positive = method == 10 || method == 11 || method == 14;
        search.z_mark = shortest                       ? ZMarkSearch::shortest
                        : method == 11 || method == 13 ? ZMarkSearch::positive
                                                       : ZMarkSearch::negative;
        search.sensor_speed = static_cast<double>(v_.sensor_speed.get());
        search.z_mark_speed = static_cast<double>(v_.z_mark_speed.get());
        search.acceleration = static_cast<double>(v_.acceleration.get());
        begin_procedure(ProcedureKind::reference, std::make_unique<RotativeReference>(search));
    }
    referenced_ = false;
    gantry_ = linear && is_linear_gantry(method);
    if (gantry_) v_.gantry_offset.set(v_.preset_gantry_offset_enable.get() != 0 ? v_.preset_gantry_offset.get() : 0);
}

void XenaxDrive::begin_procedure(ProcedureKind kind, std::unique_ptr<Procedure> procedure) {
    if (machine_.state() != Ds402::State::operation_enabled) return;
    begin_motion(Motion::procedure);
    procedure_kind_ = kind;
    procedure_ = std::move(procedure);
    const bool meets_stops = kind == ProcedureKind::limit_stop || kind == ProcedureKind::limit_calibration;
    axis_.settings().search_limit = meets_stops ? stop_search_share * axis_.kind().nominal_current : 0;
}

/// Forgets what the axis was about to do; the set point is the caller's business.
void XenaxDrive::abort_motion() {
    axis_.settings().search_limit = 0;
    procedure_.reset();
    procedure_kind_ = ProcedureKind::none;
    waiting_move_.reset();
    buffered_target_.reset();
    profile_parts_ = nullptr;
    motion_ = Motion::none;
}

}  // namespace servobus::drive
