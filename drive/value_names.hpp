// What the numbers of a parameter with listed values stand for, in a few words.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "drive/device.hpp"
#include "drive/parameter.hpp"

namespace servobus::drive {

struct ValueName {
    std::int64_t value;
    std::string_view name;
};

/// The modes of operation by number (000 §2.3.4.3, 004 §4.2.4): "profile position mode".
[[nodiscard]] std::span<const ValueName> mode_names();

/// The reference methods by number (000 §2.3.4.16, 004 §4.2.19): "start positive".
[[nodiscard]] std::span<const ValueName> reference_method_names();

/// The name of a value, or empty.
[[nodiscard]] std::string_view name_of(std::span<const ValueName> names, std::int64_t value);

/// The legal numbers of a row (Parameter::allowed) by name, in their order; empty for a row without such a list.
[[nodiscard]] std::vector<ValueName> value_names(const Model& model, const Parameter& row);

}  // namespace servobus::drive
