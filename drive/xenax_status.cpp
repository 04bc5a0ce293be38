// What the XENAX tells about itself: status word, process status register, actual values (000 §2.3, 004 §3.3, §4.2).
#include <algorithm>
#include <cmath>
#include <limits>

#include "drive/xenax_drive.hpp"

namespace servobus::drive {

namespace {

std::int64_t within(double value, std::int64_t low, std::int64_t high) {
    const double bounded = std::clamp(value, static_cast<double>(low), static_cast<double>(high));
    return std::llround(bounded);
}

std::int64_t as_i32(double value) {
    return within(value, std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max());
}

template <class Bit>
std::uint32_t bit(Bit number, bool set) {
    return set ? 1U << static_cast<unsigned>(number) : 0U;
}

}  // namespace

/// The counter has 32 bits; an axis without stops may turn farther.
std::int64_t XenaxDrive::shown_position() const { return as_i32(static_cast<double>(axis_.position())); }

bool XenaxDrive::in_motion() const {
    // While a reference finds its electrical angle, and while it settles, the real drive shows no motion.
    const bool procedure = motion_ == Motion::procedure && procedure_kind_ != ProcedureKind::reference;
    return axis_.moving() || waiting_move_.has_value() || procedure || motion_ == Motion::jog;
}

/// Within the target window of where the motion ends.
bool XenaxDrive::in_position() const {
    if (!axis_.is_on() || motion_ == Motion::jog || (motion_ == Motion::procedure && in_motion())) return false;
    const bool positioning = motion_ == Motion::positioning && !waiting_move_;
    const double target = waiting_move_ ? waiting_move_->target
                          : positioning ? axis_.profile().end().position
                                        : axis_.set_point().position;
    return std::abs(target - static_cast<double>(axis_.position())) <= static_cast<double>(v_.target_window.get());
}

/// Bits 10, 12 and 13, which mean something else in each mode.
std::uint16_t XenaxDrive::mode_bits() const {
    const bool enabled = machine_.state() == Ds402::State::operation_enabled;
    const bool stands = !axis_.moving();
    bool ten = false;
    bool twelve = false;
    bool thirteen = following_failed_;
    switch (v_.mode_displayed.get()) {
        case mode::profile_position:
            ten = enabled && target_reached_;
            twelve = enabled && motion_ == Motion::positioning && v_.set_point_acknowledge_disable.get() == 0;
            break;
        case mode::jog: {
            const bool constant =
                axis_.set_point().acceleration == 0 && (stands || axis_.profile_time() >= axis_.profile().duration());
            ten = enabled && constant;
            twelve = enabled && stands;
            break;
        }
        case mode::reference:
            ten = twelve = reference_done_;
            thirteen = reference_failed_ || following_failed_;
            break;
        case mode::cyclic_position:
            ten = enabled && motion_ == Motion::following && in_position() && stands;
            twelve = enabled && motion_ == Motion::following;
            break;
        default:
            break;
    }
    return static_cast<std::uint16_t>(bit(10, ten) | bit(12, twelve) | bit(13, thirteen));
}

std::uint16_t XenaxDrive::status_word() const {
    const bool voltage = !is_under_voltage() && !safety_.sto();
    return static_cast<std::uint16_t>(machine_.status_word() | bit(4, voltage) | bit(7, warning_ != nullptr) |
                                      bit(9, true) | bit(11, limited_) | mode_bits());
}

std::uint32_t XenaxDrive::process_status() const {
    const bool calibrates = procedure_kind_ == ProcedureKind::force_calibration;
    const bool drifts = procedure_kind_ == ProcedureKind::drift_compensation;
    const bool load_cell = measured_limit() > 0;
    return bit(0, error_ != nullptr) | bit(1, referenced_) | bit(2, in_motion()) | bit(3, in_position()) |
           bit(4, program_ == nullptr) | bit(5, in_force_) | bit(6, monitor_.in_sector(axis_.position())) |
           bit(7, monitor_.passed()) | bit(8, inverter_on_) | bit(9, gantry_ && referenced_) |
           bit(10, signals_.negative_limit_switch) | bit(11, signals_.positive_limit_switch) |
           bit(12, signals_.emergency_exit_power_on) | bit(13, signals_.emergency_exit) | bit(14, calibrates) |
           bit(15, force_limit_reached_ && !load_cell) | bit(16, safety_.sto()) | bit(17, safety_.ss1()) |
           bit(18, safety_.ss2()) | bit(19, safety_.ss2_hit()) | bit(20, safety_.sls()) |
           bit(21, safety_.sls_speed_hit()) | bit(23, warning_ != nullptr) | bit(24, information_ != nullptr) |
           bit(25, phased_) | bit(26, drifts) | bit(27, load_cell && limiter_.reached());
}

OutputFlags XenaxDrive::output_flags() const {
    OutputFlags flags;
    flags.error = error_ != nullptr;
    flags.reference = referenced_;
    flags.in_motion = in_motion();
    flags.in_position = in_position();
    flags.end_of_program = program_ == nullptr;
    flags.in_force = in_force_;
    flags.in_sector = monitor_.in_sector(axis_.position());
    flags.force_in_sector = monitor_.passed();
    flags.power_on = inverter_on_;
    flags.trigger = trigger_.active();
    flags.brake_released = !axis_.brake() && axis_.is_on();
    flags.warning = warning_ != nullptr;
    flags.force_limit_reached = force_limit_reached_;
    return flags;
}

OutputLevel XenaxDrive::output_wire(int number) const {
    return output_level(outputs_.states(output_settings_, output_flags()), number, output_settings_);
}

/// 0 standing, 1 accelerating, 2 at constant speed, 3 decelerating; how the drive numbers them is not printed.
int XenaxDrive::trajectory_state() const {
    if (!axis_.moving()) return 0;
    const MotionState& state = axis_.set_point();
    if (std::abs(state.acceleration) < 1e-6) return 2;
    return state.acceleration * state.velocity >= 0 ? 1 : 3;
}

void XenaxDrive::publish() {
    v_.position.set(shown_position());
    v_.velocity.set(as_i32(axis_.velocity()));
    v_.following_error.set(axis_.is_on() ? as_i32(axis_.following_error()) : 0);
    v_.motor_current.set(within(axis_.measured_current() * 1000, -20'000, 20'000));
    v_.status_word.set(static_cast<std::int16_t>(status_word()));
    v_.process_status.set(process_status());
    v_.motion_time.set(motion_periods_ / periods_per_ms);
    v_.process_time.set(process_periods_ / periods_per_ms);
    v_.tell_status.set(error_ != nullptr ? 9 : !inverter_on_ ? 0 : in_motion() ? 2 : 1);
    v_.reference_state.set(referenced_ ? 1 : 0);
    v_.trajectory_state.set(trajectory_state());
    v_.calibration_valid.set(calibrated_ ? 1 : 0);
    const auto acceleration = static_cast<double>(v_.acceleration.get());
    const auto speed = static_cast<double>(v_.speed.get());
    v_.jerk.set(as_i32(jerk_of(acceleration, speed, static_cast<double>(v_.scurve.get())) / 1000));
    const Heat& heat = axis_.heat();
    v_.temperature.set(as_i32(heat.winding()));
    v_.stage_temperature.set(as_i32(heat.power_stage()));
    v_.supply_voltage.set(as_i32(axis_.supply_voltage() * 1000));
    v_.i2t.set(as_i32(heat.i2t() / heat.i2t_limit() * 1000));
    v_.i2t_limit.set(1000);
    publish_force();
    publish_inputs_and_outputs();
    publish_messages();
}

void XenaxDrive::publish_force() {
    v_.force_current.set(as_i32((axis_.force_current() - force_offset_) * 1000));
    v_.force_actual.set(is_75v8s_ ? within(measured_force() * 1000, -200'000, 200'000) : 0);
    v_.force_peak.set(monitor_.peak());
    v_.failed_sectors.set(monitor_.failed());
    for (std::size_t i = 0; i < force_sectors; ++i) v_.sector_peak[i].set(monitor_.peak(i));
}

void XenaxDrive::publish_inputs_and_outputs() {
    v_.input_state.set(levels_);
    v_.digital_inputs.set(static_cast<std::int32_t>(digital_inputs_word(levels_, signals_)));
    v_.output_state.set(outputs_.states(output_settings_, output_flags()));
    v_.digital_outputs.set(static_cast<std::int32_t>(outputs_.word()));
    for (std::size_t i = 0; i < PositionCapture::places; ++i) {
        v_.captured[i].set(capture_.captured(i + 1));
        v_.capture_buffer[i].set(capture_.buffered(i + 1));
    }
}

/// The display shows one message: the error, else the warning, else the information.
void XenaxDrive::publish_messages() {
    const xenax::Message* shown = error_ != nullptr ? error_ : warning_ != nullptr ? warning_ : information_;
    v_.error_number.set(shown == nullptr ? 0 : shown->number);
    // How the safety unit numbers its errors is not printed: the number of the display.
    const bool of_safety_unit = error_ == &xenax::message("ss2_hit") || error_ == &xenax::message("sls_speed_hit");
    v_.safety_error.set(of_safety_unit ? error_->number : 0);
    v_.safety_error.set(error_ != nullptr && xenax::is_of_safety_unit(*error_) ? error_->number : 0);
    if (shown == shown_) return;
    shown_ = shown;
    v_.store.assign(*error_text_row_, std::string(shown == nullptr ? xenax::no_error_text : shown->text));
}

}  // namespace servobus::drive
