// Values as people write and read them: decimal, 0x hex, bit patterns, IPv4 addresses, characters.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "drive/parameter.hpp"
#include "drive/store.hpp"

namespace servobus::drive {

/// Why a text is no value of a row: a sentence without a full stop.
struct ParseError {
    std::string reason;
};

/// The number that a person typed: decimal, 0x hex or 0b binary, with or without a sign; nullopt when it is none.
/// What 64 bits do not hold becomes the nearest number that they do, which no parameter takes.
[[nodiscard]] std::optional<std::int64_t> parse_number(std::string_view text);

/// The value without its unit: `20`, `0x0250 (592)` for bits, `192.168.2.100` for addresses, the characters of a text.
[[nodiscard]] std::string format(const Parameter& row, const Value& value);

/// The value that a person typed: decimal, 0x hex, 0b binary, a dotted IPv4 address for Form::ipv4, any characters
/// for a text row. Bit patterns of a signed type may be written unsigned (0x800F for an i16). The result fits the
/// row's CIP type; limits are not checked here, since the device is the one to refuse.
[[nodiscard]] std::variant<Value, ParseError> parse(const Parameter& row, std::string_view text);

}  // namespace servobus::drive
