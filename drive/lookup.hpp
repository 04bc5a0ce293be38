// Finding rows the way people name them: `SCurve`, `ts`, `drive.Controlword`, "Tell Status", `AC`.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drive/device.hpp"
#include "drive/parameter.hpp"
#include "drive/xenax.hpp"

namespace servobus::drive {

/// Rows that `what` names. Case, blanks and punctuation do not count; name, mnemonic, and mnemonic followed by
/// name all match; a class prefix or class number before a dot narrows it (`drive.AC`, `0x66.AC`).
/// A full name wins over a mnemonic. When several addresses of one variable (Parameter::same_as) match, they count as
/// one answer: the row that owns the variable. So `AC` is drive.Acceleration..., and `command.AC` the second address.
/// Empty: no such row. More than one: the name needs its class.
[[nodiscard]] std::vector<const Parameter*> find_by_name(std::span<const Parameter> table,
                                                         std::span<const ParameterClass> classes,
                                                         std::string_view what);

/// Up to `count` names that look most like `what`, best first, for "did you mean".
[[nodiscard]] std::vector<std::string> nearest_names(std::span<const Parameter> table,
                                                     std::span<const ParameterClass> classes, std::string_view what,
                                                     std::size_t count = 3);

/// `drive.Controlword`: what find_by_name resolves to exactly this row. Names are unique within a class.
[[nodiscard]] std::string qualified_name(std::span<const ParameterClass> classes, const Parameter& row);

/// The direct command that a mnemonic, a name or a number names, or nullptr.
[[nodiscard]] const DirectCommand* find_command(std::span<const DirectCommand> commands, std::string_view what);
[[nodiscard]] std::vector<std::string> nearest_commands(std::span<const DirectCommand> commands, std::string_view what,
                                                        std::size_t count = 3);

}  // namespace servobus::drive
