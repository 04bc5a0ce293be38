// Why a target refuses a Forward_Open, by its status: the typical cause of each code and what helps (R-CON-40, R-ERR-12).
// It says what holds for any device; open_doctor.hpp compares the request with what is known.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "cip/status.hpp"

namespace servobus::scanner {

struct OpenCause {
    std::uint16_t code;      ///< the extended word of general status 0x01, or the general status
    std::string_view cause;  ///< a sentence
    std::string_view next;   ///< a sentence about what to do
};

/// Ordered by code; the last is for those that the reference does not name.
[[nodiscard]] std::span<const OpenCause> extended_causes();
[[nodiscard]] std::span<const OpenCause> general_causes();

/// What the status says by its extended word when it is 0x01 and has one, otherwise by its general status. For a code
/// without a row of its own: an entry that says so.
[[nodiscard]] const OpenCause& open_cause(const cip::Status& status);

/// Whether the same request may be granted later (R-SCN-4).
[[nodiscard]] bool may_pass(const cip::Status& status);

}  // namespace servobus::scanner
