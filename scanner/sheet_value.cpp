#include "scanner/sheet_value.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

#include "cip/hex.hpp"
#include "cip/wire.hpp"
#include "drive/text.hpp"

namespace servobus::scanner {
namespace {

using cip::DataType;
using eds::ParameterBit;
using eds::TypeKind;

constexpr auto type_names = std::to_array<std::pair<DataType, std::string_view>>({
    {DataType::BOOL, "BOOL"},
    {DataType::SINT, "SINT"},
    {DataType::INT, "INT"},
    {DataType::DINT, "DINT"},
    {DataType::LINT, "LINT"},
    {DataType::USINT, "USINT"},
    {DataType::UINT, "UINT"},
    {DataType::UDINT, "UDINT"},
    {DataType::ULINT, "ULINT"},
    {DataType::REAL, "REAL"},
    {DataType::LREAL, "LREAL"},
    {DataType::STIME, "STIME"},
    {DataType::DATE, "DATE"},
    {DataType::TIME_OF_DAY, "TIME_OF_DAY"},
    {DataType::DATE_AND_TIME, "DATE_AND_TIME"},
    {DataType::STRING, "STRING"},
    {DataType::BYTE, "BYTE"},
    {DataType::WORD, "WORD"},
    {DataType::DWORD, "DWORD"},
    {DataType::LWORD, "LWORD"},
    {DataType::STRING2, "STRING2"},
    {DataType::FTIME, "FTIME"},
    {DataType::LTIME, "LTIME"},
    {DataType::ITIME, "ITIME"},
    {DataType::STRINGN, "STRINGN"},
    {DataType::SHORT_STRING, "SHORT_STRING"},
    {DataType::TIME, "TIME"},
    {DataType::EPATH, "EPATH"},
    {DataType::ENGUNIT, "ENGUNIT"},
    {DataType::STRINGI, "STRINGI"},
});

/// More names of values than this are not listed in a message.
constexpr std::size_t names_worth_listing = 12;

bool is_bit_pattern(DataType type) {
    return type == DataType::BYTE || type == DataType::WORD || type == DataType::DWORD || type == DataType::LWORD;
}

bool is_scaled(const eds::Parameter& parameter) {
    return parameter.has(ParameterBit::scaling) && eds::kind_of(parameter.type) != TypeKind::text;
}

/// Of ULINT and LWORD the upper half does not fit the 64 bits that values have.
bool is_unsigned_64(const eds::Parameter& parameter) {
    return parameter.size == 8 && eds::kind_of(parameter.type) == TypeKind::unsigned_integer;
}

std::uint64_t little_endian(cip::ByteView octets) {
    std::uint64_t raw = 0;
    for (std::size_t i = octets.size(); i-- > 0;) raw = raw << 8 | octets[i];
    return raw;
}

std::int64_t sign_extended(std::uint64_t raw, std::size_t size) {
    const auto unused = 64 - 8 * size;
    return static_cast<std::int64_t>(raw << unused) >> unused;
}

std::string characters(cip::ByteView octets) { return {octets.begin(), octets.end()}; }

/// Octets of the count in front of the characters.
std::size_t count_octets(DataType type) { return type == DataType::SHORT_STRING ? 1 : 2; }

std::string number_text(const eds::Parameter& parameter, std::int64_t number) {
    return is_unsigned_64(parameter) ? fmt::format("{}", static_cast<std::uint64_t>(number))
                                     : fmt::format("{}", number);
}

/// As many decimals as the sheet says, or as many as it takes.
std::string real_text(const eds::Parameter& parameter, double number) {
    if (parameter.decimals > 0) return fmt::format("{:.{}f}", number, parameter.decimals);
    constexpr double exact = 1e15;
    if (std::trunc(number) == number && std::abs(number) < exact) return fmt::format("{:.0f}", number);
    return parameter.type == DataType::LREAL ? fmt::format("{}", number) : fmt::format("{:.7g}", number);
}

std::string enum_names(const eds::Parameter& parameter) {
    std::vector<std::string> names;
    for (const auto& each : parameter.enumeration) names.push_back(fmt::format("{} ({})", each.text, each.value));
    return fmt::format("{}", fmt::join(names, ", "));
}

bool has_few_names(const eds::Parameter& parameter) {
    return !parameter.enumeration.empty() && parameter.enumeration.size() <= names_worth_listing;
}

std::optional<double> parse_real(std::string_view text) {
    double number = 0;
    const auto* end = text.data() + text.size();
    if (text.starts_with('+')) text.remove_prefix(1);
    const auto [rest, error] = std::from_chars(text.data(), end, number);
    if (error != std::errc() || rest != end || !std::isfinite(number)) return std::nullopt;
    return number;
}

bool is_raw(std::string_view text) {
    if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
    return text.starts_with("0x") || text.starts_with("0X") || text.starts_with("0b") || text.starts_with("0B");
}

/// A number of ULINT that only fits unsigned.
std::optional<std::int64_t> parse_unsigned_64(std::string_view text) {
    std::uint64_t number = 0;
    const auto* end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, number);
    if (error != std::errc() || rest != end) return std::nullopt;
    return static_cast<std::int64_t>(number);
}

Mistake no_number(const eds::Parameter& parameter, std::string_view text) {
    if (has_few_names(parameter)) return {fmt::format("'{}' is none of {}", text, enum_names(parameter))};
    return {fmt::format("'{}' is no {}", text, is_scaled(parameter) ? "number" : type_name(parameter.type))};
}

/// The number that is sent for an engineering value, which has steps.
Parsed<eds::Value> unscaled(const eds::Parameter& parameter, double number, std::string_view text) {
    const double raw = parameter.from_engineering(number);
    const double whole = std::round(raw);
    constexpr double rounding = 1e-6;
    constexpr double largest = 9.2e18;
    if (!(std::abs(raw) < largest)) return Mistake{fmt::format("'{}' is too large", text)};
    if (std::abs(raw - whole) > rounding * std::max(1.0, std::abs(raw))) {
        return Mistake{fmt::format("'{}' is between two steps; {} and {} are the nearest", text,
                                   real_text(parameter, parameter.to_engineering(std::floor(raw))),
                                   real_text(parameter, parameter.to_engineering(std::ceil(raw))))};
    }
    return eds::Value(static_cast<std::int64_t>(whole));
}

Parsed<eds::Value> parse_number(const eds::Parameter& parameter, std::string_view text) {
    const bool real = eds::kind_of(parameter.type) == TypeKind::real;
    if ((real || is_scaled(parameter)) && !is_raw(text)) {
        const auto number = parse_real(text);
        if (!number) return no_number(parameter, text);
        if (real) return eds::Value(parameter.from_engineering(*number));
        return unscaled(parameter, *number, text);
    }
    if (is_unsigned_64(parameter)) {
        if (const auto number = parse_unsigned_64(text)) return eds::Value(*number);
    }
    const auto number = drive::parse_number(text);
    if (!number) return no_number(parameter, text);
    return eds::Value(*number);
}

int compare(const eds::Parameter& parameter, const eds::Value& one, const eds::Value& other) {
    const auto order = [](auto a, auto b) { return a < b ? -1 : a > b ? 1 : 0; };
    const auto* a = std::get_if<std::int64_t>(&one);
    const auto* b = std::get_if<std::int64_t>(&other);
    if (a != nullptr && b != nullptr) {
        if (!is_unsigned_64(parameter)) return order(*a, *b);
        return order(static_cast<std::uint64_t>(*a), static_cast<std::uint64_t>(*b));
    }
    const auto real = [](const eds::Value& value) {
        const auto* whole = std::get_if<std::int64_t>(&value);
        const auto* fraction = std::get_if<double>(&value);
        return whole != nullptr ? static_cast<double>(*whole) : fraction != nullptr ? *fraction : 0.0;
    };
    return order(real(one), real(other));
}

bool is_number(const eds::Value& value) {
    return std::holds_alternative<std::int64_t>(value) || std::holds_alternative<double>(value);
}

std::string limit_text(const eds::Parameter& parameter, const eds::Value& limit) {
    const auto* whole = std::get_if<std::int64_t>(&limit);
    if (whole != nullptr && !is_scaled(parameter) && eds::kind_of(parameter.type) != TypeKind::real) {
        return number_text(parameter, *whole);
    }
    const auto value = engineering(parameter, limit);
    const auto* fraction = std::get_if<double>(&value);
    const auto* number = std::get_if<std::int64_t>(&value);
    return real_text(parameter, fraction != nullptr ? *fraction : number != nullptr ? static_cast<double>(*number) : 0);
}

}  // namespace

