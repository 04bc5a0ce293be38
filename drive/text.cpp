#include "drive/text.hpp"

#include <charconv>
#include <limits>
#include <system_error>

namespace servobus::drive {

namespace {

constexpr std::string_view blanks = " \t\r\n";

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos) {
        return {};
    }
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// The bits of a number as its type stores them: -1 in an i16 is 0xFFFF.
std::uint32_t pattern(Type type, std::int64_t number) {
    const auto mask = (std::uint64_t{1} << (8 * size_of(type))) - 1;
    return static_cast<std::uint32_t>(static_cast<std::uint64_t>(number) & mask);
}

std::string format_bits(Type type, std::int64_t number) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    const std::uint32_t bits = pattern(type, number);
    std::string text = "0x";
    for (std::size_t nibble = 2 * size_of(type); nibble-- > 0;) {
        text += digits[(bits >> (4 * nibble)) & 0xF];
    }
    return text + " (" + std::to_string(number) + ")";
}

std::string format_address(std::int64_t number) {
    const std::uint32_t bits = pattern(Type::u32, number);
    std::string text;
    for (unsigned shift = 32; shift > 0;) {
        shift -= 8;
        text += std::to_string((bits >> shift) & 0xFF);
        text += shift > 0 ? "." : "";
    }
    return text;
}

/// Four numbers of 0 to 255 with dots between them, and nothing else.
std::optional<std::int64_t> parse_address(std::string_view text) {
    std::int64_t address = 0;
    for (int byte = 0; byte < 4; ++byte) {
        const auto dot = byte < 3 ? text.find('.') : text.size();
        if (dot == std::string_view::npos || dot == 0 || dot > 3) {
            return std::nullopt;
        }
        std::uint8_t part = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + dot, part);
        if (error != std::errc{} || end != text.data() + dot) {
            return std::nullopt;
        }
        address = address * 256 + part;
        text.remove_prefix(byte < 3 ? dot + 1 : dot);
    }
    return address;
}

std::string quoted(std::string_view text) { return "'" + std::string(text) + "'"; }

/// Hands back the number as the row's type holds it; bit patterns of signed types may come unsigned.
std::variant<Value, ParseError> fit(const Parameter& row, std::int64_t number, std::string_view typed) {
    const Type type = row.cip.type;
    if (row.form != Form::number && is_signed(type) && number > highest(type) && number <= 2 * highest(type) + 1) {
        number -= 2 * (highest(type) + 1);
    }
    if (number < lowest(type) || number > highest(type)) {
        return ParseError{quoted(typed) + " does not fit into " + std::to_string(8 * size_of(type)) +
                          " bits, which hold " + std::to_string(lowest(type)) + " to " + std::to_string(highest(type))};
    }
    return Value{number};
}

}  // namespace

std::optional<std::int64_t> parse_number(std::string_view text) {
    text = trimmed(text);
    const bool negative = text.starts_with('-');
    if (negative || text.starts_with('+')) {
        text.remove_prefix(1);
    }
    int base = 10;
    if (text.starts_with("0x") || text.starts_with("0X")) {
        base = 16;
    } else if (text.starts_with("0b") || text.starts_with("0B")) {
        base = 2;
    }
    text.remove_prefix(base == 10 ? 0 : 2);

    // Unsigned, so that a second sign is no number.
    std::uint64_t size = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), size, base);
    if (error == std::errc::invalid_argument || end != text.data() + text.size()) {
        return std::nullopt;
    }
    constexpr auto largest = std::numeric_limits<std::int64_t>::max();
    const bool fits = error == std::errc{} && size <= static_cast<std::uint64_t>(largest);
    const std::int64_t number = fits ? static_cast<std::int64_t>(size) : largest;
    return negative ? -number : number;
}

std::string format(const Parameter& row, const Value& value) {
    if (const auto* characters = std::get_if<std::string>(&value)) {
        return *characters;
    }
    const std::int64_t number = std::get<std::int64_t>(value);
    switch (row.is_text() ? Form::number : row.form) {
        case Form::number:
            return std::to_string(number);
        case Form::bits:
            return format_bits(row.cip.type, number);
        case Form::ipv4:
            return format_address(number);
    }
    return std::to_string(number);
}

std::variant<Value, ParseError> parse(const Parameter& row, std::string_view text) {
    if (row.is_text()) {
        return Value{std::string(text)};
    }
    const std::string_view typed = trimmed(text);
    if (row.form == Form::ipv4) {
        if (const auto address = parse_address(typed)) {
            return fit(row, *address, typed);
        }
    }
    if (const auto number = parse_number(typed)) {
        return fit(row, *number, typed);
    }
    return ParseError{quoted(typed) + (row.form == Form::ipv4 ? " is no address like 192.168.2.100"
                                                              : " is no number (decimal, 0x hex or 0b binary)")};
}

}  // namespace servobus::drive
