// What the device has to say to the person who runs it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace servobus::adapter {

enum class LogLevel : std::uint8_t { trace, debug, info, warning, error };

/// Receives one line without a line end. Empty: nobody listens.
using LogSink = std::function<void(LogLevel, std::string_view)>;

/// A sink that may be empty.
class Log {
public:
    Log() = default;
    explicit Log(LogSink sink) : sink_(std::move(sink)) {}

    void operator()(LogLevel level, const std::string& line) const;

private:
    LogSink sink_;
};

}  // namespace servobus::adapter