std::string type_name(DataType type) {
    for (const auto& [code, name] : type_names) {
        if (code == type) return std::string(name);
    }
    return fmt::format("type 0x{:02X}", static_cast<unsigned>(type));
}

std::optional<std::size_t> value_octets(const eds::Parameter& parameter, cip::ByteView data) {
    const auto type = parameter.type;
    if (type == DataType::STRING || type == DataType::SHORT_STRING) {
        const auto count = count_octets(type);
        if (data.size() < count) return std::nullopt;
        return count + static_cast<std::size_t>(little_endian(data.first(count)));
    }
    if (eds::kind_of(type) == TypeKind::text) return std::nullopt;
    const auto own = eds::octets_of(type);
    return own ? own : parameter.size;
}

std::optional<eds::Value> decode(const eds::Parameter& parameter, cip::ByteView octets) {
    const auto size = value_octets(parameter, octets);
    if (parameter.type == DataType::EPATH) return eds::Value(cip::to_hex(octets));
    if (!size || *size != octets.size()) return std::nullopt;
    switch (eds::kind_of(parameter.type)) {
        case TypeKind::text:
            return eds::Value(characters(octets.subspan(count_octets(parameter.type))));
        case TypeKind::real:
            if (octets.size() == sizeof(float)) {
                const auto raw = static_cast<std::uint32_t>(little_endian(octets));
                return eds::Value(static_cast<double>(std::bit_cast<float>(raw)));
            }
            if (octets.size() != sizeof(double)) return std::nullopt;
            return eds::Value(std::bit_cast<double>(little_endian(octets)));
        case TypeKind::boolean:
        case TypeKind::unsigned_integer:
        case TypeKind::signed_integer: {
            if (octets.empty() || octets.size() > sizeof(std::int64_t)) return std::nullopt;
            const auto raw = little_endian(octets);
            const bool is_signed = eds::kind_of(parameter.type) == TypeKind::signed_integer;
            return eds::Value(is_signed ? sign_extended(raw, octets.size()) : static_cast<std::int64_t>(raw));
        }
        case TypeKind::unknown:
            break;
    }
    return std::nullopt;
}

