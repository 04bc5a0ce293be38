// Power, faults and messages of the XENAX: what the transitions of its state machine do (004 §4.1).
#include <algorithm>
#include <cmath>
#include <utility>

#include "drive/xenax_drive.hpp"

namespace servobus::drive {

namespace {

// Below this the supply cannot feed the motor; above, the power stage protects itself. V.
constexpr double lowest_supply = 18;
constexpr double highest_supply = 85;
constexpr double stage_temperature_after_reset = 80;

}  // namespace

bool XenaxDrive::allows(const Ds402::Transition& transition) {
    switch (transition.number) {
        case 3:
            return !safety_.sto() && !is_under_voltage() && !signals_.emergency_exit;
        case 4:
            if (has_brake() && axis_.brake() && brake_periods_ == 0) {
                brake_periods_ = static_cast<int>(v_.brake_delay.get() * periods_per_ms);
                enable_axis();
            }
            return !safety_.sto() && brake_periods_ == 0;
        case 15:
            return error_ == nullptr || !cause_remains(*error_);
        default:
            return true;
    }
}

void XenaxDrive::happened(const Ds402::Transition& transition) {
    switch (transition.number) {
        case 3:
            inverter_on_ = v_.switch_on_disable.get() == 0;
            break;
        case 4:
            enable_axis();
            if (v_.mode_displayed.get() == mode::reference && v_.automatic_reference.get() != 0 && !referenced_) {
                begin_reference(static_cast<int>(v_.reference_method.get()));
            }
            break;
        case 5:
        case 6:
        case 7:
        case 8:
        case 9:
        case 10:
        case 12:
        case 14:
            disable_axis();
            inverter_on_ = transition.number == 5 && v_.switch_on_disable.get() == 0;
            break;
        case 11:
            quick_stop_ramp();
            break;
        case 13: {
            reaction_periods_ = 0;
            const bool ramps = error_ != nullptr && error_->reaction == xenax::Reaction::ramp_down && axis_.is_on();
            keeps_fault_power_ = ramps;
            abort_motion();
            if (ramps) {
                // From where the axis really is: its set point may be far away.
                axis_.catch_up();
                quick_stop_ramp();
            } else {
                disable_axis();
            }
            break;
        }
        case 15:
            clear_messages();
            break;
        default:
            break;
    }
}

void XenaxDrive::enable_axis() {
    inverter_on_ = true;
    power_off_periods_ = 0;
    if (!axis_.is_on()) axis_.switch_on();
    if (brake_periods_ == 0) axis_.set_brake(false);
    if (!needs_reference()) phased_ = true;
    target_reached_ = has_target_ = limited_ = false;
    reference_done_ = reference_done_ && v_.mode_displayed.get() == mode::reference;
    axis_.settings().position_control = true;
    axis_.settings().cogging_compensation = calibrated_;
}

/// The current goes at once, or after the brake has had the time to close (BRKD).
void XenaxDrive::disable_axis() {
    abort_motion();
    program_ = nullptr;
    monitor_.finish();
    motion_current_limit_.reset();
    motion_force_limit_.reset();
    target_reached_ = in_force_ = false;
    axis_.settings().position_control = true;
    brake_periods_ = 0;
    powers_on_locally_ = false;
    command_for_power_.reset();
    inverter_on_ = false;
    const bool holds = has_brake() && axis_.is_on() && !torque_is_impossible();
    if (has_brake()) axis_.set_brake(true);
    power_off_periods_ = holds ? static_cast<int>(v_.brake_delay.get() * periods_per_ms) : 0;
    if (holds) {
        axis_.hold();
    } else {
        axis_.switch_off();
    }
    apply_settings();  // the limits of a motion are over with it
    change_mode_if_standing();
}

/// An output that releases a holding brake.
bool XenaxDrive::has_brake() const {
    return std::ranges::find(output_settings_.functions, static_cast<std::int64_t>(OutputFunction::brake_released)) !=
           output_settings_.functions.end();
}

/// PW, PWC and REF stand for the control words that lead to Operation enabled; after an error they reset it as well
/// (004 §4.2.7).
void XenaxDrive::power_on_locally() {
    using enum Ds402::Event;
    powers_on_locally_ = machine_.state() != Ds402::State::operation_enabled;
    for (const auto event : {fault_reset, shutdown, switch_on, enable_operation}) {
        if (machine_.state() == Ds402::State::operation_enabled) return;
        machine_.on_event(event, *this);
    }
}

/// What had to wait for the brake: a command, or what the controller asks for, as if it did so in this moment.
void XenaxDrive::brake_is_open() {
    machine_.on_event(Ds402::Event::enable_operation, *this);
    if (machine_.state() != Ds402::State::operation_enabled) return;
    if (const auto command = std::exchange(command_for_power_, std::nullopt)) return execute(*command);
    if (!powers_on_locally_) start_in_mode(machine_.control_word(), machine_.control_word(), 0);
}

/// Nobody is there to end what goes on, so that the drive ends it itself, as a quick stop would; the power stays, and
/// with it the hold on a load. What begins by itself (a program, the master's way) is over as well.
void XenaxDrive::lose_controller() {
    start_bit_is_old_ = true;
    program_ = nullptr;
    auto_program_periods_ = -1;
    uncoupled_ = true;
    if (connected_.outputs_without_controller == OutputsWithoutController::off) outputs_.set_all(0);
    if (brake_periods_ > 0 &&
        machine_.state() == Ds402::State::switched_on) {  // it must not go on to Operation enabled
        disable_axis();
        inverter_on_ = v_.switch_on_disable.get() == 0;
    }
    if (machine_.state() != Ds402::State::operation_enabled) return;
    // Where a force limit holds the axis back its set point is ahead: it would go on when that gives way.
    if (in_force_ || current_limit() > 0 || measured_limit() > 0) axis_.catch_up();
    in_force_ = false;
    machine_.on_event(Ds402::Event::quick_stop, *this);
}

bool XenaxDrive::is_under_voltage() const { return axis_.supply_voltage() < lowest_supply; }

bool XenaxDrive::is_over_voltage() const { return axis_.supply_voltage() > highest_supply; }

/// Nothing from outside holds it, and the controller works (FCT0).
bool XenaxDrive::may_be_moved() const {
    return !safety_.blocks_motion() && !signals_.emergency_exit_power_on && axis_.settings().position_control;
}

void XenaxDrive::power_off_locally() { machine_.on_event(Ds402::Event::disable_voltage, *this); }

void XenaxDrive::raise(const xenax::Message& message) {
    if (error_ != nullptr) return;
    error_ = &message;
    machine_.on_event(Ds402::Event::fault_detected, *this);
}

void XenaxDrive::report(const xenax::Message& message) {
    auto& place = message.severity == xenax::Severity::information ? information_ : warning_;
    if (place == nullptr || !cause_remains(*place)) place = &message;
}

void XenaxDrive::withdraw(const xenax::Message& message) {
    if (warning_ == &message) warning_ = nullptr;
    if (information_ == &message) information_ = nullptr;
}

bool XenaxDrive::has_fault() const {
    return machine_.state() == Ds402::State::fault || machine_.state() == Ds402::State::fault_reaction_active;
}

void XenaxDrive::clear_messages() {
    error_ = warning_ = information_ = nullptr;
    following_failed_ = reference_failed_ = false;
    safety_.forget_hits();
    power_stage_failed_ = false;
}

/// Whether what a message tells is still so.
bool XenaxDrive::cause_remains(const xenax::Message& message) const {
    if (!message.persists) return false;
    const Heat& heat = axis_.heat();
    if (message.name == "over_temperature_motor") return heat.winding() > axis_.kind().temperature_limit - 5;
    if (message.name == "over_temperature_power_stage") return heat.power_stage() > stage_temperature_after_reset;
    if (message.name == "i2t") return heat.i2t() > 0.95 * heat.i2t_limit();
    if (message.name == "under_voltage") return is_under_voltage();
    if (message.name == "over_voltage") return is_over_voltage();
    if (message.name == "encoder_lost") return axis_.encoder_lost();
    if (message.name == "emergency_exit") return signals_.emergency_exit;
    if (message.name == "emergency_exit_power_on") return signals_.emergency_exit_power_on;
    if (message.name == "sto") return safety_.sto();
    if (message.name == "ss1") return safety_.ss1();
    if (message.name == "ss2") return safety_.ss2();
    if (message.name == "sls") return safety_.sls();
    return false;
}

}  // namespace servobus::drive
