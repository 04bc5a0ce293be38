#include "scanner/cli/io_data.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <cctype>

#include "assemblies/parameter_value.hpp"
#include "cip/hex.hpp"
#include "cip/wire.hpp"
#include "drive/lookup.hpp"
#include "drive/text.hpp"
#include "drive/xenax.hpp"
#include "scanner/axis_state.hpp"
#include "scanner/cli/text_output.hpp"
#include "scanner/cli/typed_value.hpp"
#include "scanner/cli/what.hpp"
#include "scanner/sheet_value.hpp"

namespace servobus::scanner::cli {
namespace {

using Kind = assemblies::Member::Kind;
// Those of a data sheet; what is called so in here is about the drive's table.
using scanner::limits_text;
using scanner::value_text;

constexpr std::string_view padding_name = "Padding";
constexpr std::string_view time_stamp_name = "TimeStamp";
/// No mode of the manual's, so that bits which mean something in one mode only keep their numbers.
constexpr int unknown_mode = -100;

const drive::Parameter* find_row(drive::Key key) {
    const auto rows = drive::parameters();
    const auto found = std::ranges::find(rows, key, &drive::Parameter::key);
    return found != rows.end() ? &*found : nullptr;
}

/// Two rows show one variable when one is a second address of the other.
bool same_variable(const drive::Parameter& a, const drive::Parameter& b) {
    return a.same_as.value_or(a.key()) == b.same_as.value_or(b.key());
}

/// The octets of a field, moved down to their first bit.
cip::Bytes octets_in(const IoField& field, cip::ByteView data) {
    const auto octets = data.subspan(field.offset, field.octets);
    if (field.bits == 0) return {octets.begin(), octets.end()};
    cip::Bytes moved((field.bits + 7) / 8);
    for (std::size_t bit = 0; bit < field.bits; ++bit) {
        const auto from = field.first_bit + bit;
        const unsigned value = octets[from / 8] >> (from % 8) & 1U;
        moved[bit / 8] = static_cast<std::uint8_t>(moved[bit / 8] | value << (bit % 8));
    }
    return moved;
}

std::uint64_t raw_in(const IoField& field, cip::ByteView data) {
    std::uint64_t raw = 0;
    const auto octets = octets_in(field, data);
    for (std::size_t i = octets.size(); i-- > 0;) raw = raw << 8 | octets[i];
    return raw;
}

/// What a data sheet's parameter says of the octets of a field, which may be fewer bits than its type has.
std::optional<eds::Value> sheet_value_in(const IoField& field, cip::ByteView data) {
    if (field.parameter == nullptr) return std::nullopt;
    auto octets = octets_in(field, data);
    const auto size = value_octets(*field.parameter, octets);
    if (size && octets.size() < *size && *size <= sizeof(std::uint64_t)) octets.resize(*size);
    return decode(*field.parameter, octets);
}

cip::Bytes little_endian(std::uint64_t raw, std::size_t size) {
    cip::Bytes octets;
    for (; size > 0; --size, raw >>= 8) octets.push_back(static_cast<std::uint8_t>(raw));
    return octets;
}

bool same_word(std::string_view a, std::string_view b) {
    const auto lower = [](unsigned char c) { return std::tolower(c); };
    return std::ranges::equal(a, b, {}, lower, lower);
}

std::string names_of(const IoFields& fields) {
    std::vector<std::string> names;
    for (const auto& field : fields) {
        if (field.kind != Kind::padding) names.push_back(field.name());
    }
    return fmt::format("{}", fmt::join(names, ", "));
}

Mistake not_there(std::string_view name, const IoOutputs& outputs) {
    if (outputs.fields.empty()) {
        return {
            fmt::format("'{}': these outputs have no names; write @OFFSET:TYPE=VALUE, for example @0:DINT=5", name)};
    }
    return {fmt::format("'{}' is not in {}, which has {}", name, outputs.name, names_of(outputs.fields))};
}

/// Case, blanks and punctuation do not count, save what tells two of one name apart.
std::string plain(std::string_view name) {
    std::string word;
    for (const char each : name) {
        const auto c = static_cast<unsigned char>(each);
        if (std::isalnum(c) != 0 || c >= 0x80 || c == '#') word += static_cast<char>(std::tolower(c));
    }
    return word;
}

Parsed<IoChange> sheet_change(const IoField& field, std::string_view text) {
    if (field.parameter == nullptr) {
        const auto number = drive::parse_number(text);
        if (!number) return Mistake{fmt::format("{}: '{}' is no number", field.label, text)};
        return IoChange{field.offset, little_endian(static_cast<std::uint64_t>(*number), (field.bits + 7) / 8),
                        field.first_bit, field.bits};
    }
    const auto value = parse_value(*field.parameter, text);
    if (!value) return Mistake{fmt::format("{}: {}", field.label, printable(value.error().text))};
    if (!within_limits(*field.parameter, *value)) {
        return Mistake{fmt::format("{}: it takes {}; @OFFSET:TYPE=VALUE sends anything", field.label,
                                   printable(limits_text(*field.parameter)))};
    }
    auto octets = *field.parameter->encode(*value);
    const auto room = (field.bits + 7) / 8;
    if (octets.size() > room && octets.size() > sizeof(std::uint64_t)) {
        return Mistake{fmt::format("{}: '{}' is longer than its {} octets", field.label, text, room)};
    }
    octets.resize(room);
    return IoChange{field.offset, std::move(octets), field.first_bit, field.bits};
}

/// Padding and time stamps are in no table.
Parsed<IoChange> unnamed_change(const IoField& field, std::string_view text) {
    const auto number = drive::parse_number(text);
    if (!number) return Mistake{fmt::format("{}: '{}' is no number", field.name(), text)};
    return IoChange{field.offset, little_endian(static_cast<std::uint64_t>(*number), field.octets)};
}

Parsed<IoChange> named_change(std::string_view name, std::string_view text, const IoOutputs& outputs) {
    for (const auto& field : outputs.fields) {
        if (!field.label.empty() && plain(field.label) == plain(name)) return sheet_change(field, text);
        if (field.kind != Kind::parameter && same_word(field.name(), name)) return unnamed_change(field, text);
    }
    if (outputs.layout == nullptr) return not_there(name, outputs);
    const auto what = parse_what(name);
    if (!what) return what.error();
    const auto* field = what->row() != nullptr ? find_field(outputs.fields, *what->row()) : nullptr;
    if (field == nullptr) return not_there(name, outputs);
    auto value = drive::parse(*field->row, text);
    if (const auto* error = std::get_if<drive::ParseError>(&value)) {
        return Mistake{fmt::format("{}: {}", name, error->reason)};
    }
    return *change_of(outputs.fields, *field->row, std::get<drive::Value>(value));
}

/// `OFFSET:TYPE` and a value.
Parsed<IoChange> placed_change(std::string_view place, std::string_view text, const IoOutputs& outputs) {
    const auto colon = place.find(':');
    const auto offset = drive::parse_number(place.substr(0, colon));
    if (colon == std::string_view::npos || !offset || *offset < 0) {
        return Mistake{fmt::format("'@{}' is no place: write @OFFSET:TYPE=VALUE, for example @0:DINT=5", place)};
    }
    auto octets = parse_typed(fmt::format("{}:{}", place.substr(colon + 1), text));
    if (!octets) return octets.error();
    const auto begin = static_cast<std::uint64_t>(*offset);
    if (begin > outputs.octets || octets->size() > outputs.octets - begin) {
        return Mistake{fmt::format("'@{}' ends behind the {} octets of the outputs", place, outputs.octets)};
    }
    return IoChange{static_cast<std::size_t>(begin), std::move(*octets)};
}

}  // namespace

std::string IoField::name() const {
    switch (kind) {
        case Kind::parameter:
            return row != nullptr ? display_name(*row) : label;
        case Kind::padding:
            return std::string(padding_name);
        case Kind::time_stamp:
            return std::string(time_stamp_name);
    }
    return {};
}

std::string IoField::unit() const {
    if (kind == Kind::time_stamp) return "us";
    if (parameter != nullptr) return printable(parameter->units);
    return row != nullptr ? std::string(row->unit) : std::string();
}

IoOutputs IoOutputs::of(const assemblies::Layout* layout) {
    if (layout == nullptr) return {};
    return {layout, layout->size(), fields_of(*layout), fmt::format("assembly {}", layout->instance)};
}

IoFields fields_of(const assemblies::Layout& layout) {
    IoFields fields;
    std::size_t offset = 0;
    for (const auto& member : layout.members) {
        const auto* row = member.kind == Kind::parameter ? find_row(member.key) : nullptr;
        assert(member.kind != Kind::parameter || row != nullptr);
        fields.push_back({.kind = member.kind, .row = row, .offset = offset, .octets = member.octets});
        offset += member.octets;
    }
    return fields;
}

std::int64_t number_in(const IoField& field, cip::ByteView data) {
    if (const auto value = sheet_value_in(field, data)) {
        if (const auto* whole = std::get_if<std::int64_t>(&*value)) return *whole;
    }
    if (field.row == nullptr) return static_cast<std::int64_t>(raw_in(field, data));
    const auto value = assemblies::read_value(*field.row, data.subspan(field.offset, field.octets));
    const auto* number = value ? std::get_if<std::int64_t>(&*value) : nullptr;
    return number != nullptr ? *number : 0;
}

eds::Value value_in(const IoField& field, cip::ByteView data) {
    if (const auto value = sheet_value_in(field, data)) return engineering(*field.parameter, *value);
    return number_in(field, data);
}

std::string text_in(const IoField& field, cip::ByteView data) {
    if (const auto value = sheet_value_in(field, data)) return printable(value_text(*field.parameter, *value));
    if (field.bits > 64) return cip::to_hex(octets_in(field, data));
    const auto number = number_in(field, data);
    return field.row != nullptr ? drive::format(*field.row, number) : fmt::format("{}", number);
}

std::string meaning_in(const IoField& field, cip::ByteView data) {
    if (field.row == nullptr) return {};
    const auto raw = static_cast<std::uint32_t>(raw_in(field, data));
    const auto words = [&](std::span<const BitText> bits) {
        return fmt::format("{}", fmt::join(set_bits(bits, raw, unknown_mode), ", "));
    };
    if (field.row == &row_of(AxisValue::control_word)) return words(control_bits());
    if (field.row == &row_of(AxisValue::process_status)) return words(process_bits());
    if (field.row == &row_of(AxisValue::inputs)) return words(input_bits());
    if (field.row == &row_of(AxisValue::outputs)) return words(output_bits());
    if (field.row != &row_of(AxisValue::status_word)) return {};
    // The state says what bits 0 to 3, 5 and 6 say.
    constexpr std::uint32_t state_bits = 0x6F;
    AxisState state;
    state.take(AxisValue::status_word, drive::Value(number_in(field, data)));
    const auto rest = set_bits(status_bits(), raw & ~state_bits, unknown_mode);
    return rest.empty() ? std::string(state_text(state))
                        : fmt::format("{}; {}", state_text(state), fmt::join(rest, ", "));
}

Parsed<IoChange> parse_change(std::string_view text, const IoOutputs& outputs) {
    const auto equals = text.find('=');
    if (equals == std::string_view::npos) {
        return Mistake{fmt::format("'{}' has no value: write NAME=VALUE or @OFFSET:TYPE=VALUE", text)};
    }
    const auto name = text.substr(0, equals);
    const auto value = text.substr(equals + 1);
    // @0x66/1/0x3A is the address of a parameter, as everywhere.
    const bool is_place = name.starts_with('@') && name.find('/') == std::string_view::npos;
    return is_place ? placed_change(name.substr(1), value, outputs) : named_change(name, value, outputs);
}

void put(const IoChange& change, std::span<std::uint8_t> image) {
    if (change.bits == 0) {
        std::ranges::copy(change.octets, image.subspan(change.offset).begin());
        return;
    }
    for (std::size_t bit = 0; bit < change.bits; ++bit) {
        const auto to = 8 * change.offset + change.first_bit + bit;
        const auto mask = static_cast<std::uint8_t>(1U << (to % 8));
        const bool set = (change.octets[bit / 8] >> (bit % 8) & 1) != 0;
        auto& octet = image[to / 8];
        octet = static_cast<std::uint8_t>(set ? octet | mask : octet & ~mask);
    }
}

std::optional<IoChange> change_of(const IoFields& fields, const drive::Parameter& row, const drive::Value& value) {
    const auto* field = find_field(fields, row);
    if (field == nullptr) return std::nullopt;
    IoChange change{field->offset, {}, field->first_bit, field->bits};
    cip::Writer writer(change.octets);
    assemblies::write_value(writer, field->row != nullptr ? *field->row : row, value);
    change.octets.resize(std::max(change.octets.size(), (field->bits + 7) / 8));
    return change;
}

const IoField* find_field(const IoFields& fields, const drive::Parameter& row) {
    const eds::AttributeAddress address{row.cip.class_id, row.cip.instance, row.cip.attribute};
    const auto found = std::ranges::find_if(fields, [&](const IoField& field) {
        if (field.parameter != nullptr) return field.parameter->address() == address;
        return field.row != nullptr && same_variable(*field.row, row);
    });
    return found != fields.end() ? &*found : nullptr;
}

}  // namespace servobus::scanner::cli
