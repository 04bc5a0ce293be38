#include "scanner/axis_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "drive/lookup.hpp"
#include "drive/value_names.hpp"
#include "drive/xenax.hpp"

namespace servobus::scanner {
namespace {

/// In the order of AxisValue.
constexpr std::array<std::string_view, axis_value_count> row_names{
    "drive.Controlword",
    "drive.Statusword",
    "drive.ModesOfOperationRequested",
    "drive.ModesOfOperationDisplayed",
    "drive.PositionActualValue",
    "drive.TargetPositionOrDistance",
    "drive.ActualPositionFollowingError",
    "command.TellVelocity",
    "drive.MotorCurrentActualValue",
    "general.IForceActual",
    "general.XENAXErrorNumber",
    "TellErrorString",
    "general.ProcessStatusRegisterXENAX",
    "command.TellReferenceState",
    "drive.DigitalInputsXENAX",
    "drive.DigitalOutputsXENAX",
    "command.TellTemperature",
    "command.TellVoltagePowerSupplyMotor",
    "general.MotorType",
    "drive.SpeedJogOrProfilePositionMode",
    "drive.AccelerationJogOrProfilePositionMode",
    "general.SCurve",
    "command.SpeedOverride",
    "drive.DecelerationQuickStop",
    "drive.FollowingPositionErrorWindow",
    "drive.TargetPositionWindow",
    "drive.ReferenceMethods",
    "drive.ReferenceSpeedForExternalReferenceSensor",
    "drive.ReferenceSpeedForInternalZMark",
    "command.EncoderIncrements",
    "command.Position",
    "command.Way",
    "command.DirectCommands",
};

std::array<const drive::Parameter*, axis_value_count> find_rows() {
    std::array<const drive::Parameter*, axis_value_count> rows{};
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto found = drive::find_by_name(drive::parameters(), drive::parameter_classes(), row_names[i]);
        assert(found.size() == 1);
        rows[i] = found.front();
    }
    return rows;
}

// clang-format off
constexpr std::array control_table{  // 004 §4.2.2
    BitText{0, {}, "switch on"},
    BitText{1, {}, "enable voltage"},
    BitText{2, {}, "no quick stop"},
    BitText{3, {}, "enable operation"},
    BitText{4, mode::reference, "start reference"},
    BitText{4, mode::profile_position, "new position"},
    BitText{4, mode::cyclic_position, "start moving"},
    BitText{4, mode::jog, "start jog"},
    BitText{6, mode::profile_position, "relative distance"},
    BitText{6, mode::jog, "positive direction"},
    BitText{7, {}, "fault reset"},
    BitText{8, {}, "halt"},
};

constexpr std::array status_table{  // 004 §4.2.3; bit 13 also 000 §2.3.4.2
    BitText{0, {}, "ready to switch on"},
    BitText{1, {}, "switched on"},
    BitText{2, {}, "operation enabled"},
    BitText{3, {}, "fault"},
    BitText{4, {}, "voltage enabled"},
    BitText{5, {}, "no quick stop"},
    BitText{6, {}, "switch on disabled"},
    BitText{7, {}, "warning"},
    BitText{9, {}, "remote"},
    BitText{10, mode::profile_position, "target position reached"},
    BitText{10, mode::cyclic_position, "target position reached"},
    BitText{10, mode::jog, "constant speed reached"},
    BitText{10, mode::reference, "reference performed"},
    BitText{11, {}, "soft limit position reached"},
    BitText{12, mode::reference, "reference achieved"},
    BitText{12, mode::profile_position, "moving to target position acknowledged"},
    BitText{12, mode::cyclic_position, "target position used for control loop"},
    BitText{12, mode::jog, "speed is 0"},
    BitText{13, mode::reference, "reference error"},
    BitText{13, mode::profile_position, "following position error"},
    BitText{13, mode::cyclic_position, "following position error"},
    BitText{13, mode::jog, "following position error"},
};

constexpr std::array process_table{  // 004 §3.3.7
    BitText{0, {}, "error"},
    BitText{1, {}, "reference"},
    BitText{2, {}, "in motion"},
    BitText{3, {}, "in position"},
    BitText{4, {}, "end of program"},
    BitText{5, {}, "in force"},
    BitText{6, {}, "in sector"},
    BitText{7, {}, "force in sector"},
    BitText{8, {}, "inverter voltage"},
    BitText{9, {}, "end of gantry init"},
    BitText{10, {}, "negative limit switch"},
    BitText{11, {}, "positive limit switch"},
    BitText{12, {}, "emergency exit, power remains on"},
    BitText{13, {}, "emergency exit, power off"},
    BitText{14, {}, "force calibration active"},
    BitText{15, {}, "I_Force limit reached"},
    BitText{16, {}, "STO primed or hit"},
    BitText{17, {}, "SS1 primed or hit"},
    BitText{18, {}, "SS2 primed"},
    BitText{19, {}, "SS2 hit"},
    BitText{20, {}, "SLS primed"},
    BitText{21, {}, "SLS speed hit"},
    BitText{22, {}, "SLS position hit"},
    BitText{23, {}, "warning"},
    BitText{24, {}, "information"},
    BitText{25, {}, "phasing done"},
    BitText{26, {}, "I_Force drift compensation active"},
    BitText{27, {}, "force limit reached"},
};

constexpr std::array input_table{  // 004 §4.2.26
    BitText{0, {}, "negative limit switch"},
    BitText{1, {}, "positive limit switch"},
    BitText{3, {}, "interlock"},
    BitText{16, {}, "input 1"}, BitText{17, {}, "input 2"}, BitText{18, {}, "input 3"}, BitText{19, {}, "input 4"},
    BitText{20, {}, "input 5"}, BitText{21, {}, "input 6"}, BitText{22, {}, "input 7"}, BitText{23, {}, "input 8"},
    BitText{24, {}, "input 9"}, BitText{25, {}, "input 10"}, BitText{26, {}, "input 11"}, BitText{27, {}, "input 12"},
};

constexpr std::array output_table{  // 004 §4.2.27
    BitText{0, {}, "brake"},
    BitText{16, {}, "output 1"}, BitText{17, {}, "output 2"}, BitText{18, {}, "output 3"}, BitText{19, {}, "output 4"},
    BitText{20, {}, "output 5"}, BitText{21, {}, "output 6"}, BitText{22, {}, "output 7"}, BitText{23, {}, "output 8"},
};
// clang-format on

std::string bit_text(std::span<const BitText> bits, int bit, int mode) {
    for (const auto& row : bits) {
        if (row.bit == bit && (!row.mode || *row.mode == mode)) return std::string(row.text);
    }
    return fmt::format("bit {}", bit);
}

}  // namespace

