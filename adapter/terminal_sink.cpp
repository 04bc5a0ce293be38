#include "adapter/terminal_sink.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <utility>

namespace servobus::adapter {
namespace {

// The cursor to the first column, and what is right of it cleared.
constexpr std::string_view start_again = "\r\x1b[K";

}  // namespace

void TerminalSink::write(std::string_view text) {
    static_cast<void>(std::fwrite(text.data(), 1, text.size(), terminal_));
    std::fflush(terminal_);
}

void TerminalSink::show(std::string line) {
    if (line == status_) return;
    status_ = std::move(line);
    write(std::string(start_again) + status_);
}

// In one write, so that nobody sees a line without the other.
void TerminalSink::sink_it_(const spdlog::details::log_msg& message) {
    spdlog::memory_buf_t formatted;
    formatter_->format(message, formatted);
    std::string text(status_.empty() ? std::string_view() : start_again);
    text.append(formatted.data(), formatted.size());
    write(text + status_);
}

std::size_t TerminalSink::width() const {
    constexpr std::size_t usual = 80;
    winsize size{};
    const bool known = ::ioctl(::fileno(terminal_), TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
    return (known ? size.ws_col : usual) - 1;
}

}  // namespace servobus::adapter
