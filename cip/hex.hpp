// Octets as hex text, for people, tests and `servobus-scanner call`.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "cip/bytes.hpp"

namespace servobus::cip {

/// `0E 03 20 64`.
[[nodiscard]] std::string to_hex(ByteView bytes);

/// Pairs of hex digits; blanks, colons and a leading 0x are skipped. Nullopt for anything else.
[[nodiscard]] std::optional<Bytes> from_hex(std::string_view text);

}  // namespace servobus::cip
