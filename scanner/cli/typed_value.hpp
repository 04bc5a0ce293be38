// Values whose type is given with them: `DINT:50`, `STRING:ready`, `hex:32 00`.
#pragma once

#include <string_view>

#include "cip/bytes.hpp"
#include "scanner/mistake.hpp"

namespace servobus::scanner::cli {

/// Whether the text begins with `hex:` or the name of a type and a colon.
[[nodiscard]] bool has_type(std::string_view text);

/// The octets of such a value.
[[nodiscard]] Parsed<cip::Bytes> parse_typed(std::string_view text);

}  // namespace servobus::scanner::cli
