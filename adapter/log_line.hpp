// A line of the log with named values, for people and for programs alike.
//
//     access refused peer=192.168.2.1:50000 service=Set_Attribute_Single result="0x0F privilege violation"
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "adapter/log.hpp"

namespace servobus::adapter {

struct LogLine {
    LogLevel level = LogLevel::info;
    std::string event;  ///< `access refused`
    std::vector<std::pair<std::string, std::string>> values{};
};

/// Event and `key=value`. A value that is not all letters, digits and `.:/_,+-` stands in double quotes; a backslash is
/// in front of a quote, of another backslash, and of `xNN` for what cannot be printed.
[[nodiscard]] std::string to_text(const LogLine& line);

/// Who wants lines: nothing below `lowest` is written for them. An empty `take`: nobody listens.
struct LineSink {
    LogLevel lowest = LogLevel::trace;
    std::function<void(const LogLine&)> take{};

    [[nodiscard]] bool wants(LogLevel level) const { return take && level >= lowest; }
};

}  // namespace servobus::adapter
