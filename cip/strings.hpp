// The string types of CIP (R-TYP-4, R-TYP-6).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cip/data_types.hpp"
#include "cip/wire.hpp"

namespace servobus::cip {

/// STRING: UINT count, then the characters. The caller keeps the text at 65535 characters or fewer.
void write_string(Writer& writer, std::string_view text);
[[nodiscard]] std::string read_string(Reader& reader);

/// SHORT_STRING: USINT count, then the characters; a longer text is cut at 255.
void write_short_string(Writer& writer, std::string_view text);
[[nodiscard]] std::string read_short_string(Reader& reader);

/// One string of a STRINGI.
struct InternationalString {
    std::string language = "eng";            ///< three characters
    DataType type = DataType::SHORT_STRING;  ///< STRING or SHORT_STRING here
    std::uint16_t character_set = 4;         ///< 4 = ISO 8859-1
    std::string text;

    friend bool operator==(const InternationalString&, const InternationalString&) = default;
};

/// STRINGI: USINT count, then the strings. Reading fails on a string type with wide characters.
void write_stringi(Writer& writer, const std::vector<InternationalString>& strings);
[[nodiscard]] std::vector<InternationalString> read_stringi(Reader& reader);

}  // namespace servobus::cip
