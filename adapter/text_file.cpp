#include "adapter/text_file.hpp"

#include <fmt/format.h>

#include <fstream>
#include <system_error>

namespace servobus::adapter {

std::string describe(const std::filesystem::path& file, const FileError& error) {
    if (error.line == 0) return fmt::format("{}: {}", file.string(), error.reason);
    return fmt::format("{}:{}:{}: {}", file.string(), error.line, error.column, error.reason);
}

std::variant<std::string, FileError> read_file(const std::filesystem::path& file, std::size_t limit) {
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) return FileError{0, 0, "is a directory, not a file"};
    std::ifstream stream(file, std::ios::binary);
    if (!stream) return FileError{0, 0, "cannot be read"};
    std::string text(limit + 1, '\0');
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(stream.gcount()));
    if (text.size() > limit) return FileError{0, 0, fmt::format("is larger than {} octets", limit)};
    return text;
}

}  // namespace servobus::adapter
