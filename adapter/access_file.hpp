// A file of lines of JSON, one for each access that changes something or is refused.
//
//     {"time":"2026-11-26T09:31:39.123Z","level":"warning","event":"access refused","peer":"192.168.2.1:50000",...}
#pragma once

#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "adapter/log_line.hpp"

namespace servobus::adapter {

/// One object without a line end: `time`, `level`, `event`, and the values as texts.
[[nodiscard]] std::string to_json(const LogLine& line, std::chrono::system_clock::time_point time);

class AccessFile {
public:
    /// Lines are added to what is there; a new file is its owner's alone. The text says why it cannot be written.
    [[nodiscard]] static std::variant<AccessFile, std::string> open(const std::string& path);

    /// The first time that it fails the answer is why, a sentence; a line that is lost is lost.
    [[nodiscard]] std::optional<std::string> write(const LogLine& line, std::chrono::system_clock::time_point time);

private:
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    AccessFile(std::FILE* file, std::string path) : file_(file), path_(std::move(path)) {}

    std::unique_ptr<std::FILE, Close> file_;
    std::string path_;
    bool failed_ = false;
};

}  // namespace servobus::adapter
