#include "drive/xenax_drive.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drive/force_drives.hpp"
#include "drive/reference_drive.hpp"

namespace servobus::drive {

namespace {

// While something moves, somebody should look this often.
constexpr Time tick{1000};
// A fault reaction that takes longer than this ends without standstill.
constexpr int longest_reaction = 20'000;
constexpr double highest_stage_temperature = 90;
// Standing with less than this share of the nominal current, nothing can become too hot.
constexpr double harmless_share = 0.3;
// Slower than this is standing, increment/s.
constexpr double standstill = 500;
// A limit of 0 would be none, A.
constexpr double least_force_limit = 1e-3;

std::int64_t rounded(double value) { return std::llround(value); }

/// Mass as the drive's parameters count it: g, or 1e-9 kg m2.
double mass_unit(const AxisKind& kind) { return kind.motion == AxisKind::Motion::linear ? 1e3 : 1e9; }

}  // namespace

XenaxDrive::XenaxDrive(const Model& model, Store& store, const Machine& machine)
    : connected_(machine),
      is_75v8s_(model.has_force_option),
      is_48v8_(model.key == "48v8"),
      v_(store),
      error_text_row_(store.find({0x69, 0x01})),
      motor_type_row_(store.find({0x64, 0x08})),
      axis_(machine.axis, machine.seed),
      limiter_(machine.axis) {}

std::unique_ptr<Behaviour> XenaxDrive::make(const Model& model, Store& store, const Machine& machine) {
    return std::make_unique<XenaxDrive>(model, store, machine);
}

// Logic power has come. What is outside (the place of the axis, obstacles, levels at the inputs) is as it was; what the
// drive knows is forgotten.
void XenaxDrive::power_up() {
    restart();
    watch_inputs();
    supervise();
    publish();
}

void XenaxDrive::restart() {
    axis_.switch_off();
    if (axis_.kind().reference != AxisKind::Reference::absolute) axis_.set_position(0);  // it counts from here
    machine_.reset();
    referenced_ = axis_.kind().reference == AxisKind::Reference::absolute;
    phased_ = referenced_;
    abort_motion();
    inverter_on_ = false;
    power_stage_failed_ = false;
    start_bit_is_old_ = false;
    brake_periods_ = power_off_periods_ = 0;
    powers_on_locally_ = false;
    command_for_power_.reset();
    motion_current_limit_.reset();
    motion_force_limit_.reset();
    axis_.settings().position_control = true;
    axis_.settings().cogging_compensation = false;
    v_.mode_displayed.set(0);
    has_target_ = false;
    reference_done_ = reference_failed_ = following_failed_ = limited_ = target_reached_ = false;
    in_force_ = force_limit_reached_ = calibrated_ = gantry_ = false;
    force_offset_ = measured_force_zero_ = 0;
    program_ = nullptr;
    program_paused_ = false;
    error_ = warning_ = information_ = nullptr;
    capture_ = {};
    trigger_ = {};
    tracking_ = {};
    monitor_ = {};
    outputs_ = {};
    seen_levels_ = levels_;
    if (v_.auto_program.get() > 0) auto_program_periods_ = v_.auto_program_delay.get() * periods_per_ms;
    apply_settings();
    machine_.on_event(Ds402::Event::initialised, *this);
    publish();
}

void XenaxDrive::step(Time now) {
    if (!started_) {
        started_ = true;
        clock_ = now;
        return;
    }
    if (now - clock_ < control_period) return;
    while (now - clock_ >= control_period) {
        if (idle()) {
            const auto periods = (now - clock_) / control_period;
            axis_.rest(periods);
            trigger_.rest(periods);
            clock_ += periods * control_period;
            supervise();
            break;
        }
        clock_ += control_period;
        period();
    }
    publish();
}

std::optional<Time> XenaxDrive::next_deadline() const {
    return started_ && !idle() ? std::optional<Time>(clock_ + tick) : std::nullopt;
}

/// Nothing would change until somebody does something.
bool XenaxDrive::idle() const {
    const bool waits = brake_periods_ > 0 || power_off_periods_ > 0 || auto_program_periods_ >= 0 ||
                       trigger_.active() || waiting_move_ || buffered_target_ || program_ != nullptr ||
                       master_speed_ != 0;
    const bool works = motion_ != Motion::none && motion_ != Motion::following;
    const bool settles = axis_.is_on() && (in_motion() || !target_settled());
    const bool harmless = std::abs(axis_.current()) < harmless_share * axis_.kind().nominal_current;
    return !waits && !works && !settles && harmless && axis_.at_rest() && seen_levels_ == levels_ && !safety_.any() &&
           machine_.state() != Ds402::State::fault_reaction_active;
}

/// The time that the target window asks for has nothing left to count.
bool XenaxDrive::target_settled() const { return !in_position() || window_periods_ > window_periods_wanted(); }

std::int64_t XenaxDrive::window_periods_wanted() const { return v_.target_window_time.get() * periods_per_ms; }

void XenaxDrive::period() {
    watch_inputs();
    if (motion_ == Motion::procedure) run_procedure();
    if (motion_ == Motion::jog || procedure_kind_ == ProcedureKind::drive_force) watch_soft_limits();
    axis_.step();
    sample();
    after_motion();
    watch_target_window();
    if (safety_.any()) safety_.step(static_cast<double>(axis_.position()), axis_.velocity());
    if (machine_.state() == Ds402::State::fault_reaction_active) ++reaction_periods_;
    supervise();
    if (auto_program_periods_ >= 0 && auto_program_periods_-- == 0) begin_program(v_.auto_program.get());
    run_program();
    follow_master();
    if (power_off_periods_ > 0 && --power_off_periods_ == 0) axis_.switch_off();
    if (brake_periods_ > 0 && --brake_periods_ == 0) {
        axis_.set_brake(false);
        brake_is_open();
    }
}

void XenaxDrive::run_procedure() {
    const auto progress = procedure_->step(axis_, procedure_inputs());
    if (procedure_kind_ == ProcedureKind::reference && axis_.moving()) phased_ = true;
    if (progress != Procedure::Progress::running) end_procedure(progress);
}

ProcedureInputs XenaxDrive::procedure_inputs() const {
    const AxisKind& kind = axis_.kind();
    ProcedureInputs inputs{is_set(active_inputs(levels_, input_settings_), static_cast<int>(v_.home_input.get())),
                           signals_.negative_limit_switch, signals_.positive_limit_switch};
    if (kind.sensor_width > 0 && kind.increments_per_turn > 0) {
        const double turn = kind.increments_per_turn;
        const double angle = std::fmod(std::fmod(axis_.plant().position() - kind.sensor_position, turn) + turn, turn);
        inputs.reference_sensor = inputs.reference_sensor || angle < kind.sensor_width;
    }
    return inputs;
}

/// After the axis has moved: force curve, trigger, capture.
void XenaxDrive::sample() {
    const auto position = axis_.position();
    const bool measured = v_.forceteq_mode.get() != 0 && is_75v8s_;
    limiter_.measure(axis_.contact_force(), static_cast<double>(v_.force_bandwidth.get()));
    if (monitor_.running()) {
        monitor_.sample(position, measured ? rounded(measured_force() * 1000) : i_force_10ma());
    }
    trigger_.step(position);

    const bool limited_by_current = axis_.at_force_limit();
    force_limit_reached_ = limited_by_current;
    if (axis_.is_on() && measured_limit() > 0) {
        const double current =
            limiter_.step(measured_force(), measured_limit(), static_cast<double>(v_.force_controller_bandwidth.get()));
        measured_limit_met_ = measured_limit_met_ || limiter_.reached();
        axis_.settings().force_limit = std::max(current * share_after_force_limit(), least_force_limit);
    }
}

std::int64_t XenaxDrive::i_force_10ma() const { return rounded((axis_.force_current() - force_offset_) * 100); }

/// What the load cell shows, N.
double XenaxDrive::measured_force() const { return limiter_.measured() - measured_force_zero_; }

/// Whoever has met the force limit may lose what he pressed against: the share of the current that is left as the axis
/// comes near to LFRMS.
double XenaxDrive::share_after_force_limit() const {
    const auto highest = static_cast<double>(v_.force_reached_speed.get());
    // Pushed back it is not held by less current.
    const bool runs_ahead = axis_.velocity() * axis_.current() > 0;
    if (!measured_limit_met_ || highest <= 0 || !runs_ahead) return 1;
    return std::clamp(2 * (1 - std::abs(axis_.velocity()) / highest), 0.0, 1.0);
}

/// The force that the load cell may show, N; 0: no limitation. LF counts with the load cell alone.
double XenaxDrive::measured_limit() const {
    if (!is_75v8s_) return 0;
    if (motion_force_limit_) return *motion_force_limit_;
    return std::abs(static_cast<double>(v_.limit_force.get())) / 1000;
}

/// The current that the motor may draw, A; 0: no limitation.
double XenaxDrive::current_limit() const {
    return motion_current_limit_ ? *motion_current_limit_ : static_cast<double>(v_.limit_current.get()) / 100;
}

void XenaxDrive::after_motion() {
    if (in_motion()) {
        ++motion_periods_;
        ++process_periods_;
    }
    if (waiting_move_ && v_.override.get() > 0) {
        const Move move = *waiting_move_;
        waiting_move_.reset();
        axis_.move_to(move.target, limits_of(move.speed * override_share(), move.acceleration));
        return;
    }
    if (waiting_move_ || axis_.moving() || motion_ == Motion::procedure) return;
    if (buffered_target_ && motion_ == Motion::following) {
        axis_.follow(*buffered_target_, static_cast<double>(v_.cycle_time.get()) * 1e-6);
        buffered_target_.reset();
        return;
    }
    const bool ended = motion_ == Motion::positioning || motion_ == Motion::stopping || motion_ == Motion::quick_stop;
    if (!ended) {
        change_mode_if_standing();
        return;
    }
    motion_ = Motion::none;
    if (v_.mode_displayed.get() != mode::cyclic_position) monitor_.finish();
    if (next_profile_part()) return;
    change_mode_if_standing();
}

void XenaxDrive::watch_target_window() {
    const bool inside =
        axis_.is_on() && !axis_.moving() && motion_ != Motion::procedure && !waiting_move_ && in_position();
    window_periods_ = inside ? window_periods_ + 1 : 0;
    if (inside && window_periods_ > window_periods_wanted() && has_target_) target_reached_ = true;
}

void XenaxDrive::watch_inputs() {
    signals_ = input_signals(levels_, input_settings_);
    signals_.negative_limit_switch |= wired_.negative_limit_switch;
    signals_.positive_limit_switch |= wired_.positive_limit_switch;
    signals_.emergency_exit |= wired_.emergency_exit;
    signals_.emergency_exit_power_on |= wired_.emergency_exit_power_on;
    const int capture_input = is_48v8_ ? PositionCapture::input_of_48v8 : PositionCapture::input_of_75v8;
    capture_.sample(is_set(active_inputs(levels_, input_settings_), capture_input), shown_position());
    if (levels_ == seen_levels_) return;
    const auto requests = input_requests(seen_levels_, levels_, input_settings_);
    seen_levels_ = levels_;
    for (const auto& request : requests) on_request(request);
}

void XenaxDrive::end_procedure(Procedure::Progress progress) {
    const auto kind = std::exchange(procedure_kind_, ProcedureKind::none);
    const auto procedure = std::move(procedure_);
    motion_ = Motion::none;
    axis_.settings().search_limit = 0;
    if (progress == Procedure::Progress::failed) {
        reference_failed_ = kind == ProcedureKind::reference;
        raise(failure_of(kind));
        return;
    }
    take_result(kind, *procedure);
    change_mode_if_standing();
}

const xenax::Message& XenaxDrive::failure_of(ProcedureKind kind) const {
    switch (kind) {
        case ProcedureKind::reference:
            return axis_.kind().motion == AxisKind::Motion::linear ? xenax::message("reference_mark_not_found")
                                                                   : xenax::message("reference_sensor_not_found");
        case ProcedureKind::force_calibration:
            return xenax::message("force_calibration_failed");
        case ProcedureKind::drift_compensation:
            return xenax::message("drift_compensation_failed");
        case ProcedureKind::limit_stop:
        case ProcedureKind::limit_calibration:
        case ProcedureKind::drive_force:
        case ProcedureKind::none:
            return xenax::message("mechanical_limit_not_found");
    }
    return xenax::message("mechanical_limit_not_found");
}

/// What the drive knows after a procedure.
void XenaxDrive::take_result(ProcedureKind kind, const Procedure& procedure) {
    switch (kind) {
        case ProcedureKind::reference:
        case ProcedureKind::limit_stop:
            referenced_ = phased_ = true;
            reference_done_ = kind == ProcedureKind::reference;
            trigger_.forget_position();
            break;
        case ProcedureKind::limit_calibration: {
            const auto& limits = static_cast<const LimitCalibration&>(procedure);
            v_.mechanical_limit_negative.set(limits.negative());
            v_.mechanical_limit_positive.set(limits.positive());
            v_.detected_limit_positive.set(std::max<std::int64_t>(limits.positive(), 0));
            break;
        }
        case ProcedureKind::force_calibration:
            calibrated_ = true;
            axis_.settings().cogging_compensation = true;
            break;
        case ProcedureKind::drift_compensation:
            force_offset_ = static_cast<const DriftCompensation&>(procedure).offset();
            break;
        case ProcedureKind::drive_force:
            in_force_ = true;
            monitor_.finish();
            break;
        case ProcedureKind::none:
            break;
    }
}

/// What the drive itself has to notice, in each period.
void XenaxDrive::supervise() {
    forget_what_is_over();
    supervise_safety();
    const Heat& heat = axis_.heat();
    const bool hot = heat.winding() > axis_.kind().temperature_limit;
    const bool stage_hot = heat.power_stage() > highest_stage_temperature;
    const bool off = machine_.state() == Ds402::State::fault || machine_.state() == Ds402::State::fault_reaction_active;
    if (machine_.state() == Ds402::State::fault_reaction_active) {
        const bool stands = !axis_.moving() && std::abs(axis_.velocity()) < standstill;
        if (!keeps_fault_power_ || stands || torque_is_impossible() || reaction_periods_ > longest_reaction) {
            machine_.on_event(Ds402::Event::reaction_done, *this);
        }
        return;
    }
    if (off) return;
    if (axis_.encoder_lost()) raise(xenax::message("encoder_lost"));
    if (inverter_on_ && is_under_voltage()) raise(xenax::message("under_voltage"));
    if (inverter_on_ && is_over_voltage()) raise(xenax::message("over_voltage"));
    if (inverter_on_ && power_stage_failed_) raise(xenax::message("power_stage_dropped_out"));
    if (inverter_on_ && hot) raise(xenax::message("over_temperature_motor"));
    if (inverter_on_ && stage_hot) raise(xenax::message("over_temperature_power_stage"));
    if (inverter_on_ && heat.i2t() > heat.i2t_limit()) raise(xenax::message("i2t"));
    if (signals_.emergency_exit && inverter_on_) raise(xenax::message("emergency_exit"));
    supervise_position();
}

void XenaxDrive::supervise_position() {
    if (machine_.state() != Ds402::State::operation_enabled && machine_.state() != Ds402::State::quick_stop_active)
        return;
    // A limit, whether of current or of force, makes it natural that the axis stays behind (004 §6.1.2, note).
    const bool watched = current_limit() <= 0 && measured_limit() <= 0 && axis_.settings().position_control &&
                         !(motion_ == Motion::procedure && procedure_kind_ != ProcedureKind::force_calibration);
    if (watched && std::abs(axis_.following_error()) > static_cast<double>(v_.following_error_window.get())) {
        following_failed_ = true;
        raise(xenax::message("following_error"));
        return;
    }
    if (motion_ == Motion::procedure) return;
    const double velocity = axis_.set_point().velocity;
    if (signals_.negative_limit_switch && velocity < 0) raise(xenax::message("negative_limit_switch"));
    if (signals_.positive_limit_switch && velocity > 0) raise(xenax::message("positive_limit_switch"));
    if (signals_.emergency_exit_power_on && motion_ != Motion::none && motion_ != Motion::quick_stop) {
        report(xenax::message("emergency_exit_power_on"));
        quick_stop_ramp();
    }
}

/// What a safety function forbids is an error while there is torque; without torque it only keeps the power off.
void XenaxDrive::supervise_safety() {
    if (safety_.ss2() && warning_ == nullptr) report(xenax::message("ss2"));
    if (safety_.sls() && information_ == nullptr) report(xenax::message("sls"));
    const bool torque = inverter_on_ || axis_.is_on();
    if (!torque && error_ == nullptr) safety_.forget_hits();
    if (!torque || !safety_.any()) return;
    if (safety_.ss1()) raise(xenax::message("ss1"));
    if (safety_.sto()) raise(xenax::message("sto"));
    if (safety_.ss2_hit()) raise(xenax::message("ss2_hit"));
    if (safety_.sls_speed_hit()) raise(xenax::message("sls_speed_hit"));
    const bool drives = motion_ != Motion::none && motion_ != Motion::quick_stop;
    if (safety_.ss2() && error_ == nullptr && drives) quick_stop_ramp();
}

/// A warning or an information that tells of something lasting goes when that is over.
void XenaxDrive::forget_what_is_over() {
    const auto is_over = [this](const xenax::Message* message) {
        return message != nullptr && message->persists && !cause_remains(*message);
    };
    if (is_over(warning_)) warning_ = nullptr;
    if (is_over(information_)) information_ = nullptr;
}

/// A ramp cannot be driven, whatever began it.
bool XenaxDrive::torque_is_impossible() const {
    return safety_.sto() || axis_.encoder_lost() || power_stage_failed_ || is_under_voltage() || is_over_voltage();
}

/// Rows whose value is the connected motor's (004 prints '-' for their defaults).
void XenaxDrive::tell_machine() {
    const AxisKind& kind = axis_.kind();
    const auto row = [&](auto& variable, double value) {
        const Parameter& parameter = *v_.store.find(std::remove_reference_t<decltype(variable)>::key);
        variable.set(std::clamp(rounded(value), parameter.low, parameter.high));
    };
    row(v_.stop_current, kind.nominal_current * 100);
    row(v_.motor_mass, kind.moving_mass * mass_unit(kind));
    row(v_.force_constant, kind.force_constant * 1000);
    row(v_.inductance, kind.inductance * 1e6);
    row(v_.resistance, kind.resistance * 1000);
    row(v_.friction_dynamic, kind.friction_dynamic * 1000);
    row(v_.friction_static, kind.friction_static * 1000);
    row(v_.axis_resolution, kind.motion == AxisKind::Motion::linear ? kind.increments_per_unit : 0);
    row(v_.axis_stroke, kind.motion == AxisKind::Motion::linear ? kind.travel : 0);
    if (kind.increments_per_turn > 0) row(v_.encoder_increments, kind.increments_per_turn);
    row(v_.pole_pairs, kind.pole_pairs);
    v_.store.assign(*motor_type_row_, kind.motor_type);

    const SafetySettings& safety = safety_.settings();
    v_.sls_timeout.set(safety.sls_timeout_ms);
    v_.sls_speed.set(safety.sls_speed);
    v_.safe_stop_timeout.set(safety.stop_timeout_ms);
    v_.safe_position_window.set(safety.position_window);
    v_.safety_inputs.set(0x04030201);  // STO, SS1, SS2 and SLS, a byte each (004 §3.4.6)
}

/// What the parameters make of controller, wires and sectors.
void XenaxDrive::apply_settings() {
    const AxisKind& kind = axis_.kind();
    ServoSettings& servo = axis_.settings();
    // A wrong FCM makes the controller ask for too little or too much current.
    const double told = static_cast<double>(v_.force_constant.get()) / 1000;
    const double gain = told > 0 ? kind.force_constant / told : 1;
    servo.mass = static_cast<double>(v_.motor_mass.get() + v_.payload.get()) / mass_unit(kind) * gain;
    // The axis carries what ML says, unless somebody has put something else on it.
    axis_.plant().set_payload(real_payload_.value_or(static_cast<double>(v_.payload.get()) / mass_unit(kind)));
    servo.bandwidth = static_cast<double>(v_.position_bandwidth.get());
    servo.current_bandwidth = static_cast<double>(v_.current_bandwidth.get());
    servo.friction = static_cast<double>(v_.friction_dynamic.get()) / 1000 * gain;
    servo.stop_limit = static_cast<double>(v_.stop_current.get()) / 100;
    servo.run_limit = static_cast<double>(v_.run_current.get()) / 100;
    if (measured_limit() <= 0) {
        servo.force_limit = current_limit();
        limiter_.reset();
        limiter_.release();
    }

    input_settings_.low_active = v_.input_low_active.get();
    input_settings_.low_active_mask = static_cast<std::uint16_t>(v_.input_low_active_selective.get());
    output_settings_.high_active = static_cast<std::uint8_t>(v_.output_activity.get());
    output_settings_.type = static_cast<std::uint16_t>(v_.output_type.get());
    for (std::size_t i = 0; i < io_functions; ++i) {
        input_settings_.functions[i] = {v_.input_function[i].get(),
                                        static_cast<std::int32_t>(v_.input_parameter_a[i].get()),
                                        static_cast<std::int32_t>(v_.input_parameter_b[i].get()),
                                        static_cast<std::int32_t>(v_.input_parameter_c[i].get())};
        output_settings_.functions[i] = v_.output_function[i].get();
    }
    if (!axis_.is_on()) axis_.set_brake(has_brake());

    ForceMonitorSettings sectors;
    const bool measured = v_.forceteq_mode.get() != 0 && is_75v8s_;
    for (std::size_t i = 0; i < force_sectors; ++i) {
        sectors.sectors[i] = {v_.sector_start[i].get(), v_.sector_end[i].get(),
                              measured ? v_.force_low[i].get() : v_.current_low[i].get(),
                              measured ? v_.force_high[i].get() : v_.current_high[i].get(),
                              static_cast<std::uint16_t>(v_.sector_transitions[i].get())};
    }
    sectors.selected = static_cast<std::uint16_t>(v_.sectors.get());
    sectors.offset = v_.sector_offset.get();
    monitor_.configure(sectors);
}

namespace {

template <class... Handlers>
struct Overloaded : Handlers... {
    using Handlers::operator()...;
};
template <class... Handlers>
Overloaded(Handlers...) -> Overloaded<Handlers...>;

}  // namespace

void XenaxDrive::inject(const Event& event) {
    Plant& plant = axis_.plant();
    const double units_per_mm = axis_.kind().motion == AxisKind::Motion::linear ? 1000 : 1;
    const auto encoder_offset = axis_.encoder_offset();
    std::visit(Overloaded{
                   [&](const event::PutObstacle& it) {
                       plant.set_obstacle(Obstacle{static_cast<double>(it.position) - encoder_offset,
                                                   it.stiffness * units_per_mm, it.from_above});
                   },
                   [&](const event::RemoveObstacle&) { plant.set_obstacle(std::nullopt); },
                   [&](const event::BlockAxis& it) { plant.set_blocked(it.blocked); },
                   [&](const event::SetPayload& it) {
                       real_payload_ = it.mass;
                       apply_settings();
                   },
                   [&](const event::PushAxis& it) { plant.set_external_force(it.force); },
                   [&](const event::SetInput& it) { levels_ = with_input(levels_, it.number, it.high); },
                   [&](const event::LimitSwitch& it) {
                       (it.direction == event::Direction::negative ? wired_.negative_limit_switch
                                                                   : wired_.positive_limit_switch) = it.active;
                   },
                   [&](const event::EmergencyExit& it) {
                       (it.keep_power ? wired_.emergency_exit_power_on : wired_.emergency_exit) = it.active;
                   },
                   [&](const event::SafetyStop& it) { safety_.request(it.function, it.active); },
                   [&](const event::LoseEncoder& it) {
                       axis_.set_encoder_lost(it.lost);
                       // Its counter stood still meanwhile; an absolute encoder knows where it is.
                       if (it.lost && axis_.kind().reference != AxisKind::Reference::absolute) referenced_ = false;
                   },
                   [&](const event::SetSupply& it) { axis_.set_supply_voltage(it.volts); },
                   [&](const event::SetTemperature& it) { axis_.heat().set_surroundings(it.celsius); },
                   [&](const event::TurnMaster& it) { master_speed_ = it.speed; },
                   [&](const event::CutPowerStage&) { power_stage_failed_ = inverter_on_; },
                   [&](const event::LoseController&) { lose_controller(); },
                   [](const event::PowerCycle&) {},  // the device asks for power_up()
               },
               event);
    watch_inputs();
    supervise();
    publish();
}

}  // namespace servobus::drive
