#include "drive/xenax.hpp"

#include <algorithm>
#include <array>

#include "drive/xenax_drive.hpp"
#include "drive/xenax_table.hpp"

namespace servobus::drive {

namespace {

using xenax::direct_command_table;
using xenax::parameter_table;

constexpr std::array<ParameterClass, 7> class_table{{
    {0x64, "general", "XENAX General Parameter"},
    {0x65, "command", "XENAX Command"},
    {0x66, "drive", "XENAX Drive Parameter"},
    {0x67, "drive67", "XENAX Drive Parameter, read only"},
    {0x68, "drive68", "XENAX Drive Parameter, settings"},
    {0x69, "drive69", "XENAX Drive Parameter, texts"},
    {0x6E, "forceteq", "Forceteq pro Parameter"},
}};

// What the rest of the program relies on, proved while compiling.

// Indices instead of pointers: gcc 12 with the sanitizers takes no comparison of these pointers for a constant.
constexpr std::size_t nowhere = parameter_table.size();

constexpr std::size_t index_at(Key key) {
    std::size_t index = 0;
    while (index < parameter_table.size() && parameter_table[index].key() != key) {
        ++index;
    }
    return index;
}

constexpr auto rows_of(std::uint16_t class_id) {
    return std::ranges::count(parameter_table, class_id, [](const Parameter& row) { return row.cip.class_id; });
}

constexpr bool keys_ascend() {
    return std::ranges::adjacent_find(parameter_table, std::ranges::greater_equal{}, &Parameter::key) ==
           parameter_table.end();
}

constexpr bool names_differ_within_a_class() {
    for (auto row = parameter_table.begin(); row != parameter_table.end(); ++row) {
        for (auto other = row + 1; other != parameter_table.end() && other->cip.class_id == row->cip.class_id;
             ++other) {
            if (row->name == other->name) {
                return false;
            }
        }
    }
    return true;
}

constexpr bool is_described(const Parameter& row) {
    return !row.name.empty() && !row.section.empty() && !row.text.empty();
}

constexpr bool limits_are_legal(const Parameter& row) {
    if (row.is_text()) {
        return row.standard_text.size() <= row.max_length && row.low == 0 && row.standard == 0 && row.high == 0;
    }
    return lowest(row.cip.type) <= row.low && row.low <= row.standard && row.standard <= row.high &&
           row.high <= highest(row.cip.type) && row.standard_text.empty() && row.max_length == 0;
}

/// A readable row starts with one of its legal values; a command has none before it is written.
constexpr bool listed_values_are_legal(const Parameter& row) {
    const bool inside =
        std::ranges::all_of(row.allowed, [&row](std::int64_t value) { return row.low <= value && value <= row.high; });
    const bool starts_legal = row.allowed.empty() || !may_get(row.access) ||
                              std::ranges::find(row.allowed, row.standard) != row.allowed.end();
    return inside && starts_legal;
}

constexpr bool od_limits_are_legal(const Parameter& row) {
    if (!row.od || row.is_text()) {
        return !row.od || row.od->type == Type::text;
    }
    const std::int64_t low = row.od->low.value_or(row.low);
    const std::int64_t standard = row.od->standard.value_or(row.standard);
    const std::int64_t high = row.od->high.value_or(row.high);
    return lowest(row.od->type) <= low && low <= standard && standard <= high && high <= highest(row.od->type);
}

/// What does not behave says why; only what can be set is stored, and only what can be read is fixed.
constexpr bool fidelity_is_explained(const Parameter& row) {
    switch (row.fidelity) {
        case Fidelity::behaves:
            return true;
        case Fidelity::stored:
            return !row.remark.empty() && may_set(row.access);
        case Fidelity::fixed:
            return !row.remark.empty() && (row.access == Access::get || row.low == row.high);
    }
    return false;
}

constexpr bool second_address_is_sound(const Parameter& row) {
    if (!row.same_as) {
        return true;
    }
    const std::size_t index = index_at(*row.same_as);
    if (index == nowhere) {
        return false;
    }
    const Parameter& owner = parameter_table[index];
    return !owner.same_as && owner.standard == row.standard && owner.is_text() == row.is_text() &&
           owner.access == row.access && owner.unit == row.unit && owner.force_option == row.force_option &&
           owner.fidelity == row.fidelity && !row.selected_by;
}

constexpr bool selection_is_sound(const Parameter& row) {
    if (!row.selected_by) {
        return row.elements == 1;
    }
    const std::size_t index = index_at(*row.selected_by);
    if (index == nowhere) {
        return false;
    }
    const Parameter& selector = parameter_table[index];
    return !selector.selected_by && !selector.same_as && !selector.is_text() &&
           row.elements == selector.high - selector.low + 1;
}

static_assert(rows_of(0x64) == 8 && rows_of(0x65) == 188 && rows_of(0x66) == 24 && rows_of(0x67) == 3 &&
              rows_of(0x68) == 9 && rows_of(0x69) == 2 && rows_of(0x6E) == 16);
static_assert(keys_ascend());
static_assert(names_differ_within_a_class());
static_assert(std::ranges::all_of(parameter_table, is_described));
static_assert(std::ranges::all_of(parameter_table, limits_are_legal));
static_assert(std::ranges::all_of(parameter_table, listed_values_are_legal));
static_assert(std::ranges::all_of(parameter_table, od_limits_are_legal));
static_assert(std::ranges::all_of(parameter_table, second_address_is_sound));
static_assert(std::ranges::all_of(parameter_table, selection_is_sound));
static_assert(std::ranges::all_of(parameter_table, fidelity_is_explained));
static_assert(std::ranges::adjacent_find(direct_command_table, std::ranges::greater_equal{}, &DirectCommand::value) ==
              direct_command_table.end());

Model variant(std::string_view key, std::uint16_t product_code, std::string_view name, bool has_force_option) {
    return {
        .key = key,
        .name = name,
        .identity =
            {
                .vendor = 1389,     // Jenny Science AG
                .device_type = 43,  // generic device
                .product_code = product_code,
                .major_revision = 1,
                .minor_revision = 1,
                .serial_number = 0x00A1B2C3,
                .product_name = std::string(name),
            },
        .parameters = parameter_table,
        .direct_commands = direct_command_table,
        .direct_command_row = Key{0x65, 0x00},
        .reference_method_row = Key{0x66, 0x58},
        .has_force_option = has_force_option,
        .motor_names = MotorNames{.row = {0x64, 0x08}, .linear = "230101", .rotative = "rotative"},
        .make_behaviour = &XenaxDrive::make,
    };
}

}  // namespace

std::span<const Parameter> parameters() { return parameter_table; }

std::span<const DirectCommand> direct_commands() { return direct_command_table; }

std::span<const Model> xenax_models() {
    static const std::array<Model, 3> models{
        variant("75v8s", 0x7509, "XENAX Xvi 75V8S", true),
        variant("75v8", 0x7508, "XENAX Xvi 75V8", false),
        variant("48v8", 0x4808, "XENAX Xvi 48V8", false),
    };
    return models;
}

std::optional<Model> xenax_model(std::string_view key) {
    const auto models = xenax_models();
    const auto found = std::ranges::find(models, key, &Model::key);
    return found == models.end() ? std::nullopt : std::optional<Model>(*found);
}

std::span<const ParameterClass> parameter_classes() { return class_table; }

}  // namespace servobus::drive