eds::Value engineering(const eds::Parameter& parameter, const eds::Value& value) {
    if (!is_scaled(parameter)) return value;
    if (const auto* whole = std::get_if<std::int64_t>(&value)) {
        return parameter.to_engineering(is_unsigned_64(parameter)
                                            ? static_cast<double>(static_cast<std::uint64_t>(*whole))
                                            : static_cast<double>(*whole));
    }
    if (const auto* fraction = std::get_if<double>(&value)) return parameter.to_engineering(*fraction);
    return value;
}

std::string value_text(const eds::Parameter& parameter, const eds::Value& value) {
    if (const auto* text = std::get_if<std::string>(&value)) return *text;
    const auto* whole = std::get_if<std::int64_t>(&value);
    if (whole != nullptr) {
        if (const auto* name = parameter.enum_text(*whole)) {
            return fmt::format("{} ({})", number_text(parameter, *whole), *name);
        }
    }
    const auto shown = engineering(parameter, value);
    if (const auto* fraction = std::get_if<double>(&shown)) return real_text(parameter, *fraction);
    if (whole == nullptr) return {};
    if (!is_bit_pattern(parameter.type)) return number_text(parameter, *whole);
    return fmt::format("0x{:0{}X} ({})", static_cast<std::uint64_t>(*whole), 2 * parameter.size.value_or(1),
                       number_text(parameter, *whole));
}

Parsed<eds::Value> parse_value(const eds::Parameter& parameter, std::string_view text) {
    const auto kind = eds::kind_of(parameter.type);
    if (kind == TypeKind::unknown) {
        return Mistake{fmt::format("values of {} cannot be written by name; write the octets to its address",
                                   type_name(parameter.type))};
    }
    auto value = [&]() -> Parsed<eds::Value> {
        if (kind == TypeKind::text) return eds::Value(std::string(text));
        if (const auto named = parameter.enum_value(text)) return eds::Value(*named);
        return parse_number(parameter, text);
    }();
    if (value && !parameter.encode(*value)) {
        return Mistake{fmt::format("'{}' does not fit {}", text, type_name(parameter.type))};
    }
    return value;
}

bool within_limits(const eds::Parameter& parameter, const eds::Value& value) {
    const auto* text = std::get_if<std::string>(&value);
    const auto compared = text != nullptr ? eds::Value(static_cast<std::int64_t>(text->size())) : value;
    if (!is_number(compared)) return true;
    const bool above = !is_number(parameter.minimum) || compare(parameter, compared, parameter.minimum) >= 0;
    const bool below = !is_number(parameter.maximum) || compare(parameter, compared, parameter.maximum) <= 0;
    return above && below;
}

std::string limits_text(const eds::Parameter& parameter) {
    const bool low = is_number(parameter.minimum);
    const bool high = is_number(parameter.maximum);
    if (!low && !high) return {};
    if (eds::kind_of(parameter.type) == TypeKind::text) {
        const auto* most = std::get_if<std::int64_t>(&parameter.maximum);
        return most != nullptr ? fmt::format("at most {} characters", *most) : std::string();
    }
    if (has_few_names(parameter)) return enum_names(parameter);
    const auto unit = parameter.units.empty() ? std::string() : " " + parameter.units;
    if (!high) return fmt::format("from {}{}", limit_text(parameter, parameter.minimum), unit);
    if (!low) return fmt::format("up to {}{}", limit_text(parameter, parameter.maximum), unit);
    return fmt::format("{} to {}{}", limit_text(parameter, parameter.minimum), limit_text(parameter, parameter.maximum),
                       unit);
}

}  // namespace servobus::scanner
