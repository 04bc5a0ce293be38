// A firmware image in a file.
#pragma once

#include <filesystem>
#include <string>
#include <variant>

#include "adapter/flash_image.hpp"

namespace servobus::adapter {

/// The text says what is wrong with it, and begins with the name of the file.
[[nodiscard]] std::variant<FlashImage, std::string> load_flash(const std::filesystem::path& file);

}  // namespace servobus::adapter