const drive::Parameter& row_of(AxisValue which) {
    static const auto rows = find_rows();
    return *rows[static_cast<std::size_t>(which)];
}

std::int64_t AxisState::number(AxisValue which) const {
    const auto& value = values_[static_cast<std::size_t>(which)];
    const auto* number = value ? std::get_if<std::int64_t>(&*value) : nullptr;
    return number == nullptr ? 0 : *number;
}

std::string_view AxisState::text(AxisValue which) const {
    const auto& value = values_[static_cast<std::size_t>(which)];
    const auto* text = value ? std::get_if<std::string>(&*value) : nullptr;
    return text == nullptr ? std::string_view() : *text;
}

// On this bus the words are signed.
std::uint16_t AxisState::status_word() const { return static_cast<std::uint16_t>(number(AxisValue::status_word)); }
std::uint32_t AxisState::process_status() const {
    return static_cast<std::uint32_t>(number(AxisValue::process_status));
}
std::uint32_t AxisState::inputs() const { return static_cast<std::uint32_t>(number(AxisValue::inputs)); }
std::uint32_t AxisState::outputs() const { return static_cast<std::uint32_t>(number(AxisValue::outputs)); }

bool AxisState::has_fault() const { return (status_word() & status_bit::fault) != 0; }
bool AxisState::is_referenced() const { return (process_status() & process_bit::reference) != 0; }

std::string_view mode_text(int mode) {
    const auto known = drive::name_of(drive::mode_names(), mode);
    return known.empty() ? "unknown mode" : known;
}

std::string_view reference_method_text(std::int64_t method) {
    return drive::name_of(drive::reference_method_names(), method);
}

std::span<const BitText> control_bits() { return control_table; }
std::span<const BitText> status_bits() { return status_table; }
std::span<const BitText> process_bits() { return process_table; }
std::span<const BitText> input_bits() { return input_table; }
std::span<const BitText> output_bits() { return output_table; }

std::vector<std::string> set_bits(std::span<const BitText> bits, std::uint32_t word, int mode) {
    std::vector<std::string> texts;
    for (int bit = 0; bit < 32; ++bit) {
        if ((word >> bit & 1U) != 0) texts.push_back(bit_text(bits, bit, mode));
    }
    return texts;
}

std::string_view state_text(const AxisState& state) {
    const auto known = state.ds402();
    return known ? drive::Ds402::name(*known) : "no known state";
}

std::string error_text(const AxisState& state) {
    const auto number = state.number(AxisValue::error);
    if (number == 0) return {};
    const auto text = state.text(AxisValue::error_text);
    return text.empty() ? fmt::format("{}", number) : fmt::format("{}: {}", number, text);
}

std::string situation(const AxisState& state) {
    const auto error = error_text(state);
    const auto where = fmt::format("in '{}'", state_text(state));
    return error.empty() ? where : fmt::format("{} with error {}", where, error);
}

}  // namespace servobus::scanner
