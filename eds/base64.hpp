// Base64, as IconContents has it (RFC 4648 §4).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "cip/bytes.hpp"

namespace servobus::eds {

[[nodiscard]] std::string to_base64(cip::ByteView octets);
/// Blanks and ends of lines are skipped; padding may be left out. Nullopt for anything else.
[[nodiscard]] std::optional<cip::Bytes> from_base64(std::string_view text);

}  // namespace servobus::eds
