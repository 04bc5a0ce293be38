// The programs and profiles of a configuration file: `"programs": {"1": ["REF", "G 10000"]}` and
// `"profiles": {"1": [{"to": 10000, "speed": 200000}, {"by": -5000}]}`.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "adapter/json_settings.hpp"
#include "drive/motion_memory.hpp"

namespace servobus::adapter {

/// `pointer` is the JSON pointer to `members`, for the place of an error.
[[nodiscard]] std::optional<FileError> read_programs(const Walk& walk, const nlohmann::json& members,
                                                     const std::string& pointer, drive::MotionMemory& memory);
[[nodiscard]] std::optional<FileError> read_profiles(const Walk& walk, const nlohmann::json& members,
                                                     const std::string& pointer, drive::MotionMemory& memory);

}  // namespace servobus::adapter
