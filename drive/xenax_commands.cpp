// When each command of the XENAX can be done, and what it does: the direct commands (000 §2.3.2.1), and the rows of
// class 0x65 that can be set and not read (000 §2.3.2.2), as tables.
#include "drive/xenax_commands.hpp"

#include <algorithm>
#include <cmath>

#include "drive/force_drives.hpp"
#include "drive/reference_drive.hpp"
#include "drive/xenax_drive.hpp"

namespace servobus::drive {

namespace {

using xenax::Command;
using MaybeRefusal = std::optional<Refusal>;

// Slow enough to meet a stop without harm, increment/s and increment/s2.
constexpr double stop_search_speed = 10'000;
constexpr double search_acceleration = 200'000;
constexpr double calibration_speed = 40'000;
constexpr double drift_way = 2'000;

MaybeRefusal only_if(bool possible) { return possible ? std::nullopt : MaybeRefusal(Refusal::wrong_state); }

}  // namespace

struct XenaxDrive::DirectCommands {
    using Drive = XenaxDrive;
    struct Row {
        Command command;
        MaybeRefusal (*check)(const Drive&);
        void (*execute)(Drive&);
    };

    // Conditions
    static MaybeRefusal always(const Drive&) { return std::nullopt; }
    static MaybeRefusal motion(const Drive& drive) { return drive.check_motion(); }
    static bool stands(const Drive& drive) { return drive.motion_ == Motion::none && !drive.axis_.moving(); }
    static bool is_rotative(const Drive& drive) { return drive.axis_.kind().motion == AxisKind::Motion::rotative; }
    static MaybeRefusal reference(const Drive& drive) {
        return stands(drive) && drive.may_be_moved() ? drive.check_power_on() : Refusal::wrong_state;
    }
    static MaybeRefusal linear_reference(const Drive& drive) {
        return is_rotative(drive) ? Refusal::not_configured : reference(drive);
    }
    static MaybeRefusal linear_motion(const Drive& drive) {
        return is_rotative(drive) ? Refusal::not_configured : drive.check_motion();
    }
    static MaybeRefusal rotative_motion(const Drive& drive) {
        return is_rotative(drive) ? drive.check_motion() : Refusal::not_configured;
    }
    static MaybeRefusal rotative_power(const Drive& drive) {
        return is_rotative(drive) ? drive.check_power_on() : Refusal::not_configured;
    }
    static MaybeRefusal phased_power(const Drive& drive) {
        return drive.phased_ || is_rotative(drive) ? drive.check_power_on() : Refusal::wrong_state;
    }
    static MaybeRefusal standing_power(const Drive& drive) {
        return stands(drive) ? drive.check_power_on() : Refusal::wrong_state;
    }
    /// From one direction to the other without a stop between, as the drive takes it. In jog mode the control word
    /// decides.
    static MaybeRefusal jog(const Drive& drive) {
        if (drive.v_.mode_displayed.get() == mode::jog) return Refusal::wrong_state;
        return drive.motion_ == Motion::jog ? std::nullopt : drive.check_motion();
    }
    /// "No mode" is the first step of the sequence (004 §6.1.1).
    static MaybeRefusal calibration(const Drive& drive) {
        return drive.v_.mode_displayed.get() == mode::none ? drive.check_motion() : Refusal::wrong_state;
    }
    static MaybeRefusal test_mode(const Drive& drive) {
        const bool already = drive.axis_.is_on() && !drive.axis_.settings().position_control;
        return already ? std::nullopt : drive.check_motion();
    }
    static MaybeRefusal without_power(const Drive& drive) { return only_if(stands(drive) && !drive.axis_.is_on()); }
    static MaybeRefusal rotative_standing(const Drive& drive) {
        return is_rotative(drive) ? only_if(stands(drive)) : Refusal::not_configured;
    }
    static MaybeRefusal with_load_cell(const Drive& drive) {
        return drive.is_75v8s_ ? std::nullopt : MaybeRefusal(Refusal::not_configured);
    }

