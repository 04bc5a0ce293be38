// What a field says, by the forms that the format has for it (R-EDS-1). Nullopt: it is not of that form, or empty.
#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "cip/bytes.hpp"
#include "eds/document.hpp"

namespace servobus::eds {

/// A value of a parameter's type; monostate where the sheet names none. Whole numbers that only fit ULINT or LWORD are
/// here as their 64 bits, that is negative.
using Value = std::variant<std::monostate, std::int64_t, double, std::string>;

/// Decimal, 0x hex or 0b binary, with or without a sign, inside 64 bits.
[[nodiscard]] std::optional<std::int64_t> integer(const Field& field);
/// The same inside `T`, without wrapping around.
template <class T>
[[nodiscard]] std::optional<T> integer_as(const Field& field) {
    const auto number = integer(field);
    if (!number || *number < 0 || static_cast<std::uint64_t>(*number) > std::numeric_limits<T>::max())
        return std::nullopt;
    return static_cast<T>(*number);
}
/// An integer, or a decimal fraction: `.004`, `1.5e3`.
[[nodiscard]] std::optional<double> real(const Field& field);
/// The characters of a string; nullopt for a word.
[[nodiscard]] std::optional<std::string> text(const Field& field);

/// `1.0` as {1, 0}.
struct Revision {
    std::uint8_t major = 0;
    std::uint8_t minor = 0;
    friend bool operator==(const Revision&, const Revision&) = default;
};
[[nodiscard]] std::optional<Revision> revision(const Field& field);
/// mm-dd-yyyy. Two digits of a year are of 1994 to 2093: the format is of 1994.
[[nodiscard]] std::optional<std::chrono::year_month_day> date(const Field& field);
/// hh:mm:ss, as seconds of the day.
[[nodiscard]] std::optional<std::chrono::seconds> time_of_day(const Field& field);

/// The number of a reference or keyword: 12 of `Param12` for the prefix `Param`; case does not count.
[[nodiscard]] std::optional<std::uint32_t> number_behind(std::string_view prefix, std::string_view word);
[[nodiscard]] std::optional<std::uint32_t> parameter_reference(const Field& field);

}  // namespace servobus::eds
