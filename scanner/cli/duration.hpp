// Times as people type them.
#pragma once

#include <chrono>
#include <string_view>

#include "scanner/mistake.hpp"

namespace servobus::scanner::cli {

/// `2s`, `500ms`, `0.5s`, `2min`; without a unit it is seconds. More than 0, at most a day.
[[nodiscard]] Parsed<std::chrono::microseconds> parse_duration(std::string_view text);

}  // namespace servobus::scanner::cli
