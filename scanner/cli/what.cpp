#include "scanner/cli/what.hpp"

#include <fmt/format.h>

#include <vector>

#include "cip/hex.hpp"
#include "drive/lookup.hpp"
#include "drive/text.hpp"
#include "drive/xenax.hpp"
#include "scanner/cli/typed_value.hpp"
#include "scanner/reading.hpp"

namespace servobus::scanner::cli {
namespace {

constexpr std::int64_t max_class = 0xFFFF;
constexpr std::int64_t max_id = 0xFFFFFFFF;

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (;;) {
        const auto end = text.find(separator);
        parts.push_back(text.substr(0, end));
        if (end == std::string_view::npos) return parts;
        text.remove_prefix(end + 1);
    }
}

/// The numbers of `0x66/1/0x24`; nullopt when it is not made of numbers.
std::optional<std::vector<std::uint32_t>> address_numbers(std::string_view text) {
    if (text.find('/') == std::string_view::npos) return std::nullopt;
    std::vector<std::uint32_t> numbers;
    for (const auto part : split(text, '/')) {
        const auto number = drive::parse_number(part);
        if (!number || *number < 0 || *number > max_id) return std::nullopt;
        numbers.push_back(static_cast<std::uint32_t>(*number));
    }
    if (numbers.front() > max_class) return std::nullopt;
    return numbers;
}

const drive::Parameter* find_row(const Attribute& at) {
    if (at.instance != 1 || at.attribute > max_class) return nullptr;
    const drive::Key key{static_cast<std::uint16_t>(at.class_id), static_cast<std::uint16_t>(at.attribute)};
    for (const auto& row : drive::parameters()) {
        if (row.key() == key) return &row;
    }
    return nullptr;
}

Parsed<What> parse_address(std::string_view text) {
    const auto numbers = address_numbers(text);
    if (!numbers || numbers->size() != 3) {
        return Mistake{
            fmt::format("'{}' is no address: write CLASS/INSTANCE/ATTRIBUTE, for example 0x66/1/0x24", text)};
    }
    const Attribute at{(*numbers)[0], (*numbers)[1], (*numbers)[2]};
    if (const auto* row = find_row(at)) return What{row, true};
    return What{at, true};
}

Mistake unknown(std::string_view text) {
    const auto near = drive::nearest_names(drive::parameters(), drive::parameter_classes(), text);
    const auto hint = near.empty() ? "'servobus-scanner list' shows all" : suggestion(near);
    return {fmt::format("no parameter is called '{}'; {}", text, hint)};
}

Mistake ambiguous(std::string_view text, const std::vector<const drive::Parameter*>& rows) {
    std::vector<std::string> names;
    names.reserve(rows.size());
    for (const auto* row : rows) names.push_back(drive::qualified_name(drive::parameter_classes(), *row));
    return {fmt::format("'{}' is the name of {} parameters; write {}", text, rows.size(), fmt::join(names, " or "))};
}

Parsed<NewValue> parse_value(const What& what, std::string_view name, std::string_view text) {
    if (what.by_address && has_type(text)) {
        auto octets = parse_typed(text);
        if (!octets) return octets.error();
        return NewValue{std::move(*octets)};
    }
    const auto* row = what.row();
    if (row == nullptr) {
        return Mistake{
            fmt::format("the type of {} is not known: write {}=DINT:50 or {}=hex:32 00 00 00", name, name, name)};
    }
    auto value = drive::parse(*row, text);
    if (const auto* error = std::get_if<drive::ParseError>(&value)) {
        return Mistake{fmt::format("{}: {}", name, error->reason)};
    }
    return NewValue{std::get<drive::Value>(std::move(value))};
}

}  // namespace

const drive::Parameter* What::row() const {
    const auto* known = std::get_if<const drive::Parameter*>(&target);
    return known != nullptr ? *known : nullptr;
}

cip::Path What::path() const {
    if (const auto* known = row()) return path_to(*known);
    const auto& at = std::get<Attribute>(target);
    return cip::Path::to(at.class_id, at.instance, at.attribute);
}

