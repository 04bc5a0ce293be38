// The Jenny Science XENAX Xvi: its three variants, its table and its direct commands.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "drive/device.hpp"
#include "drive/parameter.hpp"

namespace servobus::drive {

/// The one table: every attribute of classes 0x64, 0x65, 0x66, 0x67, 0x68, 0x69, 0x6E (000 §2.3), ordered by
/// class, then attribute.
[[nodiscard]] std::span<const Parameter> parameters();

/// The values of 0x65/1/0, ordered by value (000 §2.3.2.1, 004 §3.4.1).
[[nodiscard]] std::span<const DirectCommand> direct_commands();

/// The three variants, first the default: 75v8s, 75v8, 48v8 (000 §2.3.9).
[[nodiscard]] std::span<const Model> xenax_models();

/// A variant by its key, or nullopt.
[[nodiscard]] std::optional<Model> xenax_model(std::string_view key);

/// A class of parameters as the manual groups them: `{0x66, "drive", "XENAX Drive Parameter"}`.
struct ParameterClass {
    std::uint16_t class_id;
    std::string_view prefix;  ///< before the dot in `drive.Controlword`
    std::string_view title;
};
[[nodiscard]] std::span<const ParameterClass> parameter_classes();

}  // namespace servobus::drive
