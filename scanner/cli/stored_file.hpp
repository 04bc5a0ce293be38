// Files that a verb writes for good: whole or not at all, and never over another one by accident.
#pragma once

#include <boost/system/result.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "cip/bytes.hpp"
#include "scanner/mistake.hpp"

namespace servobus::scanner::cli {

/// Under its name the file appears complete, or not. Why it could not be stored: also when one of that name is there and
/// `overwrite` is false.
[[nodiscard]] std::optional<Mistake> store_file(const std::filesystem::path& path, cip::ByteView content,
                                                bool overwrite);

/// What a device calls a file, as a name in the current directory: no path, nothing hidden, no character that a shell or
/// a terminal takes for something else. `otherwise` where nothing is left of it.
[[nodiscard]] std::string safe_file_name(std::string_view name, const std::string& otherwise);

}  // namespace servobus::scanner::cli
