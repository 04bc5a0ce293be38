// A scenario: a JSON file that says what happens to the drive, and when.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <variant>

#include "adapter/text_file.hpp"
#include "adapter/timetable.hpp"

namespace servobus::adapter {

inline constexpr std::size_t max_scenario_events = 10'000;
inline constexpr double max_scenario_seconds = 2'678'400;  ///< 31 days
inline constexpr double min_scenario_period_seconds = 0.1;

/// `text` is the file's content. Events need not stand in the order of their times; those of one time happen in the
/// order in which they stand.
[[nodiscard]] std::variant<Timetable, FileError> parse_scenario(const std::string& text);
[[nodiscard]] std::variant<Timetable, FileError> load_scenario(const std::filesystem::path& file);

}  // namespace servobus::adapter
