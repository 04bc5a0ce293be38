// One row of the one table: what a drive parameter is, and where each bus finds it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace servobus::drive {

/// How a parameter is stored on a bus: integers by width and sign, or characters.
enum class Type : std::uint8_t { i8, i16, i32, u8, u16, u32, text };

/// Bytes of an integer type; 0 for text, whose length is the value's own.
[[nodiscard]] constexpr std::size_t size_of(Type type) {
    switch (type) {
        case Type::i8:
        case Type::u8:
            return 1;
        case Type::i16:
        case Type::u16:
            return 2;
        case Type::i32:
        case Type::u32:
            return 4;
        case Type::text:
            return 0;
    }
    return 0;
}

[[nodiscard]] constexpr bool is_signed(Type type) { return type == Type::i8 || type == Type::i16 || type == Type::i32; }

/// The smallest and largest number that an integer type holds.
[[nodiscard]] constexpr std::int64_t lowest(Type type) {
    return is_signed(type) ? -(std::int64_t{1} << (8 * size_of(type) - 1)) : 0;
}
[[nodiscard]] constexpr std::int64_t highest(Type type) {
    return (std::int64_t{1} << (8 * size_of(type) - (is_signed(type) ? 1 : 0))) - 1;
}

/// Who may do what through a bus. The drive itself always reads and writes.
enum class Access : std::uint8_t { get, set, get_set };

[[nodiscard]] constexpr bool may_get(Access access) { return access != Access::set; }
[[nodiscard]] constexpr bool may_set(Access access) { return access != Access::get; }

/// How a person reads the number: as a count, as a bit pattern, or as an IPv4 address.
enum class Form : std::uint8_t { number, bits, ipv4 };

/// How true the virtual drive is to a row or a command.
enum class Fidelity : std::uint8_t {
    behaves,  ///< it does, or tells, what its text says
    stored,   ///< it keeps what is written, and nothing can be seen of it
    fixed,    ///< it tells one value for ever
};

/// Where CIP finds the row (class, instance, attribute) and the type it has there.
struct CipAddress {
    std::uint16_t class_id;
    std::uint16_t instance;
    std::uint16_t attribute;
    Type type;
};

/// Where CANopen, EtherCAT and POWERLINK find the row. Limits stand here only when 004 prints others than 000.
struct OdAddress {
    std::uint16_t index;
    std::uint8_t subindex;
    Type type;
    std::optional<std::int64_t> low{};
    std::optional<std::int64_t> standard{};
    std::optional<std::int64_t> high{};
};

/// A row named by its CIP class and attribute. Names repeat and attribute 0 is real, so this is the key.
struct Key {
    std::uint16_t class_id;
    std::uint16_t attribute;

    friend constexpr bool operator==(const Key&, const Key&) = default;
    friend constexpr auto operator<=>(const Key&, const Key&) = default;  // NOLINT(modernize-use-nullptr): misread
};

/// One parameter. Limits and default are in the unit named; they are 0 for text, whose limit is `max_length`.
struct Parameter {
    std::string_view name;      ///< the manual's name as one word: `TellStatus`
    std::string_view mnemonic;  ///< the XENAX command: `TS`; empty where the manual gives none
    std::string_view unit{};    ///< `increment`, `mA`, ...; empty for plain numbers
    Access access = Access::get;
    std::int64_t low = 0;
    std::int64_t standard = 0;  ///< the manual's "Default Value"
    std::int64_t high = 0;
    std::string_view standard_text{};         ///< the default of a text parameter
    std::size_t max_length = 0;               ///< characters a text parameter holds
    std::span<const std::int64_t> allowed{};  ///< when not empty: the only legal numbers (errata X-20)
    Form form = Form::number;
    bool force_option = false;  ///< only the Xvi 75V8S has it (000 §2.3.8, 004 §3.4)
    bool momentary = false;     ///< a set point or a command that can be read: power-off forgets it (errata P-1)
    CipAddress cip;
    std::optional<OdAddress> od{};
    std::optional<Key> same_as{};      ///< a second address of the variable of that row
    std::optional<Key> selected_by{};  ///< that row (NIX, NSEC, ...) chooses which element this row shows
    std::uint16_t elements = 1;        ///< how many elements a selected row has
    Fidelity fidelity = Fidelity::behaves;
    std::string_view remark{};  ///< why it is not, or what is different; a sentence
    std::string_view section;   ///< "000 §2.3.1.1"
    std::string_view text;      ///< one or two sentences for the engineer

    [[nodiscard]] constexpr Key key() const { return {cip.class_id, cip.attribute}; }
    [[nodiscard]] constexpr bool is_text() const { return cip.type == Type::text; }
};

}  // namespace servobus::drive
