// Why a drive does not do what was asked: the drive's word, before any bus's code (decision 4).
#pragma once

#include <cstdint>
#include <string_view>

namespace servobus::drive {

enum class Refusal : std::uint8_t {
    read_only,       ///< the row cannot be written
    write_only,      ///< the row cannot be read
    too_low,         ///< below the printed lower limit
    too_high,        ///< above the printed upper limit
    not_allowed,     ///< inside the limits, but not one of the listed values
    too_long,        ///< more characters than the text holds
    wrong_type,      ///< text for a number, or a number for text
    not_configured,  ///< legal, but not with this variant, motor or option (000 §2.3.2, status 0x1F/0x01)
    wrong_state,     ///< legal, but not now: no power, no reference, in motion, another mode
};

/// A short sentence without a full stop, for messages: "the parameter is read only".
[[nodiscard]] std::string_view describe(Refusal refusal);

}  // namespace servobus::drive
