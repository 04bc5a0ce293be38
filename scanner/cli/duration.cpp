#include "scanner/cli/duration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

namespace servobus::scanner::cli {

Parsed<std::chrono::microseconds> parse_duration(std::string_view text) {
    static constexpr std::array<std::pair<std::string_view, double>, 5> units{
        {{"", 1e6}, {"s", 1e6}, {"ms", 1e3}, {"us", 1}, {"min", 60e6}}};
    constexpr double day = 86'400e6;
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const std::string_view unit(end, static_cast<std::size_t>(text.data() + text.size() - end));
    const auto* row = std::ranges::find(units, unit, &decltype(units)::value_type::first);
    if (error == std::errc() && row != units.end() && std::isfinite(number)) {
        const double count = number * row->second;
        if (count >= 1 && count <= day) return std::chrono::microseconds(std::llround(count));
    }
    return Mistake{fmt::format("'{}' is no time; write it as 2s, 500ms or 0.5s", text)};
}

}  // namespace servobus::scanner::cli
