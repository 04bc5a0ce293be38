#include "eds/path_pattern.hpp"

#include <algorithm>

#include "cip/hex.hpp"
#include "cip/wire.hpp"
#include "eds/field_values.hpp"

namespace servobus::eds {
namespace {

constexpr std::string_view symbol_keyword = "SYMBOL_ANSI";

// What stands between blanks and brackets.
std::string_view take_token(std::string_view& text) {
    constexpr std::string_view between = " \t[]";
    text.remove_prefix(std::min(text.find_first_not_of(between), text.size()));
    const auto token = text.substr(0, text.find_first_of(between));
    text.remove_prefix(token.size());
    return token;
}

bool add_octets(PathPattern& pattern, std::string_view token) {
    const auto octets = cip::from_hex(token);
    if (!octets) return false;
    if (pattern.parts.empty() || !std::holds_alternative<cip::Bytes>(pattern.parts.back())) {
        pattern.parts.emplace_back(cip::Bytes{});
    }
    auto& last = std::get<cip::Bytes>(pattern.parts.back());
    last.insert(last.end(), octets->begin(), octets->end());
    return true;
}

std::optional<cip::Path> packed(cip::ByteView octets) {
    cip::Reader reader(octets);
    cip::Path path;
    while (reader.ok() && reader.remaining() > 0) {
        const auto first = reader.u8();
        const auto type = static_cast<cip::LogicalType>(first >> 2 & 7);
        const auto width = first & 3;
        if (first >> 5 != 1 || width == 3 || type == cip::LogicalType::special) return std::nullopt;
        const std::uint32_t value = width == 0 ? reader.u8() : width == 1 ? reader.u16() : reader.u32();
        path.segments.emplace_back(cip::LogicalSegment{type, value, static_cast<cip::Width>(width)});
    }
    return reader.ok() ? std::optional(std::move(path)) : std::nullopt;
}

}  // namespace

std::optional<cip::Bytes> PathPattern::octets() const {
    if (parts.empty()) return cip::Bytes{};
    const auto* octets = parts.size() == 1 ? std::get_if<cip::Bytes>(&parts.front()) : nullptr;
    return octets != nullptr ? std::optional(*octets) : std::nullopt;
}

std::optional<PathPattern> path_pattern(const Field& field) {
    PathPattern pattern;
    std::string_view rest = field.value;
    for (auto token = take_token(rest); !token.empty(); token = take_token(rest)) {
        if (const auto number = number_behind("Param", token)) {
            pattern.parts.emplace_back(PathPattern::Parameter{*number});
        } else if (same_name(token, symbol_keyword)) {
            pattern.parts.emplace_back(PathPattern::Symbol{});
        } else if (!add_octets(pattern, token)) {
            return std::nullopt;
        }
    }
    return pattern;
}

std::optional<cip::Path> segments(cip::ByteView octets) {
    const auto padded = cip::Path::parse(octets);
    if (padded && std::ranges::equal(padded->encode(), octets)) return *padded;
    if (auto path = packed(octets)) return path;
    return padded ? std::optional(*padded) : std::nullopt;
}

std::optional<AttributeAddress> attribute_address(const PathPattern& pattern) {
    const auto octets = pattern.octets();
    const auto path = octets ? segments(*octets) : std::nullopt;
    if (!path || path->segments.size() != 3) return std::nullopt;
    const auto value = [&](std::size_t index, cip::LogicalType type) -> std::optional<std::uint32_t> {
        const auto* segment = std::get_if<cip::LogicalSegment>(&path->segments[index]);
        if (segment == nullptr || segment->type != type) return std::nullopt;
        return segment->value;
    };
    const auto class_id = value(0, cip::LogicalType::class_id);
    const auto instance = value(1, cip::LogicalType::instance);
    const auto attribute = value(2, cip::LogicalType::attribute);
    if (!class_id || !instance || !attribute) return std::nullopt;
    return AttributeAddress{*class_id, *instance, *attribute};
}

}  // namespace servobus::eds
