// ParamN of a data sheet: what a tool needs to know to show a value, check it and send it (R-EDS-5).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/data_types.hpp"
#include "eds/field_values.hpp"
#include "eds/path_pattern.hpp"

namespace servobus::eds {

/// Bits of the descriptor: those of the Parameter object's attribute 4.
enum class ParameterBit : std::uint8_t {
    settable_path = 0,
    enumerated = 1,
    scaling = 2,
    scaling_links = 3,
    read_only = 4,
    monitor = 5,
    extended_precision = 6,
    gaps_in_enumeration = 7,  ///< "non-consecutive enumerated strings"
    numbers_and_enumeration = 8,
    not_displayed = 9,
    indirect_path = 10,
    not_addressable = 11,
};
inline constexpr std::uint16_t reserved_parameter_bits = 0xF000;
[[nodiscard]] constexpr std::uint16_t mask(ParameterBit bit) {
    return static_cast<std::uint16_t>(1U << static_cast<unsigned>(bit));
}

/// How a type is written in octets.
enum class TypeKind : std::uint8_t { boolean, signed_integer, unsigned_integer, real, text, unknown };
[[nodiscard]] TypeKind kind_of(cip::DataType type);
/// Octets of a value; nullopt where the value decides, or the type is not known.
[[nodiscard]] std::optional<std::size_t> octets_of(cip::DataType type);

/// Engineering value = (value + offset) x multiplier x base / divisor.
struct Scaling {
    double multiplier = 1;
    double divisor = 1;
    double base = 1;
    double offset = 0;
    /// Numbers of the Params that hold multiplier, divisor, base and offset; 0: none.
    std::array<std::uint32_t, 4> links{};
    friend bool operator==(const Scaling&, const Scaling&) = default;
};

struct EnumText {
    std::int64_t value = 0;
    std::string text{};
    friend bool operator==(const EnumText&, const EnumText&) = default;
};

struct Parameter {
    std::uint32_t number = 0;  ///< N of ParamN
    std::size_t line = 0;
    PathPattern path{};  ///< empty: the device cannot be asked for it
    std::uint16_t descriptor = 0;
    cip::DataType type{};               ///< also a code that cip::DataType does not name
    std::optional<std::size_t> size{};  ///< octets; nullopt where neither field nor type tells
    std::string name{};                 ///< ISO 8859-1, as the other texts
    std::string units{};
    std::string help{};
    Value minimum{};  ///< of a string or path: its shortest length in characters
    Value maximum{};
    Value standard{};  ///< the default
    Scaling scaling{};
    unsigned decimals = 0;  ///< to show of an engineering value
    std::vector<EnumText> enumeration{};

    [[nodiscard]] bool has(ParameterBit bit) const { return (descriptor & mask(bit)) != 0; }
    [[nodiscard]] bool read_only() const { return has(ParameterBit::read_only); }
    [[nodiscard]] std::optional<AttributeAddress> address() const { return attribute_address(path); }

    /// By scaling, where the descriptor says that the parameter has one; otherwise the number itself.
    [[nodiscard]] double to_engineering(double value) const;
    [[nodiscard]] double from_engineering(double value) const;

    /// The text that stands for a value, or nullptr.
    [[nodiscard]] const std::string* enum_text(std::int64_t value) const;
    /// The value that a text stands for; case does not count.
    [[nodiscard]] std::optional<std::int64_t> enum_value(std::string_view text) const;

    /// The value in the octets of the type; nullopt when it is none of that type, or does not fit the size.
    [[nodiscard]] std::optional<cip::Bytes> encode(const Value& value) const;
    /// The default, or zeros of the size where the sheet names none.
    [[nodiscard]] cip::Bytes standard_octets() const;
};

}  // namespace servobus::eds
