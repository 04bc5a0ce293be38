#include "scanner/cli/live_table.hpp"

#include <fmt/format.h>

namespace servobus::scanner::cli {
namespace {

constexpr std::string_view no_wrap = "\x1B[?7l";
constexpr std::string_view wrap = "\x1B[?7h";
constexpr std::string_view erase_rest_of_line = "\x1B[K";
constexpr std::string_view erase_below = "\x1B[J";

std::string up(std::size_t lines) { return lines > 0 ? fmt::format("\r\x1B[{}A", lines) : std::string("\r"); }

}  // namespace

void LiveTable::show(const std::vector<std::string>& lines) {
    auto text = up(shown_);
    text += no_wrap;
    for (const auto& line : lines) text.append(line).append(erase_rest_of_line).append("\n");
    text += wrap;
    if (lines.size() < shown_) text += erase_below;
    shown_ = lines.size();
    terminal_ << text << std::flush;
}

void LiveTable::clear() {
    if (shown_ == 0) return;
    terminal_ << up(shown_) << erase_below << std::flush;
    shown_ = 0;
}

}  // namespace servobus::scanner::cli
