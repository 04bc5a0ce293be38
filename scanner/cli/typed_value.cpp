#include "scanner/cli/typed_value.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "cip/hex.hpp"
#include "cip/strings.hpp"
#include "cip/wire.hpp"
#include "drive/text.hpp"

namespace servobus::scanner::cli {
namespace {

enum class Kind : std::uint8_t { octets, boolean, signed_integer, unsigned_integer, real, string, short_string };

struct TypeRow {
    std::string_view name;
    Kind kind;
    std::size_t size = 0;  ///< octets of a number
};

constexpr auto types = std::to_array<TypeRow>({
    {"HEX", Kind::octets},
    {"BOOL", Kind::boolean, 1},
    {"SINT", Kind::signed_integer, 1},
    {"INT", Kind::signed_integer, 2},
    {"DINT", Kind::signed_integer, 4},
    {"LINT", Kind::signed_integer, 8},
    {"USINT", Kind::unsigned_integer, 1},
    {"UINT", Kind::unsigned_integer, 2},
    {"UDINT", Kind::unsigned_integer, 4},
    {"ULINT", Kind::unsigned_integer, 8},
    {"BYTE", Kind::unsigned_integer, 1},
    {"WORD", Kind::unsigned_integer, 2},
    {"DWORD", Kind::unsigned_integer, 4},
    {"LWORD", Kind::unsigned_integer, 8},
    {"REAL", Kind::real, 4},
    {"LREAL", Kind::real, 8},
    {"STRING", Kind::string},
    {"SHORT_STRING", Kind::short_string},
});

bool same_word(std::string_view a, std::string_view b) {
    return std::ranges::equal(
        a, b, {}, [](unsigned char c) { return std::toupper(c); }, [](unsigned char c) { return std::toupper(c); });
}

const TypeRow* find_type(std::string_view text) {
    const auto colon = text.find(':');
    if (colon == std::string_view::npos) return nullptr;
    const auto name = text.substr(0, colon);
    const auto found = std::ranges::find_if(types, [&](const TypeRow& row) { return same_word(row.name, name); });
    return found != types.end() ? &*found : nullptr;
}

Mistake misfit(const TypeRow& type, std::string_view text, std::string_view why) {
    return {fmt::format("'{}' is no {}: {}", text, type.name, why)};
}

cip::Bytes little_endian(std::uint64_t raw, std::size_t size) {
    cip::Bytes octets;
    for (; size > 0; --size, raw >>= 8) octets.push_back(static_cast<std::uint8_t>(raw));
    return octets;
}

Parsed<cip::Bytes> integer(const TypeRow& type, std::string_view text) {
    const auto number = drive::parse_number(text);
    if (!number) return misfit(type, text, "it is no number (decimal, 0x hex or 0b binary)");
    const bool is_signed = type.kind == Kind::signed_integer;
    const auto bits = static_cast<unsigned>(8 * type.size);
    // drive::parse_number ends at 63 bits, so larger unsigned values are written with hex:.
    const auto highest = bits == 64 ? INT64_MAX : (std::int64_t{1} << (is_signed ? bits - 1 : bits)) - 1;
    const auto lowest = is_signed ? -highest - 1 : 0;
    if (*number < lowest || *number > highest) {
        return misfit(type, text, fmt::format("it holds {} to {}", lowest, highest));
    }
    return little_endian(static_cast<std::uint64_t>(*number), type.size);
}

Parsed<cip::Bytes> boolean(const TypeRow& type, std::string_view text) {
    if (text == "1" || same_word(text, "TRUE")) return cip::Bytes{1};
    if (text == "0" || same_word(text, "FALSE")) return cip::Bytes{0};
    return misfit(type, text, "it is 0 or 1");
}

Parsed<cip::Bytes> real(const TypeRow& type, std::string_view text) {
    const std::string copy(text);
    char* end = nullptr;
    const double number = std::strtod(copy.c_str(), &end);
    if (copy.empty() || end != copy.c_str() + copy.size()) return misfit(type, text, "it is no number");
    if (type.size == sizeof(double)) return little_endian(std::bit_cast<std::uint64_t>(number), sizeof(double));
    return little_endian(std::bit_cast<std::uint32_t>(static_cast<float>(number)), sizeof(float));
}

Parsed<cip::Bytes> characters(const TypeRow& type, std::string_view text) {
    const std::size_t most = type.kind == Kind::string ? 0xFFFF : 0xFF;
    if (text.size() > most) return misfit(type, text, fmt::format("it holds at most {} characters", most));
    cip::Bytes octets;
    cip::Writer writer(octets);
    if (type.kind == Kind::string) {
        cip::write_string(writer, text);
    } else {
        cip::write_short_string(writer, text);
    }
    return octets;
}

}  // namespace

bool has_type(std::string_view text) { return find_type(text) != nullptr; }

Parsed<cip::Bytes> parse_typed(std::string_view text) {
    const auto* type = find_type(text);
    if (type == nullptr) return Mistake{fmt::format("'{}' has no type: write DINT:50 or hex:32 00", text)};
    const auto value = text.substr(text.find(':') + 1);
    switch (type->kind) {
        case Kind::octets: {
            auto octets = cip::from_hex(value);
            if (!octets) return misfit(*type, value, "it is made of pairs of hex digits");
            return std::move(*octets);
        }
        case Kind::boolean:
            return boolean(*type, value);
        case Kind::signed_integer:
        case Kind::unsigned_integer:
            return integer(*type, value);
        case Kind::real:
            return real(*type, value);
        case Kind::string:
        case Kind::short_string:
            return characters(*type, value);
    }
    return Mistake{"unknown type"};
}

}  // namespace servobus::scanner::cli
