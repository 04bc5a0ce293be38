#include "eds/field_values.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <system_error>

namespace servobus::eds {
namespace {

constexpr int first_year = 1994;

template <class Number>
std::optional<Number> whole(std::string_view digits, int base = 10) {
    Number number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number, base);
    if (digits.empty() || error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
    return number;
}

// Takes a prefix like `0x` off.
bool take_prefix(std::string_view& text, char letter) {
    if (text.size() < 2 || text[0] != '0' || (text[1] | 0x20) != letter) return false;
    text.remove_prefix(2);
    return true;
}

// `12-31-2005` and `23:59:59` in three numbers.
std::optional<std::array<unsigned, 3>> three_numbers(const Field& field, char between) {
    if (field.kind != Field::Kind::word) return std::nullopt;
    std::array<unsigned, 3> numbers{};
    std::string_view rest = field.value;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const auto end = i < 2 ? rest.find(between) : rest.size();
        if (end == std::string_view::npos) return std::nullopt;
        const auto number = whole<std::uint16_t>(rest.substr(0, end));
        if (!number) return std::nullopt;
        numbers.at(i) = *number;
        rest.remove_prefix(i < 2 ? end + 1 : end);
    }
    return numbers;
}

}  // namespace

std::optional<std::int64_t> integer(const Field& field) {
    if (field.kind != Field::Kind::word) return std::nullopt;
    std::string_view digits = field.value;
    const bool negative = digits.starts_with('-');
    if (negative || digits.starts_with('+')) digits.remove_prefix(1);
    const int base = take_prefix(digits, 'x') ? 16 : take_prefix(digits, 'b') ? 2 : 10;
    const auto magnitude = whole<std::uint64_t>(digits, base);
    if (!magnitude) return std::nullopt;
    constexpr std::uint64_t most_negative = std::uint64_t{1} << 63;
    if (negative && *magnitude > most_negative) return std::nullopt;
    return static_cast<std::int64_t>(negative ? std::uint64_t{0} - *magnitude : *magnitude);
}

std::optional<double> real(const Field& field) {
    if (field.kind != Field::Kind::word) return std::nullopt;
    std::string_view digits = field.value;
    if (digits.starts_with('+')) digits.remove_prefix(1);
    double number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (error == std::errc{} && end == digits.data() + digits.size() && std::isfinite(number)) return number;
    const auto integral = integer(field);
    return integral ? std::optional<double>(static_cast<double>(*integral)) : std::nullopt;
}

std::optional<std::string> text(const Field& field) {
    return field.kind == Field::Kind::text ? std::optional(field.value) : std::nullopt;
}

std::optional<Revision> revision(const Field& field) {
    if (field.kind != Field::Kind::word) return std::nullopt;
    const std::string_view word = field.value;
    const auto dot = word.find('.');
    const auto major = whole<std::uint8_t>(word.substr(0, dot));
    const auto minor = dot == std::string_view::npos ? std::optional<std::uint8_t>(std::uint8_t{0})
                                                     : whole<std::uint8_t>(word.substr(dot + 1));
    if (!major || !minor) return std::nullopt;
    return Revision{*major, *minor};
}

std::optional<std::chrono::year_month_day> date(const Field& field) {
    const auto numbers = three_numbers(field, '-');
    if (!numbers) return std::nullopt;
    auto year = static_cast<int>((*numbers)[2]);
    if (year < 100) year += year >= first_year % 100 ? 1900 : 2000;
    const std::chrono::year_month_day day{std::chrono::year(year), std::chrono::month((*numbers)[0]),
                                          std::chrono::day((*numbers)[1])};
    return day.ok() && (*numbers)[0] < 100 && (*numbers)[1] < 100 ? std::optional(day) : std::nullopt;
}

std::optional<std::chrono::seconds> time_of_day(const Field& field) {
    const auto numbers = three_numbers(field, ':');
    if (!numbers || (*numbers)[0] > 23 || (*numbers)[1] > 59 || (*numbers)[2] > 59) return std::nullopt;
    return std::chrono::hours((*numbers)[0]) + std::chrono::minutes((*numbers)[1]) +
           std::chrono::seconds((*numbers)[2]);
}

std::optional<std::uint32_t> number_behind(std::string_view prefix, std::string_view word) {
    if (word.size() <= prefix.size() || !same_name(word.substr(0, prefix.size()), prefix)) return std::nullopt;
    return whole<std::uint32_t>(word.substr(prefix.size()));
}

std::optional<std::uint32_t> parameter_reference(const Field& field) {
    return field.kind == Field::Kind::word ? number_behind("Param", field.value) : std::nullopt;
}

}  // namespace servobus::eds
