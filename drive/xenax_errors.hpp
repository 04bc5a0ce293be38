// What the seven-segment display of the XENAX says: errors, warnings and information, one table for TE, TES, 0x64/4 and
// 603Fh. The list of numbers is in the user manual of the drive, which is not among the manuals here, so all numbers
// but two are chosen (`source` tells which).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace servobus::drive::xenax {

/// PSR bits 0, 23 and 24 (004 §3.3.7). Only an error is a DS402 fault.
enum class Severity : std::uint8_t { information, warning, error };

/// What the drive does by itself when it happens.
enum class Reaction : std::uint8_t {
    none,       ///< the command is not executed; what runs goes on
    stop,       ///< decelerates with ED, the power stays on
    ramp_down,  ///< decelerates with ED, then switches the power off
    power_off,  ///< switches the power off at once: the motor cannot be controlled or must not be
};

struct Message {
    std::uint8_t number;    ///< 1 to 99, as the display shows it
    std::string_view name;  ///< an identifier: `following_error`
    std::string_view text;  ///< what TES says, at most 100 characters (004 §3.4.11)
    Severity severity;
    Reaction reaction;
    bool persists;            ///< cannot be reset while its cause is there
    std::string_view source;  ///< "000 §2.3.4.6", or that the number is chosen
};

/// What TES says while there is nothing to say (004 §3.4.11).
inline constexpr std::string_view no_error_text = "no error";
inline constexpr std::size_t longest_text = 100;

namespace detail {
inline constexpr std::string_view chosen = "chosen: the number is not in the manuals here";
}

