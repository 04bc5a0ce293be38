// What the File object of a configured drive hands out.
#pragma once

#include <filesystem>
#include <variant>

#include "adapter/config.hpp"
#include "adapter/device_files.hpp"
#include "adapter/text_file.hpp"

namespace servobus::adapter {

/// A file read whole, under its own name. Of a data sheet the revision is the one that it says itself.
[[nodiscard]] std::variant<DeviceFile, FileError> load_device_file(const std::filesystem::path& path);

/// The data sheet that describes the configured drive, and its icon.
[[nodiscard]] DeviceFiles generated_files(const Config& config);

}  // namespace servobus::adapter
