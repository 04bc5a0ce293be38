// What a bus writes to the XENAX, and what an edge at an input asks for.
#include <algorithm>
#include <cmath>

#include "drive/force_drives.hpp"
#include "drive/xenax_commands.hpp"
#include "drive/xenax_drive.hpp"

namespace servobus::drive {

namespace {

constexpr Key clear_force_offset{0x6E, 0x0A};

/// Rows of class 0x65 that can be set and not read: each write does something.
bool is_command(const Parameter& row) { return row.key().class_id == 0x65 && row.access == Access::set; }

Key owner_of(const Parameter& row) { return row.same_as.value_or(row.key()); }

}  // namespace

std::optional<Refusal> XenaxDrive::check(const Parameter& row, const Value& value) const {
    return is_command(row) ? check_set_command(row.key(), std::get<std::int64_t>(value)) : std::nullopt;
}

/// A motion by command: under power, from standstill, and not while a mode owns the set point.
std::optional<Refusal> XenaxDrive::check_motion() const {
    const auto shown = v_.mode_displayed.get();
    const bool free = machine_.state() == Ds402::State::operation_enabled && motion_ == Motion::none && !axis_.moving();
    const bool may = free && may_be_moved() && brake_periods_ == 0 && shown != mode::reference &&
                     shown != mode::cyclic_position && (referenced_ || !needs_reference());
    return may ? std::nullopt : std::optional<Refusal>(Refusal::wrong_state);
}

/// A Drive Force without a force would press with all that the motor has; and an override of 0 does not hold a force
/// drive back, as it does a motion to a target.
std::optional<Refusal> XenaxDrive::check_force_drive(std::int64_t number, bool measured) const {
    if (measured && v_.drive_force[static_cast<std::size_t>(number - 1)].get() == 0) return Refusal::not_configured;
    return v_.override.get() == 0 ? Refusal::wrong_state : check_motion();
}

std::optional<Refusal> XenaxDrive::check_power_on() const {
    const bool fault = error_ != nullptr && cause_remains(*error_);
    const bool impossible = fault || safety_.sto() || signals_.emergency_exit || axis_.encoder_lost() ||
                            is_under_voltage() || machine_.state() == Ds402::State::fault_reaction_active;
    return impossible ? std::optional<Refusal>(Refusal::wrong_state) : std::nullopt;
}

void XenaxDrive::written(const Parameter& row) {
    if (row.is_text()) return;
    take(row);
    // What a parameter makes of the inputs counts at once, also for an axis that is at rest.
    watch_inputs();
    supervise();
    publish();
}

void XenaxDrive::take(const Parameter& row) {
    const Key key = owner_of(row);
    if (key == decltype(v_.control_word)::key) {
        on_control_word(static_cast<std::uint16_t>(v_.control_word.get()));
    } else if (is_command(row)) {
        execute_set_command(key, std::get<std::int64_t>(v_.store.value(row)));
    } else {
        written_parameter(key);
    }
}

void XenaxDrive::written_parameter(Key key) {
    if (key == decltype(v_.mode_requested)::key) {
        change_mode_if_standing();
    } else if (key == decltype(v_.target)::key) {
        on_new_target();
    } else if (key == decltype(v_.digital_outputs)::key) {
        outputs_.write_word(static_cast<std::uint32_t>(v_.digital_outputs.get()));
    } else if (key == decltype(v_.synchronous_ratio)::key) {
        uncoupled_ = false;
    } else if (key == clear_force_offset) {
        if (std::get<std::int64_t>(v_.store.value(*v_.store.find(key))) == 1) {
            measured_force_zero_ = limiter_.measured();
        }
    }
    apply_settings();
    if (motion_ == Motion::jog) update_jog();
}

/// Index `number` from 1, or the dynamic index with 0.
void XenaxDrive::start_index(std::int64_t number) {
    const auto i = static_cast<std::size_t>(number - 1);
    const bool dynamic = number == 0;
    const auto type = dynamic ? v_.dynamic_type.get() : v_.index_type[i].get();
    const auto distance = static_cast<double>(dynamic ? v_.dynamic_distance.get() : v_.index_distance[i].get());
    constexpr std::int64_t relative = 2;
    begin_move({type == relative ? base_of_way() + distance : distance,
                static_cast<double>(dynamic ? v_.dynamic_speed.get() : v_.index_speed[i].get()),
                1000 * static_cast<double>(dynamic ? v_.dynamic_acceleration.get() : v_.index_acceleration[i].get())});
}

void XenaxDrive::start_force_drive(std::int64_t number, bool measured) {
    const auto i = static_cast<std::size_t>(number - 1);
    const auto speed = static_cast<double>(v_.force_drive_speed[i].get()) * override_share();
    const bool positive = v_.force_drive_direction[i].get() == 0;
    if (!may_move()) return;
    begin_procedure(ProcedureKind::drive_force,
                    std::make_unique<ForceDrive>(positive ? speed : -speed,
                                                 1000 * static_cast<double>(v_.force_drive_acceleration[i].get())));
    if (measured) {
        motion_force_limit_ = std::abs(static_cast<double>(v_.drive_force[i].get())) / 1000;
    } else {
        motion_current_limit_ = static_cast<double>(v_.force_drive_current[i].get()) / 100;
    }
    apply_settings();
    monitor_.start();
}

/// What an edge at an input asks for is done if it can be done now; otherwise a warning says that it was not.
void XenaxDrive::on_request(const InputRequest& request) {
    using xenax::Command;
    const auto command = [&](Command wanted) {
        const auto number = static_cast<std::uint32_t>(wanted);
        if (check_command(number)) return report(xenax::message("command_not_now"));
        execute(number);
    };
    const auto motion = [&](auto&& start) {
        if (check_motion()) return report(xenax::message("command_not_now"));
        start();
    };
    const auto move_to = [&](double target) {
        begin_move({target, request.b > 0 ? request.b : static_cast<double>(v_.speed.get()),
                    request.c > 0 ? 1000.0 * request.c : static_cast<double>(v_.acceleration.get())});
    };
    switch (request.action) {
        case InputAction::reference:
            return command(Command::ref);
        case InputAction::power_on:
            return command(Command::pwc);
        case InputAction::power_off:
            return command(Command::pq);
        case InputAction::stop:
            return command(Command::sm);
        case InputAction::go_position:
            return motion([&] { move_to(request.a); });
        case InputAction::go_way:
            return motion([&] { move_to(base_of_way() + request.a); });
        case InputAction::start_index:
            return motion([&] { start_index(std::clamp(request.a, 0, 50)); });
        case InputAction::start_program:
            return begin_program(request.a);
        case InputAction::interrupt_program:
        case InputAction::continue_program:
            program_paused_ = request.action == InputAction::interrupt_program;
            return;
        case InputAction::start_profile:
            return motion([&] { begin_profile(request.a); });
        case InputAction::jog_positive:
            return command(Command::jp);
        case InputAction::jog_negative:
            return command(Command::jn);
        case InputAction::drive_force:
            if (check_force_drive(std::clamp(request.a, 1, 10), false))
                return report(xenax::message("command_not_now"));
            return start_force_drive(std::clamp(request.a, 1, 10), false);
        case InputAction::capture_position:
            return capture_.capture(shown_position());
        case InputAction::take_sector_offset:
            return command(Command::tpso);
        case InputAction::fault_reset:
            machine_.on_event(Ds402::Event::fault_reset, *this);
            return;
    }
}

/// RES: everything that can be set, as delivered; what the drive tells stays true.
void XenaxDrive::reset_parameters() {
    const auto requested = v_.mode_requested.get();
    const auto displayed = v_.mode_displayed.get();
    const auto word = v_.control_word.get();
    v_.store.reset();
    v_.mode_requested.set(requested);
    v_.mode_displayed.set(displayed);
    v_.control_word.set(word);
    shown_ = nullptr;  // the text of a message is a row as well
    outputs_ = {};
    monitor_.configure({});
    tell_machine();
    apply_settings();
    shown_ = nullptr;  // its text has been reset as well
    change_mode_if_standing();
}

/// RESM: what depends on the motor, as the connected motor needs it.
void XenaxDrive::reset_motor_parameters() {
    static constexpr std::array<std::uint16_t, 14> rows{0x56, 0x57, 0x58, 0x59, 0x60, 0x61, 0x65,
                                                        0x86, 0x87, 0x97, 0x98, 0x99, 0x9A, 0x8E};
    for (const auto attribute : rows) {
        const Parameter& row = *v_.store.find({0x65, attribute});
        v_.store.assign(row, row.standard);
    }
    tell_machine();
    apply_settings();
    calibrated_ = false;
    axis_.settings().cogging_compensation = false;
}

}  // namespace servobus::drive
