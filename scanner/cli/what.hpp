// WHAT: a parameter by name, mnemonic or address, or any attribute by its address.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "cip/bytes.hpp"
#include "cip/path.hpp"
#include "drive/parameter.hpp"
#include "drive/store.hpp"
#include "scanner/mistake.hpp"

namespace servobus::scanner::cli {

/// An attribute that the drive's table does not have.
struct Attribute {
    std::uint32_t class_id = 0;
    std::uint32_t instance = 0;
    std::uint32_t attribute = 0;
    friend bool operator==(const Attribute&, const Attribute&) = default;
};

struct What {
    std::variant<const drive::Parameter*, Attribute> target;
    bool by_address = false;  ///< was given as an address, so that values may be given raw

    [[nodiscard]] const drive::Parameter* row() const;
    [[nodiscard]] cip::Path path() const;
};

/// `SCurve`, `scrv`, `drive.Controlword`, `@0x66/1/0x24`, `0x66/1/0x24`.
[[nodiscard]] Parsed<What> parse_what(std::string_view text);

/// What `set` sends: a value of the row, or octets.
using NewValue = std::variant<drive::Value, cip::Bytes>;

struct Assignment {
    What what;
    NewValue value;
};

/// `WHAT=VALUE`. The value of a parameter as drive::parse reads it; behind an address also `hex:32 00` or `DINT:50`.
[[nodiscard]] Parsed<Assignment> parse_assignment(std::string_view text);

/// `0x66/1/0x24`, `0x01/1`, `hex:20 66 24 01`, or the name of a parameter.
[[nodiscard]] Parsed<cip::Path> parse_path(std::string_view text);

/// `SCurve`, or `drive.Controlword` when there is another parameter of that name.
[[nodiscard]] std::string display_name(const drive::Parameter& row);
[[nodiscard]] std::string display_name(const What& what);

/// Both forms of a parameter's address: `0x66/1/0x24`, `0x6064:00` (empty when there is none).
[[nodiscard]] std::string cip_address(const drive::Parameter& row);
[[nodiscard]] std::string cip_address(const Attribute& attribute);
[[nodiscard]] std::string canopen_address(const drive::Parameter& row);

/// `DINT`.
[[nodiscard]] std::string_view type_name(const drive::Parameter& row);

/// What the row takes: `1 to 100 %`, `-2, -1, 0, 1, 6, 8`, `at most 32 characters`.
[[nodiscard]] std::string limits_text(const drive::Parameter& row);

/// `did you mean A, B or C?`; empty without names.
[[nodiscard]] std::string suggestion(const std::vector<std::string>& names);

}  // namespace servobus::scanner::cli
