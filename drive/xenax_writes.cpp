// What a bus writes to the XENAX: direct commands, the commands of class 0x65, and parameters.
#include <algorithm>
#include <cmath>

#include "drive/force_drives.hpp"
#include "drive/reference_drive.hpp"
#include "drive/xenax_drive.hpp"

namespace servobus::drive {

namespace {

constexpr Key direct_command{0x65, 0x00};
constexpr Key clear_output{0x65, 0x29};
constexpr Key event_activation{0x65, 0x2A};
constexpr Key go_immediately{0x65, 0x2B};
constexpr Key start_index_row{0x65, 0x2C};
constexpr Key start_program{0x65, 0x2D};
constexpr Key set_output{0x65, 0x2E};
constexpr Key set_outputs{0x65, 0x2F};
constexpr Key trigger_downward{0x65, 0x30};
constexpr Key trigger_upward{0x65, 0x31};
constexpr Key track_input{0x65, 0x32};
constexpr Key untrack_input{0x65, 0x33};
constexpr Key start_profile{0x65, 0x34};
constexpr Key cogging_drive{0x65, 0x35};
constexpr Key drive_i_force{0x65, 0x36};
constexpr Key change_limit_i_force{0x65, 0x37};
constexpr Key drive_force{0x65, 0x38};
constexpr Key change_limit_force{0x65, 0x43};
constexpr Key clear_force_offset{0x6E, 0x0A};

// Slow enough to meet a stop without harm, increment/s and increment/s2.
constexpr double stop_search_speed = 10'000;
constexpr double search_acceleration = 200'000;
constexpr double calibration_speed = 40'000;
constexpr double drift_way = 2'000;

/// The numbers of 0x65/0 (000 §2.3.2.1).
enum class Command : std::uint32_t {
    ref = 0x1000,
    rsto = 0x1020,
    mlc = 0x1030,
    aref1 = 0x1050,
    pw = 0x2000,
    pwc = 0x2010,
    pwr = 0x2020,
    pq = 0x2030,
    gp = 0x3000,
    gw = 0x3010,
    jp = 0x3020,
    jn = 0x3030,
    sm = 0x3040,
    gz = 0x3050,
    fc = 0x4000,
    fct1 = 0x4001,
    fct0 = 0x4002,
    fct2 = 0x4003,
    ifdcp = 0x4010,
    ifdcn = 0x4011,
    res = 0x5000,
    resm = 0x5001,
    clcp = 0x5010,
    cp121 = 0x5015,
    cp120 = 0x5016,
    clpo = 0x5020,
    dmbus = 0x5030,
    start_force_monitoring = 0x6000,
    finish_force_monitoring = 0x6001,
    tpso = 0x6002,
    clfo = 0x6010,
};

Key owner_of(const Parameter& row) { return row.same_as.value_or(row.key()); }

bool is_rotative(const AxisKind& kind) { return kind.motion == AxisKind::Motion::rotative; }

}  // namespace

std::optional<Refusal> XenaxDrive::check(const Parameter& row, const Value& value) const {
    const Key key = row.key();
    if (key == direct_command) return check_command(static_cast<std::uint32_t>(std::get<std::int64_t>(value)));
    if (key == drive_i_force || key == drive_force) {
        return check_force_drive(std::get<std::int64_t>(value), key == drive_force);
    }
    const bool moves = key == go_immediately || key == start_index_row || key == start_profile;
    if (moves) {
        return check_motion();
    }
    if (key == cogging_drive) return check_command(static_cast<std::uint32_t>(Command::fc));
    return std::nullopt;
}

/// A motion by command: under power, from standstill, and not while a mode owns the set point.
std::optional<Refusal> XenaxDrive::check_motion() const {
    const auto mode = v_.mode_displayed.get();
    const bool free = machine_.state() == Ds402::State::operation_enabled && motion_ == Motion::none && !axis_.moving();
    const bool may =
        free && may_be_moved() && brake_periods_ == 0 && mode != 6 && mode != 8 && (referenced_ || !needs_reference());
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

std::optional<Refusal> XenaxDrive::check_command(std::uint32_t number) const {
    const bool standing = motion_ == Motion::none && !axis_.moving();
    const auto only_if = [](bool possible) {
        return possible ? std::nullopt : std::optional<Refusal>(Refusal::wrong_state);
    };
    switch (static_cast<Command>(number)) {
        case Command::ref:
        case Command::rsto:
            if (static_cast<Command>(number) == Command::rsto && is_rotative(axis_.kind()))
                return Refusal::not_configured;
            return standing && may_be_moved() ? check_power_on() : Refusal::wrong_state;
        case Command::mlc:
            return is_rotative(axis_.kind()) ? Refusal::not_configured : check_motion();
        case Command::pw:
            return is_rotative(axis_.kind()) ? check_power_on() : Refusal::not_configured;
        case Command::pwc:
            return phased_ || is_rotative(axis_.kind()) ? check_power_on() : Refusal::wrong_state;
        case Command::pwr:
            return standing ? check_power_on() : Refusal::wrong_state;
        case Command::gp:
        case Command::gw:
        case Command::ifdcp:
        case Command::ifdcn:
            return check_motion();
        case Command::jp:
        case Command::jn:
            // From one direction to the other without a stop between, as the drive takes it.
            if (v_.mode_displayed.get() == -1) return Refusal::wrong_state;  // there the control word decides
            return motion_ == Motion::jog ? std::nullopt : check_motion();
        case Command::gz:
            return is_rotative(axis_.kind()) ? check_motion() : Refusal::not_configured;
        case Command::fc:
            return v_.mode_displayed.get() == 0 ? check_motion() : Refusal::wrong_state;
        case Command::fct1:
        case Command::fct2:
            return axis_.is_on() && !axis_.settings().position_control ? std::nullopt : check_motion();
        case Command::res:
        case Command::resm:
            return only_if(standing && !axis_.is_on());
        case Command::clpo:
            return is_rotative(axis_.kind()) ? only_if(standing) : Refusal::not_configured;
        case Command::aref1:
        case Command::pq:
        case Command::sm:
        case Command::fct0:
        case Command::clcp:
        case Command::cp121:
        case Command::cp120:
        case Command::dmbus:
        case Command::start_force_monitoring:
        case Command::finish_force_monitoring:
        case Command::tpso:
            return std::nullopt;
        case Command::clfo:
            return is_75v8s_ ? std::nullopt : std::optional<Refusal>(Refusal::not_configured);
    }
    return Refusal::not_allowed;
}

void XenaxDrive::execute(std::uint32_t number) {
    switch (static_cast<Command>(number)) {
        case Command::ref:
            power_on_locally();
            if (brake_periods_ > 0) command_for_power_ = number;
            begin_reference(reference_method_of_rows());
            break;
        case Command::rsto: {
            power_on_locally();
            if (brake_periods_ > 0) command_for_power_ = number;
            const bool positive = v_.direction_reference.get() % 2 == 0;
            const auto end = positive ? v_.mechanical_limit_positive.get() : v_.mechanical_limit_negative.get();
            begin_procedure(ProcedureKind::limit_stop, std::make_unique<LimitStopReference>(
                                                           positive, end, stop_search_speed, search_acceleration));
            break;
        }
        case Command::mlc:
            begin_procedure(ProcedureKind::limit_calibration,
                            std::make_unique<LimitCalibration>(stop_search_speed, search_acceleration));
            break;
        case Command::aref1:
            v_.automatic_reference.set(1);
            break;
        case Command::pwr:
            referenced_ = false;
            power_on_locally();
            phased_ = true;
            break;
        case Command::pw:
        case Command::pwc:
            power_on_locally();
            break;
        case Command::pq:
            power_off_locally();
            break;
        case Command::gp:
            begin_move({static_cast<double>(v_.target.get()), static_cast<double>(v_.speed.get()),
                        static_cast<double>(v_.acceleration.get())});
            break;
        case Command::gw:
            begin_move({base_of_way() + static_cast<double>(v_.way.get()), static_cast<double>(v_.speed.get()),
                        static_cast<double>(v_.acceleration.get())});
            break;
        case Command::jp:
        case Command::jn:
            begin_jog(static_cast<Command>(number) == Command::jp);
            break;
        case Command::sm:
            program_ = nullptr;
            uncoupled_ = true;
            // A quick stop is harder than this one.
            if (motion_ == Motion::none || motion_ == Motion::quick_stop || v_.mode_displayed.get() == 8) break;
            begin_stop();
            break;
        case Command::gz: {
            // The nearest position whose place in the turn is the Z-mark's.
            const double turn = axis_.kind().increments_per_turn;
            const double zero = axis_.kind().z_mark + axis_.encoder_offset();
            const double turns = std::round((base_of_way() - zero) / turn);
            begin_move({zero + turns * turn, static_cast<double>(std::max<std::int64_t>(v_.z_mark_speed.get(), 10)),
                        static_cast<double>(v_.acceleration.get())});
            break;
        }
        case Command::fc:
            begin_procedure(ProcedureKind::force_calibration,
                            std::make_unique<ForceCalibration>(static_cast<double>(v_.way.get()), calibration_speed,
                                                               search_acceleration));
            break;
        case Command::fct1:
        case Command::fct2:
            axis_.settings().position_control = false;
            axis_.settings().cogging_compensation = static_cast<Command>(number) == Command::fct1 && calibrated_;
            break;
        case Command::fct0:
            if (axis_.settings().position_control) break;
            axis_.settings().position_control = true;
            axis_.settings().cogging_compensation = calibrated_;
            if (axis_.is_on()) axis_.hold();
            break;
        case Command::ifdcp:
        case Command::ifdcn: {
            const double way = static_cast<Command>(number) == Command::ifdcp ? drift_way : -drift_way;
            force_offset_ = 0;
            begin_procedure(ProcedureKind::drift_compensation,
                            std::make_unique<DriftCompensation>(way, calibration_speed / 4, search_acceleration));
            break;
        }
        case Command::res:
            reset_parameters();
            break;
        case Command::resm:
            reset_motor_parameters();
            break;
        case Command::clcp:
            capture_.clear();
            break;
        case Command::cp121:
        case Command::cp120:
            capture_.enable(static_cast<Command>(number) == Command::cp121);
            break;
        case Command::clpo:
            axis_.set_position(0);
            trigger_.forget_position();
            break;
        case Command::dmbus:
            withdraw(xenax::message("safety_unit_not_configured"));
            break;
        case Command::start_force_monitoring:
            monitor_.start();
            break;
        case Command::finish_force_monitoring:
            monitor_.finish();
            break;
        case Command::tpso:
            v_.sector_offset.set(shown_position());
            apply_settings();
            break;
        case Command::clfo:
            measured_force_zero_ = limiter_.measured();
            break;
    }
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
    } else if (key.class_id == 0x65 && row.access == Access::set) {
        written_command(key, std::get<std::int64_t>(v_.store.value(row)));
    } else {
        written_parameter(key);
    }
}

void XenaxDrive::written_command(Key key, std::int64_t value) {
    if (key == direct_command) {
        execute(static_cast<std::uint32_t>(value));
    } else if (key == set_output) {
        outputs_.set(static_cast<int>(value));
    } else if (key == clear_output) {
        outputs_.clear(static_cast<int>(value));
    } else if (key == set_outputs) {
        outputs_.set_all(static_cast<std::uint8_t>(value));
    } else if (key == event_activation) {
        tracking_.set_events(value != 0);
    } else if (key == track_input) {
        tracking_.enable(static_cast<int>(value));
    } else if (key == untrack_input) {
        tracking_.disable(static_cast<int>(value));
    } else if (key == trigger_upward) {
        trigger_.set_upward(value);
    } else if (key == trigger_downward) {
        trigger_.set_downward(value);
    } else if (key == go_immediately) {
        begin_move({static_cast<double>(value), static_cast<double>(v_.speed.get()),
                    static_cast<double>(v_.acceleration.get())});
    } else if (key == start_index_row) {
        start_index(value);
    } else if (key == start_program) {
        begin_program(value);
    } else if (key == start_profile) {
        begin_profile(value);
    } else if (key == drive_i_force) {
        start_force_drive(value, false);
    } else if (key == drive_force) {
        start_force_drive(value, true);
    } else if (key == change_limit_i_force) {
        motion_current_limit_ = static_cast<double>(value) / 100;
        apply_settings();
    } else if (key == change_limit_force) {
        motion_force_limit_ = std::abs(static_cast<double>(value)) / 1000;
        apply_settings();
    } else if (key == cogging_drive) {
        const double way = value > 0 ? static_cast<double>(value) : axis_.kind().travel / 2;
        begin_procedure(ProcedureKind::force_calibration,
                        std::make_unique<ForceCalibration>(way, calibration_speed, search_acceleration));
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
    const auto mode = v_.mode_requested.get();
    const auto displayed = v_.mode_displayed.get();
    const auto word = v_.control_word.get();
    v_.store.reset();
    v_.mode_requested.set(mode);
    v_.mode_displayed.set(displayed);
    v_.control_word.set(word);
    shown_ = nullptr;  // the text of a message is a row as well
    outputs_ = {};
    monitor_.configure({});
    set_motor_rows();
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
    set_motor_rows();
    apply_settings();
    calibrated_ = false;
    axis_.settings().cogging_compensation = false;
}

}  // namespace servobus::drive