// clang-format off
inline constexpr std::array message_table{
    // Heat and supply
    Message{10, "over_temperature_motor", "The motor winding is too hot",
            Severity::error, Reaction::ramp_down, true, detail::chosen},
    Message{11, "over_temperature_power_stage", "The power stage is too hot",
            Severity::error, Reaction::ramp_down, true, detail::chosen},
    Message{12, "i2t", "The mean current over time (I2t) is above what the motor bears",
            Severity::error, Reaction::ramp_down, true, detail::chosen},
    Message{13, "under_voltage", "The motor supply voltage is too low",
            Severity::error, Reaction::power_off, true, detail::chosen},
    Message{14, "over_voltage", "The motor supply voltage is too high",
            Severity::error, Reaction::power_off, true, detail::chosen},
    Message{15, "power_stage_dropped_out", "The power stage switched itself off",
            Severity::error, Reaction::power_off, false, detail::chosen},

    // Encoder
    Message{20, "encoder_lost", "No signal from the encoder: check its cable",
            Severity::error, Reaction::power_off, true, detail::chosen},
    Message{21, "encoder_plausibility", "The encoder signals contradict each other",
            Severity::error, Reaction::power_off, false, detail::chosen},

    // Inputs. An error of a limit switch can be reset on the switch, because the axis has to leave it.
    Message{30, "negative_limit_switch", "The negative limit switch is active",
            Severity::error, Reaction::ramp_down, false, detail::chosen},
    Message{31, "positive_limit_switch", "The positive limit switch is active",
            Severity::error, Reaction::ramp_down, false, detail::chosen},
    Message{32, "emergency_exit", "Emergency exit: the axis was stopped and the power switched off",
            Severity::error, Reaction::ramp_down, true, detail::chosen},
    Message{33, "emergency_exit_power_on", "Emergency exit: the axis was stopped, the power remains on",
            Severity::warning, Reaction::stop, true, detail::chosen},

    // Reference and force calibration
    Message{40, "reference_missing", "The axis has no reference yet: run REF before this motion",
            Severity::warning, Reaction::none, false, detail::chosen},
    Message{41, "reference_mark_not_found", "Reference failed: no reference mark on the way",
            Severity::error, Reaction::ramp_down, false, detail::chosen},
    Message{42, "reference_sensor_not_found", "Reference failed: the reference sensor did not become active",
            Severity::error, Reaction::ramp_down, false, detail::chosen},
    Message{43, "mechanical_limit_not_found", "No mechanical limit on the way",
            Severity::error, Reaction::ramp_down, false, detail::chosen},
    Message{45, "force_calibration_failed", "The force calibration could not be completed",
            Severity::error, Reaction::ramp_down, false, detail::chosen},
    Message{46, "drift_compensation_failed", "The drift compensation of I_Force could not be completed",
            Severity::error, Reaction::ramp_down, false, detail::chosen},

    // Motion. The ramp begins where the axis is and with the speed it has; after it the power is off, and PWC brings
    // it back (004 §4.2.7).
    Message{50, "following_error", "Following error: the position deviation is larger than DP allows",
            Severity::error, Reaction::ramp_down, false, "000 §2.3.4.6, 004 §4.2.7"},
    Message{59, "motor_type_mismatch", "Another motor type than the stored one is connected: RESM accepts it",
            Severity::error, Reaction::power_off, true, "a public driver of the drive; not in the manuals here"},

    // Safety functions (004 §3.3.7, bits 16 to 22)
    Message{70, "sto", "Safe torque off is requested",
            Severity::error, Reaction::power_off, true, detail::chosen},
    Message{71, "ss1", "Safe stop 1 is requested: the axis stops and the power goes off",
            Severity::error, Reaction::ramp_down, true, detail::chosen},
    Message{72, "ss2", "Safe stop 2 is requested: the axis stops and its standstill is watched",
            Severity::warning, Reaction::stop, true, detail::chosen},
    Message{73, "ss2_hit", "Safe stop 2: the axis moved while it had to stand still",
            Severity::error, Reaction::power_off, false, detail::chosen},
    Message{74, "sls", "Safely limited speed is requested",
            Severity::information, Reaction::none, true, detail::chosen},
    Message{75, "sls_speed_hit", "Safely limited speed: the axis was too fast",
            Severity::error, Reaction::ramp_down, false, detail::chosen},
    Message{76, "sls_position_hit", "Safely limited speed: the axis left its range of positions",
            Severity::error, Reaction::ramp_down, false, detail::chosen},
    Message{77, "safety_unit_not_configured", "Motion is blocked by a safety unit without configuration: see DMBUS",
            Severity::warning, Reaction::none, true, detail::chosen},

    // Commands
    Message{80, "soft_limit", "The target lies beyond a software limit: the axis stops at the limit",
            Severity::information, Reaction::none, false, detail::chosen},
    Message{81, "program_empty", "The program of this number is empty",
            Severity::warning, Reaction::none, false, detail::chosen},
    Message{82, "profile_empty", "The profile of this number is empty",
            Severity::warning, Reaction::none, false, detail::chosen},
    Message{83, "command_not_now", "The command is not possible in the present state of the drive",
            Severity::warning, Reaction::none, false, detail::chosen},
    Message{84, "jog_in_gantry", "Jog is not possible in a gantry",
            Severity::warning, Reaction::none, false, detail::chosen},
};
// clang-format on

/// The message of a number or of a name, or nullptr.
[[nodiscard]] constexpr const Message* find_message(std::int64_t number) {
    const auto found = std::ranges::find(message_table, number, &Message::number);
    return found == message_table.end() ? nullptr : &*found;
}
[[nodiscard]] constexpr const Message* find_message(std::string_view name) {
    const auto found = std::ranges::find(message_table, name, &Message::name);
    return found == message_table.end() ? nullptr : &*found;
}

/// The message that the program itself means: a wrong name does not compile.
[[nodiscard]] consteval const Message& message(std::string_view name) { return *find_message(name); }

/// TESM tells it as well.
[[nodiscard]] constexpr bool is_of_safety_unit(const Message& message) {
    return message.number >= 70 && message.number <= 79;
}

/// What TES says about a number: its text, "no error" for 0, and one sentence for what the table does not have.
[[nodiscard]] std::string_view error_text(std::int64_t number);

/// 603Fh: 0xFF00 + number, 0 without one (004 §4.2.1, whose "0xFF01..99" is read as decimal).
[[nodiscard]] constexpr std::uint16_t error_code(std::uint8_t number) {
    return number == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(0xFF00U + number);
}

/// `a` is shown rather than `b`: the more severe; of equals the first to happen, so false.
[[nodiscard]] constexpr bool outranks(const Message& a, const Message& b) { return a.severity > b.severity; }

}  // namespace servobus::drive::xenax
