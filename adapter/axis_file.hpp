// Axes as data: one JSON file each, those that ship with the program and those of its users alike.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "adapter/text_file.hpp"
#include "drive/axis_kind.hpp"

namespace servobus::adapter {

/// The axis that a program started without one has.
inline constexpr std::string_view default_axis = "linax-lxc-230f10";

/// `text` is the file's content. Every member of AxisKind must be there and fit the others; "sources", which says where
/// the numbers come from, may stand there too.
[[nodiscard]] std::variant<drive::AxisKind, FileError> parse_axis(const std::string& text);

/// The axes that ship, ordered by key.
[[nodiscard]] std::span<const drive::AxisKind> shipped_axes();
/// The axis with that key, or the only one whose key begins so, in large letters or small; nullptr otherwise.
[[nodiscard]] const drive::AxisKind* shipped_axis(std::string_view word);

/// Whether what a person gave as the axis means a file of his own, not a key.
[[nodiscard]] bool names_axis_file(std::string_view word);
/// "is no axis that ships; ..." with all keys.
[[nodiscard]] std::string unknown_axis();

}  // namespace servobus::adapter
