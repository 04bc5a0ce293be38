#include "drive/value_names.hpp"

#include <algorithm>
#include <array>

#include "drive/mode.hpp"

namespace servobus::drive {
namespace {

constexpr Key requested_mode{0x66, 0x20};
constexpr Key displayed_mode{0x66, 0x21};

// clang-format off
constexpr std::array modes{
    ValueName{-2, "reserved mode"},
    ValueName{mode::jog, "jog mode"},
    ValueName{mode::none, "no mode"},
    ValueName{mode::profile_position, "profile position mode"},
    ValueName{mode::reference, "reference mode"},
    ValueName{mode::cyclic_position, "cyclic synchronous position mode"},
};

constexpr std::array methods{
    ValueName{1,  "start positive"},
    ValueName{2,  "start negative"},
    ValueName{3,  "gantry, start positive, same orientation"},
    ValueName{4,  "gantry, start negative, same orientation"},
    ValueName{5,  "gantry, start positive, contrary orientation"},
    ValueName{6,  "gantry, start negative, contrary orientation"},
    ValueName{10, "start clockwise, then counter clockwise to the Z-mark"},
    ValueName{11, "start clockwise, then clockwise to the Z-mark"},
    ValueName{12, "start counter clockwise, then counter clockwise to the Z-mark"},
    ValueName{13, "start counter clockwise, then clockwise to the Z-mark"},
    ValueName{14, "start clockwise, then the shortest way to the Z-mark"},
    ValueName{15, "start counter clockwise, then the shortest way to the Z-mark"},
};
// clang-format on

}  // namespace

std::span<const ValueName> mode_names() { return modes; }

std::span<const ValueName> reference_method_names() { return methods; }

std::string_view name_of(std::span<const ValueName> names, std::int64_t value) {
    const auto found = std::ranges::find(names, value, &ValueName::value);
    return found != names.end() ? found->name : std::string_view();
}

std::vector<ValueName> value_names(const Model& model, const Parameter& row) {
    std::vector<ValueName> names;
    if (row.key() == model.direct_command_row) {
        for (const auto& command : model.direct_commands) names.push_back({command.value, command.name});
        return names;
    }
    const bool is_mode = row.key() == requested_mode || row.key() == displayed_mode;
    const bool is_method = row.key() == model.reference_method_row;
    if (!is_mode && !is_method) return names;
    const auto all = is_mode ? mode_names() : reference_method_names();
    for (const auto value : row.allowed) names.push_back({value, name_of(all, value)});
    return names;
}

}  // namespace servobus::drive