Parsed<What> parse_what(std::string_view text) {
    if (text.starts_with('@')) return parse_address(text.substr(1));
    if (text.find('/') != std::string_view::npos) return parse_address(text);
    const auto rows = drive::find_by_name(drive::parameters(), drive::parameter_classes(), text);
    if (rows.empty()) return unknown(text);
    if (rows.size() > 1) return ambiguous(text, rows);
    return What{rows.front(), false};
}

Parsed<Assignment> parse_assignment(std::string_view text) {
    const auto equals = text.find('=');
    if (equals == std::string_view::npos) {
        return Mistake{fmt::format("'{}' has no value: write WHAT=VALUE, for example SCurve=35", text)};
    }
    const auto name = text.substr(0, equals);
    auto what = parse_what(name);
    if (!what) return what.error();
    auto value = parse_value(*what, name, text.substr(equals + 1));
    if (!value) return value.error();
    return Assignment{*what, std::move(*value)};
}

Parsed<cip::Path> parse_path(std::string_view text) {
    if (text.starts_with("hex:")) {
        const auto octets = cip::from_hex(text.substr(4));
        if (!octets || octets->size() % 2 != 0 || octets->size() / 2 > cip::max_path_words) {
            return Mistake{fmt::format("'{}' is no path: after hex: come pairs of hex digits, an even number", text)};
        }
        auto path = cip::Path::parse(*octets);
        if (!path) return Mistake{fmt::format("'{}' is no path: {}", text, cip::describe(path.error()))};
        return std::move(*path);
    }
    if (text.find('/') == std::string_view::npos) {
        auto what = parse_what(text);
        if (!what) return what.error();
        return what->path();
    }
    const auto numbers = address_numbers(text.starts_with('@') ? text.substr(1) : text);
    if (numbers && numbers->size() == 2) return cip::Path::to((*numbers)[0], (*numbers)[1]);
    if (numbers && numbers->size() == 3) return cip::Path::to((*numbers)[0], (*numbers)[1], (*numbers)[2]);
    return Mistake{
        fmt::format("'{}' is no path: write CLASS/INSTANCE, CLASS/INSTANCE/ATTRIBUTE or hex:20 66 24 01", text)};
}

std::string display_name(const drive::Parameter& row) {
    const auto same = drive::find_by_name(drive::parameters(), drive::parameter_classes(), row.name);
    if (same.size() == 1 && same.front() == &row) return std::string(row.name);
    return drive::qualified_name(drive::parameter_classes(), row);
}

std::string display_name(const What& what) {
    const auto* row = what.row();
    return row != nullptr ? display_name(*row) : cip_address(std::get<Attribute>(what.target));
}

std::string cip_address(const drive::Parameter& row) {
    return cip_address(Attribute{row.cip.class_id, row.cip.instance, row.cip.attribute});
}

std::string cip_address(const Attribute& attribute) {
    return fmt::format("0x{:02X}/{}/0x{:02X}", attribute.class_id, attribute.instance, attribute.attribute);
}

std::string canopen_address(const drive::Parameter& row) {
    return row.od ? fmt::format("0x{:04X}:{:02X}", row.od->index, row.od->subindex) : std::string();
}

std::string_view type_name(const drive::Parameter& row) {
    switch (row.cip.type) {
        case drive::Type::i8:
            return "SINT";
        case drive::Type::i16:
            return "INT";
        case drive::Type::i32:
            return "DINT";
        case drive::Type::u8:
            return "USINT";
        case drive::Type::u16:
            return "UINT";
        case drive::Type::u32:
            return "UDINT";
        case drive::Type::text:
            return "STRING";
    }
    return "";
}

std::string limits_text(const drive::Parameter& row) {
    constexpr std::size_t worth_listing = 12;
    if (row.is_text()) return fmt::format("at most {} characters", row.max_length);
    if (!row.allowed.empty() && row.allowed.size() <= worth_listing)
        return fmt::format("{}", fmt::join(row.allowed, ", "));
    const auto unit = row.unit.empty() ? std::string() : " " + std::string(row.unit);
    return fmt::format("{} to {}{}", drive::format(row, row.low), drive::format(row, row.high), unit);
}

std::string suggestion(const std::vector<std::string>& names) {
    if (names.empty()) return {};
    std::string text = "did you mean ";
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (i > 0) text += i + 1 == names.size() ? " or " : ", ";
        text += names[i];
    }
    return text + "?";
}

}  // namespace servobus::scanner::cli