    // Effects
    /// What needs power waits for the brake.
    static bool powers_on(Drive& drive, Command command) {
        drive.power_on_locally();
        if (drive.brake_periods_ > 0) drive.command_for_power_ = static_cast<std::uint32_t>(command);
        return drive.brake_periods_ == 0;
    }
    static void limit_stop(Drive& drive) {
        if (!powers_on(drive, Command::rsto)) return;
        const bool positive = drive.v_.direction_reference.get() % 2 == 0;
        const auto end = positive ? drive.v_.mechanical_limit_positive.get() : drive.v_.mechanical_limit_negative.get();
        drive.begin_procedure(ProcedureKind::limit_stop, std::make_unique<LimitStopReference>(
                                                             positive, end, stop_search_speed, search_acceleration));
    }
    static void power_reset(Drive& drive) {
        drive.referenced_ = false;
        drive.power_on_locally();
        drive.phased_ = true;
    }
    static void move_to(Drive& drive, double target) {
        drive.begin_move(
            {target, static_cast<double>(drive.v_.speed.get()), static_cast<double>(drive.v_.acceleration.get())});
    }
    /// A quick stop is harder than this one, and in cyclic mode the controller owns the set point.
    static void stop(Drive& drive) {
        drive.program_ = nullptr;
        drive.uncoupled_ = true;
        const bool stops = drive.motion_ != Motion::none && drive.motion_ != Motion::quick_stop;
        if (stops && drive.v_.mode_displayed.get() != mode::cyclic_position) drive.begin_stop();
    }
    /// The nearest position whose place in the turn is the Z-mark's.
    static void to_z_mark(Drive& drive) {
        const double turn = drive.axis_.kind().increments_per_turn;
        const double zero = drive.axis_.kind().z_mark + drive.axis_.encoder_offset();
        const double turns = std::round((drive.base_of_way() - zero) / turn);
        drive.begin_move({zero + turns * turn,
                          static_cast<double>(std::max<std::int64_t>(drive.v_.z_mark_speed.get(), 10)),
                          static_cast<double>(drive.v_.acceleration.get())});
    }
    static void calibrate(Drive& drive, double way) {
        drive.begin_procedure(ProcedureKind::force_calibration,
                              std::make_unique<ForceCalibration>(way, calibration_speed, search_acceleration));
    }
    static void test(Drive& drive, bool compensated) {
        drive.axis_.settings().position_control = false;
        drive.axis_.settings().cogging_compensation = compensated && drive.calibrated_;
    }
    static void end_test(Drive& drive) {
        if (drive.axis_.settings().position_control) return;
        drive.axis_.settings().position_control = true;
        drive.axis_.settings().cogging_compensation = drive.calibrated_;
        if (drive.axis_.is_on()) drive.axis_.hold();
    }
    static void compensate_drift(Drive& drive, double way) {
        drive.force_offset_ = 0;
        drive.begin_procedure(ProcedureKind::drift_compensation,
                              std::make_unique<DriftCompensation>(way, calibration_speed / 4, search_acceleration));
    }
    static void clear_position(Drive& drive) {
        drive.axis_.set_position(0);
        drive.trigger_.forget_position();
    }
    static void take_sector_offset(Drive& drive) {
        drive.v_.sector_offset.set(drive.shown_position());
        drive.apply_settings();
    }

