// Files that the program reads: whole, or not at all, and what is wrong with one.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <variant>

namespace servobus::adapter {

/// Of any file that is read, but for firmware.
inline constexpr std::size_t max_file_bytes = std::size_t{1} << 20;

/// What is wrong with a file, and where: line and column count from 1, 0 when the file as a whole is meant.
struct FileError {
    std::size_t line = 0;
    std::size_t column = 0;
    std::string reason;
};

/// `drive.json:3:15: 'port' must be a whole number from 0 to 65535`.
[[nodiscard]] std::string describe(const std::filesystem::path& file, const FileError& error);

[[nodiscard]] std::variant<std::string, FileError> read_file(const std::filesystem::path& file,
                                                             std::size_t limit = max_file_bytes);

}  // namespace servobus::adapter
