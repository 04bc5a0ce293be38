#include "adapter/log_line.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace servobus::adapter {
namespace {

bool is_plain(char c) {
    constexpr std::string_view marks = ".:/_,+-";
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           marks.find(c) != std::string_view::npos;
}

std::string quoted(std::string_view value) {
    std::string text = "\"";
    for (const char c : value) {
        if (c == '"' || c == '\\') text += '\\';
        if (c < ' ' || c > '~') {
            text += fmt::format("\\x{:02X}", static_cast<unsigned char>(c));
        } else {
            text += c;
        }
    }
    return text + '"';
}

}  // namespace

std::string to_text(const LogLine& line) {
    auto text = line.event;
    for (const auto& [key, value] : line.values) {
        const bool plain = !value.empty() && std::ranges::all_of(value, is_plain);
        text += fmt::format(" {}={}", key, plain ? value : quoted(value));
    }
    return text;
}

}  // namespace servobus::adapter
