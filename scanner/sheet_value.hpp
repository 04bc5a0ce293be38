// Values of a data sheet's parameters as people read and write them: scaling, units, names of values (R-EDS-5).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "cip/bytes.hpp"
#include "cip/data_types.hpp"
#include "eds/data_sheet.hpp"
#include "scanner/mistake.hpp"

namespace servobus::scanner {

/// The value that is in all of `octets`; nullopt when their number is not that of the parameter, or its type is none
/// that can be read.
[[nodiscard]] std::optional<eds::Value> decode(const eds::Parameter& parameter, cip::ByteView octets);
/// Octets of the value in front of `data`, which may be longer; nullopt when nothing tells.
[[nodiscard]] std::optional<std::size_t> value_octets(const eds::Parameter& parameter, cip::ByteView data);

/// For people, in the units of the sheet but without them: `12.5`, `1 (Profile position)`, `0x0637 (1591)`.
[[nodiscard]] std::string value_text(const eds::Parameter& parameter, const eds::Value& value);
/// The number for programs: engineering where the sheet scales. Texts as they are; nullopt for no value at all.
[[nodiscard]] eds::Value engineering(const eds::Parameter& parameter, const eds::Value& value);

/// The value that a person typed, in the same units; 0x hex and 0b binary are the bits as they are sent. Names of values
/// are understood. The result fits the parameter's type; limits are not looked at.
[[nodiscard]] Parsed<eds::Value> parse_value(const eds::Parameter& parameter, std::string_view text);

/// Whether the limits of the sheet let a value pass; of a text they are about its characters.
[[nodiscard]] bool within_limits(const eds::Parameter& parameter, const eds::Value& value);
/// `1 to 100 %`, `at most 32 characters`; empty when the sheet has no limits.
[[nodiscard]] std::string limits_text(const eds::Parameter& parameter);

/// `UINT`; `type 0xA0` where it has no name.
[[nodiscard]] std::string type_name(cip::DataType type);

}  // namespace servobus::scanner
