// The XENAX as a machine: what its parameters, commands and control words make an axis do, and what it tells about it.
// The pieces stand in files of their own (ds402, axis, reference_drive, force_monitor, ...); this one joins them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "drive/axis.hpp"
#include "drive/behaviour.hpp"
#include "drive/device.hpp"
#include "drive/digital_io.hpp"
#include "drive/ds402.hpp"
#include "drive/force_limiter.hpp"
#include "drive/force_monitor.hpp"
#include "drive/mode.hpp"
#include "drive/position_capture.hpp"
#include "drive/position_trigger.hpp"
#include "drive/procedure.hpp"
#include "drive/safety.hpp"
#include "drive/xenax_errors.hpp"
#include "drive/xenax_variables.hpp"

namespace servobus::drive {

class XenaxDrive final : public Behaviour, private Ds402::Listener {
public:
    XenaxDrive(const Model& model, Store& store, const Machine& machine);
    [[nodiscard]] static std::unique_ptr<Behaviour> make(const Model& model, Store& store, const Machine& machine);

    [[nodiscard]] std::optional<Refusal> check(const Parameter& row, const Value& value) const override;
    void written(const Parameter& row) override;
    void step(Time now) override;
    [[nodiscard]] std::optional<Time> next_deadline() const override;
    void inject(const Event& event) override;
    [[nodiscard]] OutputLevel output_wire(int number) const override;
    void tell_machine() override;
    void power_up() override;
    [[nodiscard]] bool has_fault() const override;

    // For tests and for people who look inside.
    [[nodiscard]] const Axis& axis() const { return axis_; }
    [[nodiscard]] Ds402::State state() const { return machine_.state(); }

private:
    /// What the axis is doing, as far as commands have to know.
    enum class Motion : std::uint8_t {
        none,
        positioning,  ///< to a target, in profile position mode or by a direct command
        jog,
        stopping,  ///< halt, or the end of a jog
        quick_stop,
        following,    ///< cyclic synchronous position
        synchronous,  ///< in step with a master (SR)
        procedure,
    };
    enum class ProcedureKind : std::uint8_t {
        none,
        reference,
        limit_stop,
        limit_calibration,
        force_calibration,
        drift_compensation,
        drive_force,
    };
    /// What a direct command or a set-only row wants a motion to be like.
    struct Move {
        double target = 0;  ///< increments, absolute
        double speed = 0;   ///< as programmed: the override comes on top
        double acceleration = 0;
    };

    // Ds402::Listener
    [[nodiscard]] bool allows(const Ds402::Transition& transition) override;
    void happened(const Ds402::Transition& transition) override;

    // xenax_drive.cpp: time
    void period();
    void run_procedure();
    void end_procedure(Procedure::Progress progress);
    [[nodiscard]] const xenax::Message& failure_of(ProcedureKind kind) const;
    void take_result(ProcedureKind kind, const Procedure& procedure);
    void after_motion();
    void watch_target_window();
    void watch_inputs();
    void sample();
    [[nodiscard]] bool idle() const;
    [[nodiscard]] bool target_settled() const;
    [[nodiscard]] std::int64_t window_periods_wanted() const;
    [[nodiscard]] std::int64_t i_force_10ma() const;
    [[nodiscard]] double measured_limit() const;
    [[nodiscard]] double current_limit() const;
    [[nodiscard]] double measured_force() const;
    [[nodiscard]] double share_after_force_limit() const;
    void apply_settings();
    void supervise();
    void supervise_position();
    void supervise_safety();
    void restart();
    void forget_what_is_over();
    [[nodiscard]] bool torque_is_impossible() const;
    [[nodiscard]] std::int64_t shown_position() const;
    [[nodiscard]] ProcedureInputs procedure_inputs() const;

    // xenax_commands.cpp: when each command can be done, and what it does
    struct DirectCommands;
    struct SetCommands;

    // xenax_writes.cpp: what a bus writes
    [[nodiscard]] std::optional<Refusal> check_command(std::uint32_t number) const;
    [[nodiscard]] std::optional<Refusal> check_set_command(Key key, std::int64_t value) const;
    [[nodiscard]] std::optional<Refusal> check_motion() const;
    [[nodiscard]] std::optional<Refusal> check_force_drive(std::int64_t number, bool measured) const;
    [[nodiscard]] std::optional<Refusal> check_power_on() const;
    void execute(std::uint32_t number);
    void execute_set_command(Key key, std::int64_t value);
    void written_parameter(Key key);
    void start_index(std::int64_t number);
    void start_force_drive(std::int64_t number, bool measured);
    void on_request(const InputRequest& request);
    void reset_parameters();
    void reset_motor_parameters();

    /// What follows from a write that has been checked.
    void take(const Parameter& row);

    // xenax_program.cpp: motions that follow from one another
    void begin_program(std::int64_t number);
    void begin_profile(std::int64_t number);
    bool next_profile_part();
    void run_program();
    [[nodiscard]] bool execute(const ProgramStep& step);
    [[nodiscard]] double override_share() const;
    void follow_master();

    // xenax_modes.cpp: control word and modes
    void on_control_word(std::uint16_t word);
    void start_in_mode(std::uint16_t word, std::uint16_t rising, std::uint16_t falling);
    void new_set_point(bool relative);
    void update_jog();
    void update_following(bool on);
    void on_new_target();
    void change_mode_if_standing();
    void begin_move(const Move& move);
    void begin_jog(bool positive);
    void begin_stop();
    void begin_reference(int method);
    void begin_procedure(ProcedureKind kind, std::unique_ptr<Procedure> procedure);
    void begin_motion(Motion motion);
    void abort_motion();
    [[nodiscard]] bool may_move();
    [[nodiscard]] double limited(double target);
    [[nodiscard]] double set_speed() const;
    [[nodiscard]] double base_of_way() const;
    [[nodiscard]] MotionLimits limits_of(double speed, double acceleration) const;
    [[nodiscard]] bool soft_limits() const;
    void watch_soft_limits();
    [[nodiscard]] int reference_method_of_rows() const;
    [[nodiscard]] bool needs_reference() const;

