// A path as a data sheet writes it: hex octets, between which a tool puts values of parameters or a tag name.
#pragma once

#include <boost/system/result.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/path.hpp"
#include "eds/document.hpp"

namespace servobus::eds {

struct PathPattern {
    /// `[Param6]`: the value of that parameter, with its size.
    struct Parameter {
        std::uint32_t number = 0;
        friend bool operator==(const Parameter&, const Parameter&) = default;
    };
    /// `SYMBOL_ANSI`: an extended symbol segment (R-PTH-9) with a name that the user chooses.
    struct Symbol {
        friend bool operator==(const Symbol&, const Symbol&) = default;
    };
    using Part = std::variant<cip::Bytes, Parameter, Symbol>;

    std::vector<Part> parts{};

    [[nodiscard]] bool empty() const { return parts.empty(); }
    /// The octets, when nothing has to be put in.
    [[nodiscard]] std::optional<cip::Bytes> octets() const;
    friend bool operator==(const PathPattern&, const PathPattern&) = default;
};

/// Of a string, or of a word as old sheets have it. An empty field is an empty pattern; nullopt: it is no path.
[[nodiscard]] std::optional<PathPattern> path_pattern(const Field& field);

/// The segments of `octets`: padded, or packed as some sheets write wide segments, `21 04 00`. Nullopt: neither.
[[nodiscard]] std::optional<cip::Path> segments(cip::ByteView octets);

/// Class, instance and attribute, when that is what a path is.
struct AttributeAddress {
    std::uint32_t class_id = 0;
    std::uint32_t instance = 0;
    std::uint32_t attribute = 0;
    friend bool operator==(const AttributeAddress&, const AttributeAddress&) = default;
};
[[nodiscard]] std::optional<AttributeAddress> attribute_address(const PathPattern& pattern);

}  // namespace servobus::eds
