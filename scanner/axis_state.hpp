// A snapshot of an axis, and its words: what the modes, the states and the bits are called.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drive/ds402.hpp"
#include "drive/mode.hpp"
#include "drive/parameter.hpp"
#include "drive/store.hpp"

namespace servobus::scanner {

/// The parameters that an axis is told about and followed by. Each is one row of the drive's table.
enum class AxisValue : std::uint8_t {
    control_word,
    status_word,
    mode_requested,
    mode,
    position,
    target,
    following_error,
    velocity,
    current,
    force_current,
    error,
    error_text,
    process_status,
    reference_state,
    inputs,
    outputs,
    temperature,
    supply,
    motor_type,
    speed,
    acceleration,
    s_curve,
    speed_override,
    quick_stop_deceleration,
    following_window,
    target_window,
    reference_method,
    sensor_speed,
    z_mark_speed,
    encoder_increments,
    calibration_start,
    calibration_way,
    direct_command,
};
inline constexpr std::size_t axis_value_count = 33;

[[nodiscard]] const drive::Parameter& row_of(AxisValue which);

class AxisState {
public:
    void take(AxisValue which, drive::Value value) { values_[static_cast<std::size_t>(which)] = std::move(value); }
    [[nodiscard]] bool has(AxisValue which) const { return values_[static_cast<std::size_t>(which)].has_value(); }
    /// 0 and empty for what has not been read.
    [[nodiscard]] std::int64_t number(AxisValue which) const;
    [[nodiscard]] std::string_view text(AxisValue which) const;

    [[nodiscard]] std::uint16_t status_word() const;
    [[nodiscard]] std::uint32_t process_status() const;
    [[nodiscard]] std::uint32_t inputs() const;
    [[nodiscard]] std::uint32_t outputs() const;
    [[nodiscard]] int mode() const { return static_cast<int>(number(AxisValue::mode)); }
    [[nodiscard]] std::optional<drive::Ds402::State> ds402() const { return drive::Ds402::state_of(status_word()); }
    [[nodiscard]] bool is_enabled() const { return ds402() == drive::Ds402::State::operation_enabled; }
    [[nodiscard]] bool has_fault() const;
    [[nodiscard]] bool is_referenced() const;
    /// The connected motor says that it is a rotative one (004 §3.3.9).
    [[nodiscard]] bool is_rotative() const { return text(AxisValue::motor_type) == "rotative"; }

private:
    std::array<std::optional<drive::Value>, axis_value_count> values_{};
};

/// Bits of the words that sequences use (004 §4.2.2, §4.2.3, §3.3.7).
namespace status_bit {
inline constexpr std::uint32_t fault = 1U << 3;
inline constexpr std::uint32_t reached = 1U << 10;  ///< target position, constant speed or reference, by mode
inline constexpr std::uint32_t soft_limit = 1U << 11;
inline constexpr std::uint32_t specific = 1U << 12;  ///< motion acknowledged, speed 0 or reference achieved, by mode
inline constexpr std::uint32_t error = 1U << 13;
}  // namespace status_bit
namespace process_bit {
inline constexpr std::uint32_t reference = 1U << 1;
inline constexpr std::uint32_t in_motion = 1U << 2;
inline constexpr std::uint32_t in_position = 1U << 3;
inline constexpr std::uint32_t calibrating = 1U << 14;
}  // namespace process_bit

namespace mode = drive::mode;

/// "profile position mode"; "unknown mode" for a number that the manual does not have.
[[nodiscard]] std::string_view mode_text(int mode);

/// "start positive"; empty for a number that the manual does not have (004 §4.2.19).
[[nodiscard]] std::string_view reference_method_text(std::int64_t method);

/// What a bit means; in one mode only, where the manual says so.
struct BitText {
    int bit;
    std::optional<int> mode;
    std::string_view text;
};
[[nodiscard]] std::span<const BitText> control_bits();
[[nodiscard]] std::span<const BitText> status_bits();
[[nodiscard]] std::span<const BitText> process_bits();
[[nodiscard]] std::span<const BitText> input_bits();
[[nodiscard]] std::span<const BitText> output_bits();

/// The set bits in words, lowest first; "bit 14" where the manual has none.
[[nodiscard]] std::vector<std::string> set_bits(std::span<const BitText> bits, std::uint32_t word, int mode);

/// "Operation enabled"; "no known state" for a status word of no printed pattern.
[[nodiscard]] std::string_view state_text(const AxisState& state);
/// "in 'Fault' with error 50: following error", "in 'Switched on'".
[[nodiscard]] std::string situation(const AxisState& state);
/// "50: following error"; empty without an error.
[[nodiscard]] std::string error_text(const AxisState& state);

}  // namespace servobus::scanner
