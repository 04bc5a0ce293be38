#include "cip/hex.hpp"

#include <array>

namespace servobus::cip {
namespace {

std::optional<unsigned> digit(char c) {
    if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
    if (c >= 'a' && c <= 'f') return static_cast<unsigned>(c - 'a' + 10);
    if (c >= 'A' && c <= 'F') return static_cast<unsigned>(c - 'A' + 10);
    return std::nullopt;
}

bool is_separator(char c) { return c == ' ' || c == ':' || c == '\n' || c == '\t'; }

}  // namespace

std::string to_hex(ByteView bytes) {
    static constexpr std::array digits{'0', '1', '2', '3', '4', '5', '6', '7', '8', '9', 'A', 'B', 'C', 'D', 'E', 'F'};
    std::string text;
    text.reserve(bytes.size() * 3);
    for (const auto byte : bytes) {
        if (!text.empty()) text.push_back(' ');
        text.push_back(digits[byte >> 4]);
        text.push_back(digits[byte & 0x0F]);
    }
    return text;
}

std::optional<Bytes> from_hex(std::string_view text) {
    if (text.starts_with("0x") || text.starts_with("0X")) text.remove_prefix(2);
    Bytes bytes;
    std::optional<unsigned> high;
    for (const char c : text) {
        if (is_separator(c)) {
            if (high) return std::nullopt;
            continue;
        }
        const auto value = digit(c);
        if (!value) return std::nullopt;
        if (high) {
            bytes.push_back(static_cast<std::uint8_t>(*high << 4 | *value));
            high.reset();
        } else {
            high = value;
        }
    }
    if (high) return std::nullopt;
    return bytes;
}

}  // namespace servobus::cip
