// The log on a terminal, with a status line below it that is rewritten in place: each line of the log takes its place,
// and it follows beneath.
#pragma once

#include <spdlog/details/null_mutex.h>
#include <spdlog/sinks/base_sink.h>

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

namespace servobus::adapter {

class TerminalSink final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
public:
    /// `terminal` outlives this.
    explicit TerminalSink(std::FILE* terminal) : terminal_(terminal) {}
    ~TerminalSink() override { show({}); }
    TerminalSink(const TerminalSink&) = delete;
    TerminalSink& operator=(const TerminalSink&) = delete;

    /// Rewrites the status line; empty takes it away. It has fewer characters than the terminal columns.
    void show(std::string line);
    /// Characters that fit beside the cursor: one fewer than the terminal has columns.
    [[nodiscard]] std::size_t width() const;

protected:
    void sink_it_(const spdlog::details::log_msg& message) override;
    void flush_() override { std::fflush(terminal_); }

private:
    void write(std::string_view text);

    std::FILE* terminal_;
    std::string status_;
};

}  // namespace servobus::adapter