    static constexpr std::array<Row, xenax::direct_command_table.size()> rows{{
        {Command::ref, reference,
         [](Drive& drive) {
             if (powers_on(drive, Command::ref)) drive.begin_reference(drive.reference_method_of_rows());
         }},
        {Command::rsto, linear_reference, limit_stop},
        {Command::mlc, linear_motion,
         [](Drive& drive) {
             drive.begin_procedure(ProcedureKind::limit_calibration,
                                   std::make_unique<LimitCalibration>(stop_search_speed, search_acceleration));
         }},
        {Command::aref1, always, [](Drive& drive) { drive.v_.automatic_reference.set(1); }},
        {Command::pw, rotative_power, [](Drive& drive) { drive.power_on_locally(); }},
        {Command::pwc, phased_power, [](Drive& drive) { drive.power_on_locally(); }},
        {Command::pwr, standing_power, power_reset},
        {Command::pq, always, [](Drive& drive) { drive.power_off_locally(); }},
        {Command::gp, motion, [](Drive& drive) { move_to(drive, static_cast<double>(drive.v_.target.get())); }},
        {Command::gw, motion,
         [](Drive& drive) { move_to(drive, drive.base_of_way() + static_cast<double>(drive.v_.way.get())); }},
        {Command::jp, jog, [](Drive& drive) { drive.begin_jog(true); }},
        {Command::jn, jog, [](Drive& drive) { drive.begin_jog(false); }},
        {Command::sm, always, stop},
        {Command::gz, rotative_motion, to_z_mark},
        {Command::fc, calibration, [](Drive& drive) { calibrate(drive, static_cast<double>(drive.v_.way.get())); }},
        {Command::fct1, test_mode, [](Drive& drive) { test(drive, true); }},
        {Command::fct0, always, end_test},
        {Command::fct2, test_mode, [](Drive& drive) { test(drive, false); }},
        {Command::ifdcp, motion, [](Drive& drive) { compensate_drift(drive, drift_way); }},
        {Command::ifdcn, motion, [](Drive& drive) { compensate_drift(drive, -drift_way); }},
        {Command::res, without_power, [](Drive& drive) { drive.reset_parameters(); }},
        {Command::resm, without_power, [](Drive& drive) { drive.reset_motor_parameters(); }},
        {Command::clcp, always, [](Drive& drive) { drive.capture_.clear(); }},
        {Command::cp121, always, [](Drive& drive) { drive.capture_.enable(true); }},
        {Command::cp120, always, [](Drive& drive) { drive.capture_.enable(false); }},
        {Command::clpo, rotative_standing, clear_position},
        {Command::dmbus, always, [](Drive& drive) { drive.withdraw(xenax::message("safety_unit_not_configured")); }},
        {Command::start_force_monitoring, always, [](Drive& drive) { drive.monitor_.start(); }},
        {Command::finish_force_monitoring, always, [](Drive& drive) { drive.monitor_.finish(); }},
        {Command::tpso, always, take_sector_offset},
        {Command::clfo, with_load_cell, [](Drive& drive) { drive.measured_force_zero_ = drive.limiter_.measured(); }},
    }};
    /// As the table that says what each is called.
    static constexpr bool all_are_there() {
        return std::ranges::equal(
            rows, xenax::direct_command_table, {},
            [](const Row& row) { return static_cast<std::uint32_t>(row.command); }, &DirectCommand::value);
    }

    static const Row* find(std::uint32_t number) {
        const auto row = std::ranges::find(rows, static_cast<Command>(number), &Row::command);
        return row == rows.end() ? nullptr : &*row;
    }
};

std::optional<Refusal> XenaxDrive::check_command(std::uint32_t number) const {
    static_assert(DirectCommands::all_are_there());
    const auto* row = DirectCommands::find(number);
    return row == nullptr ? Refusal::not_allowed : row->check(*this);
}

void XenaxDrive::execute(std::uint32_t number) {
    if (const auto* row = DirectCommands::find(number)) row->execute(*this);
}

struct XenaxDrive::SetCommands {
    using Drive = XenaxDrive;
    /// Of class 0x65 (000 §2.3.2.2).
    enum class Attribute : std::uint16_t {
        direct_commands = 0x00,
        co = 0x29,
        evt = 0x2A,
        g = 0x2B,
        ix = 0x2C,
        pg = 0x2D,
        so = 0x2E,
        sox = 0x2F,
        tgd = 0x30,
        tgu = 0x31,
        eti = 0x32,
        dti = 0x33,
        prf = 0x34,
        crda = 0x35,
        dif = 0x36,
        clif = 0x37,
        df = 0x38,
        vmtae = 0x39,
        clf = 0x43,
    };
    struct Row {
        Attribute attribute;
        MaybeRefusal (*check)(const Drive&, std::int64_t value);
        void (*execute)(Drive&, std::int64_t value);
    };

