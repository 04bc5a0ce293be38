#include "eds/parameter.hpp"

#include <algorithm>
#include <bit>

#include "cip/hex.hpp"
#include "cip/wire.hpp"

namespace servobus::eds {
namespace {

using cip::DataType;

// A number of `size` octets, little-endian; nullopt when there are octets left that are not the sign.
std::optional<cip::Bytes> integer_octets(std::int64_t number, std::size_t size, TypeKind kind) {
    if (size == 0 || size > sizeof number) return std::nullopt;
    const auto bits = 8 * size;
    if (bits < 64) {
        const auto low = kind == TypeKind::signed_integer ? -(std::int64_t{1} << (bits - 1)) : 0;
        const auto high = (std::int64_t{1} << (kind == TypeKind::signed_integer ? bits - 1 : bits)) - 1;
        if (number < low || number > high) return std::nullopt;
    }
    cip::Bytes octets;
    for (auto rest = static_cast<std::uint64_t>(number); octets.size() < size; rest >>= 8) {
        octets.push_back(static_cast<std::uint8_t>(rest));
    }
    return octets;
}

std::optional<cip::Bytes> real_octets(double number, DataType type) {
    cip::Bytes octets;
    cip::Writer writer(octets);
    if (type == DataType::REAL) {
        writer.u32(std::bit_cast<std::uint32_t>(static_cast<float>(number)));
    } else {
        writer.u64(std::bit_cast<std::uint64_t>(number));
    }
    return octets;
}

// A string with its count in front; a path as the octets that its digits are.
std::optional<cip::Bytes> text_octets(const std::string& text, DataType type) {
    if (type == DataType::EPATH) return cip::from_hex(text);
    const std::size_t longest = type == DataType::SHORT_STRING ? 0xFF : 0xFFFF;
    if (text.size() > longest || (type != DataType::STRING && type != DataType::SHORT_STRING)) return std::nullopt;
    cip::Bytes octets;
    cip::Writer writer(octets);
    if (type == DataType::STRING) {
        writer.u16(static_cast<std::uint16_t>(text.size()));
    } else {
        writer.u8(static_cast<std::uint8_t>(text.size()));
    }
    octets.insert(octets.end(), text.begin(), text.end());
    return octets;
}

}  // namespace

TypeKind kind_of(DataType type) {
    switch (type) {
        case DataType::BOOL:
            return TypeKind::boolean;
        case DataType::SINT:
        case DataType::INT:
        case DataType::DINT:
        case DataType::LINT:
        case DataType::STIME:
        case DataType::FTIME:
        case DataType::LTIME:
        case DataType::ITIME:
        case DataType::TIME:
            return TypeKind::signed_integer;
        case DataType::USINT:
        case DataType::UINT:
        case DataType::UDINT:
        case DataType::ULINT:
        case DataType::BYTE:
        case DataType::WORD:
        case DataType::DWORD:
        case DataType::LWORD:
        case DataType::DATE:
        case DataType::TIME_OF_DAY:
        case DataType::ENGUNIT:
            return TypeKind::unsigned_integer;
        case DataType::REAL:
        case DataType::LREAL:
            return TypeKind::real;
        case DataType::STRING:
        case DataType::STRING2:
        case DataType::STRINGN:
        case DataType::SHORT_STRING:
        case DataType::EPATH:
        case DataType::STRINGI:
            return TypeKind::text;
        case DataType::DATE_AND_TIME:
            break;
    }
    return TypeKind::unknown;
}

std::optional<std::size_t> octets_of(DataType type) {
    switch (type) {
        case DataType::BOOL:
        case DataType::SINT:
        case DataType::USINT:
        case DataType::BYTE:
            return 1;
        case DataType::INT:
        case DataType::UINT:
        case DataType::WORD:
        case DataType::DATE:
        case DataType::ITIME:
        case DataType::ENGUNIT:
            return 2;
        case DataType::DINT:
        case DataType::UDINT:
        case DataType::REAL:
        case DataType::DWORD:
        case DataType::TIME:
        case DataType::TIME_OF_DAY:
        case DataType::FTIME:
            return 4;
        case DataType::LINT:
        case DataType::ULINT:
        case DataType::LREAL:
        case DataType::LWORD:
        case DataType::LTIME:
            return 8;
        case DataType::DATE_AND_TIME:
            return 6;
        case DataType::STIME:  // 4, or 8 in the Time Sync object (R-TYP-1)
        case DataType::STRING:
        case DataType::STRING2:
        case DataType::STRINGN:
        case DataType::SHORT_STRING:
        case DataType::EPATH:
        case DataType::STRINGI:
            break;
    }
    return std::nullopt;
}

double Parameter::to_engineering(double value) const {
    if (!has(ParameterBit::scaling) || scaling.divisor == 0) return value;
    return (value + scaling.offset) * scaling.multiplier * scaling.base / scaling.divisor;
}

double Parameter::from_engineering(double value) const {
    const auto factor = scaling.multiplier * scaling.base;
    if (!has(ParameterBit::scaling) || factor == 0) return value;
    return value * scaling.divisor / factor - scaling.offset;
}

const std::string* Parameter::enum_text(std::int64_t value) const {
    const auto found = std::ranges::find(enumeration, value, &EnumText::value);
    return found != enumeration.end() ? &found->text : nullptr;
}

std::optional<std::int64_t> Parameter::enum_value(std::string_view text) const {
    const auto found =
        std::ranges::find_if(enumeration, [&](const EnumText& each) { return same_name(each.text, text); });
    return found != enumeration.end() ? std::optional(found->value) : std::nullopt;
}

std::optional<cip::Bytes> Parameter::encode(const Value& value) const {
    const auto kind = kind_of(type);
    if (const auto* characters = std::get_if<std::string>(&value)) return text_octets(*characters, type);
    if (const auto* fraction = std::get_if<double>(&value)) {
        return kind == TypeKind::real ? real_octets(*fraction, type) : std::nullopt;
    }
    const auto* whole = std::get_if<std::int64_t>(&value);
    if (whole == nullptr || kind == TypeKind::text) return std::nullopt;
    if (kind == TypeKind::real) return real_octets(static_cast<double>(*whole), type);
    return size ? integer_octets(*whole, *size, kind) : std::nullopt;
}

cip::Bytes Parameter::standard_octets() const {
    const auto octets = encode(standard);
    return octets ? *octets : cip::Bytes(size.value_or(0));
}

}  // namespace servobus::eds