    // xenax_power.cpp: power, faults, safety
    void power_on_locally();
    void brake_is_open();
    [[nodiscard]] bool is_under_voltage() const;
    [[nodiscard]] bool is_over_voltage() const;
    [[nodiscard]] bool may_be_moved() const;
    void power_off_locally();
    void enable_axis();
    void disable_axis();
    void raise(const xenax::Message& message);
    void clear_messages();
    void report(const xenax::Message& message);
    void withdraw(const xenax::Message& message);
    [[nodiscard]] bool cause_remains(const xenax::Message& message) const;
    [[nodiscard]] bool has_brake() const;
    void quick_stop_ramp();
    void lose_controller();

    // xenax_status.cpp: what it tells
    void publish();
    [[nodiscard]] std::uint16_t status_word() const;
    [[nodiscard]] std::uint16_t mode_bits() const;
    [[nodiscard]] std::uint32_t process_status() const;
    [[nodiscard]] OutputFlags output_flags() const;
    [[nodiscard]] bool in_position() const;
    [[nodiscard]] bool in_motion() const;
    void publish_force();
    void publish_inputs_and_outputs();
    void publish_messages();
    [[nodiscard]] int trajectory_state() const;

    Machine connected_;
    bool is_75v8s_;
    bool is_48v8_;
    XenaxVariables v_;
    const Parameter* error_text_row_;
    const Parameter* motor_type_row_;

    Axis axis_;
    Ds402 machine_;
    ForceMonitor monitor_;
    ForceLimiter limiter_;
    Safety safety_;
    PositionCapture capture_;
    PositionTrigger trigger_;
    DigitalOutputs outputs_;
    InputTracking tracking_;
    InputSettings input_settings_;
    OutputSettings output_settings_;

    Time clock_{};
    bool started_ = false;

    // Power
    bool referenced_ = false;
    bool phased_ = false;
    bool inverter_on_ = false;
    bool keeps_fault_power_ = false;  ///< the fault reaction still has a ramp to drive
    int reaction_periods_ = 0;
    int brake_periods_ = 0;                           ///< until the brake is open
    int power_off_periods_ = 0;                       ///< until the current goes, while the brake closes
    bool powers_on_locally_ = false;                  ///< by a command, and not by the control word
    std::optional<std::uint32_t> command_for_power_;  ///< a command that waits for the brake
    bool power_stage_failed_ = false;
    bool start_bit_is_old_ = false;  ///< bit 4 counts again when it has been 0 since the controller was lost

    // Motion
    Motion motion_ = Motion::none;
    ProcedureKind procedure_kind_ = ProcedureKind::none;
    std::unique_ptr<Procedure> procedure_;
    std::optional<Move> waiting_move_;  ///< for an override above 0
    std::optional<double> buffered_target_;
    bool jog_positive_ = true;
    std::optional<double> real_payload_;  ///< kg or kg m2, when it is not what ML says
    bool has_target_ = false;  ///< a motion has been asked for in this mode, so that its target can be reached
    bool target_reached_ = false;
    bool reference_done_ = false;    ///< status word bits 10 and 12 of reference mode
    bool reference_failed_ = false;  ///< bit 13
    bool following_failed_ = false;  ///< bit 13 of the other modes
    bool limited_ = false;           ///< bit 11
    bool in_force_ = false;
    bool force_limit_reached_ = false;
    bool calibrated_ = false;
    bool gantry_ = false;                         ///< the last reference was one of a gantry
    double force_offset_ = 0;                     ///< A that has drifted
    double measured_force_zero_ = 0;              ///< N that the load cell shows without force (CLFO)
    std::optional<double> motion_current_limit_;  ///< A, of the running force drive (IDIF, CLIF)
    std::optional<double> motion_force_limit_;    ///< N, of the running force drive (FDF, CLF)
    bool measured_limit_met_ = false;             ///< since the motion began (LFRMS)
    int window_periods_ = 0;
    std::int64_t motion_periods_ = 0;
    std::int64_t process_periods_ = 0;
    std::int64_t auto_program_periods_ = -1;

    // Programs, profiles, master
    const std::vector<ProgramStep>* program_ = nullptr;  ///< in connected_
    std::size_t program_step_ = 0;
    std::int64_t program_wait_periods_ = 0;
    bool program_paused_ = false;
    const std::vector<ProfilePart>* profile_parts_ = nullptr;  ///< in connected_
    std::size_t profile_part_ = 0;
    bool uncoupled_ = false;      ///< by SM, until SR is written again
    double master_speed_ = 0;     ///< increment/s
    double master_position_ = 0;  ///< increments
    double coupled_position_ = 0;
    double coupled_master_ = 0;
    double coupled_ratio_ = 0;

    // Wires
    std::uint16_t levels_ = 0;
    std::uint16_t seen_levels_ = 0;
    InputSignals wired_;    ///< switches that are wired without an input function
    InputSignals signals_;  ///< what is active, whoever says so

    // Messages
    const xenax::Message* error_ = nullptr;
    const xenax::Message* warning_ = nullptr;
    const xenax::Message* information_ = nullptr;
    const xenax::Message* shown_ = nullptr;
};

}  // namespace servobus::drive