    static MaybeRefusal always(const Drive&, std::int64_t) { return std::nullopt; }
    static MaybeRefusal motion(const Drive& drive, std::int64_t) { return drive.check_motion(); }

    static void direct(Drive& drive, std::int64_t value) { drive.execute(static_cast<std::uint32_t>(value)); }
    static void limit_current(Drive& drive, std::int64_t value) {
        drive.motion_current_limit_ = static_cast<double>(value) / 100;
        drive.apply_settings();
    }
    static void limit_force(Drive& drive, std::int64_t value) {
        drive.motion_force_limit_ = std::abs(static_cast<double>(value)) / 1000;
        drive.apply_settings();
    }
    static void calibrate(Drive& drive, std::int64_t value) {
        DirectCommands::calibrate(drive, value > 0 ? static_cast<double>(value) : drive.axis_.kind().travel / 2);
    }

    static constexpr std::array<Row, 19> rows{{
        {Attribute::direct_commands,
         [](const Drive& drive, std::int64_t value) { return drive.check_command(static_cast<std::uint32_t>(value)); },
         direct},
        {Attribute::co, always,
         [](Drive& drive, std::int64_t value) { drive.outputs_.clear(static_cast<int>(value)); }},
        {Attribute::evt, always, [](Drive& drive, std::int64_t value) { drive.tracking_.set_events(value != 0); }},
        {Attribute::g, motion,
         [](Drive& drive, std::int64_t value) { DirectCommands::move_to(drive, static_cast<double>(value)); }},
        {Attribute::ix, motion, [](Drive& drive, std::int64_t value) { drive.start_index(value); }},
        {Attribute::pg, always, [](Drive& drive, std::int64_t value) { drive.begin_program(value); }},
        {Attribute::so, always, [](Drive& drive, std::int64_t value) { drive.outputs_.set(static_cast<int>(value)); }},
        {Attribute::sox, always,
         [](Drive& drive, std::int64_t value) { drive.outputs_.set_all(static_cast<std::uint8_t>(value)); }},
        {Attribute::tgd, always, [](Drive& drive, std::int64_t value) { drive.trigger_.set_downward(value); }},
        {Attribute::tgu, always, [](Drive& drive, std::int64_t value) { drive.trigger_.set_upward(value); }},
        {Attribute::eti, always,
         [](Drive& drive, std::int64_t value) { drive.tracking_.enable(static_cast<int>(value)); }},
        {Attribute::dti, always,
         [](Drive& drive, std::int64_t value) { drive.tracking_.disable(static_cast<int>(value)); }},
        {Attribute::prf, motion, [](Drive& drive, std::int64_t value) { drive.begin_profile(value); }},
        {Attribute::crda, [](const Drive& drive, std::int64_t) { return DirectCommands::calibration(drive); },
         calibrate},
        {Attribute::dif, [](const Drive& drive, std::int64_t value) { return drive.check_force_drive(value, false); },
         [](Drive& drive, std::int64_t value) { drive.start_force_drive(value, false); }},
        {Attribute::clif, always, limit_current},
        {Attribute::df, [](const Drive& drive, std::int64_t value) { return drive.check_force_drive(value, true); },
         [](Drive& drive, std::int64_t value) { drive.start_force_drive(value, true); }},
        {Attribute::vmtae, always, [](Drive&, std::int64_t) {}},
        {Attribute::clf, always, limit_force},
    }};

    static const Row* find(Key key) {
        const auto row = std::ranges::find(rows, static_cast<Attribute>(key.attribute), &Row::attribute);
        return row == rows.end() ? nullptr : &*row;
    }
};

std::optional<Refusal> XenaxDrive::check_set_command(Key key, std::int64_t value) const {
    const auto* row = SetCommands::find(key);
    return row == nullptr ? std::nullopt : row->check(*this, value);
}

void XenaxDrive::execute_set_command(Key key, std::int64_t value) {
    if (const auto* row = SetCommands::find(key)) row->execute(*this, value);
}

}  // namespace servobus::drive
