#include "eds/base64.hpp"

#include <cstdint>

namespace servobus::eds {
namespace {

constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

}  // namespace

std::string to_base64(cip::ByteView octets) {
    std::string text;
    for (std::size_t i = 0; i < octets.size(); i += 3) {
        const auto piece = octets.subspan(i, std::min<std::size_t>(3, octets.size() - i));
        std::uint32_t bits = 0;
        for (std::size_t octet = 0; octet < 3; ++octet) bits = bits << 8 | (octet < piece.size() ? piece[octet] : 0U);
        for (unsigned digit = 0; digit < 4; ++digit) {
            text.push_back(digit <= piece.size() ? digits[bits >> (18 - 6 * digit) & 0x3F] : '=');
        }
    }
    return text;
}

std::optional<cip::Bytes> from_base64(std::string_view text) {
    cip::Bytes octets;
    std::uint32_t bits = 0;
    unsigned held = 0;
    bool padded = false;
    for (const char c : text) {
        if (c == ' ' || c == '\t' || c == '\r' || c == '\n') continue;
        if (c == '=') {
            padded = true;
            continue;
        }
        const auto value = digits.find(c);
        if (padded || value == std::string_view::npos) return std::nullopt;
        bits = bits << 6 | static_cast<std::uint32_t>(value);
        held += 6;
        if (held >= 8) {
            held -= 8;
            octets.push_back(static_cast<std::uint8_t>(bits >> held));
        }
    }
    // One digit alone is no octet.
    return held < 6 ? std::optional(std::move(octets)) : std::nullopt;
}

}  // namespace servobus::eds
