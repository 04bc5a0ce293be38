#include "adapter/axis_file.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>
#include <vector>

#include "adapter/json_settings.hpp"
#include "adapter/shipped_axis_files.hpp"

namespace servobus::adapter {
namespace {

using drive::AxisKind;
using nlohmann::json;

template <class Meaning, std::size_t Count>
using Words = std::array<std::pair<std::string_view, Meaning>, Count>;

constexpr Words<AxisKind::Family, 5> families{{
    {"linax", AxisKind::Family::linax},
    {"elax", AxisKind::Family::elax},
    {"rotax_rxvp", AxisKind::Family::rotax_rxvp},
    {"rotax_rxhq", AxisKind::Family::rotax_rxhq},
    {"third_party", AxisKind::Family::third_party},
}};
constexpr Words<AxisKind::Motion, 2> motions{{
    {"linear", AxisKind::Motion::linear},
    {"rotative", AxisKind::Motion::rotative},
}};
constexpr Words<AxisKind::Reference, 3> references{{
    {"distance_coded_marks", AxisKind::Reference::distance_coded_marks},
    {"z_mark", AxisKind::Reference::z_mark},
    {"absolute", AxisKind::Reference::absolute},
}};

// Far more than a motor has, and few enough that nothing the machine reckons with them overflows.
constexpr double max_increments = 2'147'483'647;  // what a position on the bus holds
constexpr double max_resolution = 1e10;           // increments to a metre or radian
constexpr double max_quantity = 1e6;              // of what has a unit: kg, N, A, ohm, s, ...
constexpr double max_stiffness = 1e12;
constexpr int max_pole_pairs = 1000;

// Small letters, digits and dashes: what can be typed and be a file's name.
Setter key_setter(std::string& target) {
    return [&target](const json& value) -> Reason {
        constexpr std::string_view legal = "abcdefghijklmnopqrstuvwxyz0123456789-";
        const auto word = value.is_string() ? value.get<std::string>() : std::string();
        if (word.empty() || word.find_first_not_of(legal) != std::string::npos) {
            return "must be a text of small letters, digits and dashes";
        }
        target = word;
        return {};
    };
}

Setters identity_setters(AxisKind& axis) {
    return {
        {"key", key_setter(axis.key)},
        {"name", text(axis.name)},
        {"motor_type", text(axis.motor_type)},
        {"family", one_of(axis.family, families)},
        {"motion", one_of(axis.motion, motions)},
        {"reference", one_of(axis.reference, references)},
    };
}

Setters motor_setters(AxisKind& axis) {
    const auto quantity = above_to(0, max_quantity);
    return {
        {"increments_per_unit", number(axis.increments_per_unit, above_to(0, max_resolution))},
        {"moving_mass", number(axis.moving_mass, quantity)},
        {"force_constant", number(axis.force_constant, quantity)},
        {"peak_current", number(axis.peak_current, quantity)},
        {"nominal_current", number(axis.nominal_current, quantity)},
        {"resistance", number(axis.resistance, quantity)},
        {"inductance", number(axis.inductance, quantity)},
        {"supply_voltage", number(axis.supply_voltage, quantity)},
        {"pole_pairs", whole_number(axis.pole_pairs, 0, max_pole_pairs)},
        {"thermal_resistance", number(axis.thermal_resistance, quantity)},
        {"thermal_time", number(axis.thermal_time, quantity)},
        {"temperature_limit", number(axis.temperature_limit, quantity)},
    };
}

Setters mechanics_setters(AxisKind& axis) {
    const auto quantity = from_to(0, max_quantity);
    const auto length = from_to(0, max_increments);
    const auto position = from_to(-max_increments, max_increments);
    return {
        {"friction_static", number(axis.friction_static, quantity)},
        {"friction_dynamic", number(axis.friction_dynamic, quantity)},
        {"friction_viscous", number(axis.friction_viscous, quantity)},
        {"cogging", number(axis.cogging, quantity)},
        {"cogging_period", number(axis.cogging_period, above_to(0, max_increments))},
        {"has_stops", flag(axis.has_stops)},
        {"stop_negative", number(axis.stop_negative, position)},
        {"stop_positive", number(axis.stop_positive, position)},
        {"stop_stiffness", number(axis.stop_stiffness, from_to(0, max_stiffness))},
        {"start_position", number(axis.start_position, position)},
        {"travel", number(axis.travel, length)},
        {"mark_distance", number(axis.mark_distance, length)},
        {"increments_per_turn", number(axis.increments_per_turn, length)},
        {"z_mark", number(axis.z_mark, length)},
        {"sensor_position", number(axis.sensor_position, length)},
        {"sensor_width", number(axis.sensor_width, length)},
    };
}

/// What one member must be because of others; empty key: nothing is wrong.
struct Contradiction {
    std::string key;
    Reason reason;
};

Contradiction wrong_stops(const AxisKind& axis) {
    if (!axis.has_stops) return {};
    if (axis.start_position <= axis.stop_negative || axis.start_position >= axis.stop_positive) {
        return {"start_position", "must be between stop_negative and stop_positive"};
    }
    if (axis.travel > axis.stop_positive - axis.stop_negative) {
        return {"travel", "must not be longer than from stop_negative to stop_positive"};
    }
    if (axis.stop_stiffness <= 0) return {"stop_stiffness", "must be above 0, since there are stops"};
    return {};
}

Contradiction wrong_turn(const AxisKind& axis) {
    const bool rotative = axis.motion == AxisKind::Motion::rotative;
    const bool turns = axis.increments_per_turn > 0;
    if (rotative != turns) {
        return {"increments_per_turn",
                rotative ? "must be above 0 for a rotative axis" : "must be 0 for a linear axis"};
    }
    if (!turns) return {};
    if (axis.z_mark >= axis.increments_per_turn) return {"z_mark", "must be less than increments_per_turn"};
    if (axis.sensor_position >= axis.increments_per_turn) {
        return {"sensor_position", "must be less than increments_per_turn"};
    }
    if (axis.sensor_width >= axis.increments_per_turn) return {"sensor_width", "must be less than increments_per_turn"};
    return {};
}

Contradiction wrong_family(const AxisKind& axis) {
    using Family = AxisKind::Family;
    const bool rotative = axis.motion == AxisKind::Motion::rotative;
    const bool made_linear = axis.family == Family::linax || axis.family == Family::elax;
    const bool made_rotative = axis.family == Family::rotax_rxvp || axis.family == Family::rotax_rxhq;
    if ((made_linear && rotative) || (made_rotative && !rotative)) {
        return {"motion", made_linear ? "must be \"linear\" for this family" : "must be \"rotative\" for this family"};
    }
    return {};
}

Contradiction contradiction(const AxisKind& axis) {
    if (axis.nominal_current > axis.peak_current) return {"nominal_current", "must not be more than peak_current"};
    if (axis.friction_dynamic > axis.friction_static) {
        return {"friction_dynamic", "must not be more than friction_static"};
    }
    if (axis.reference == AxisKind::Reference::distance_coded_marks && axis.mark_distance <= 0) {
        return {"mark_distance", "must be above 0 for distance-coded marks"};
    }
    for (const auto check : {wrong_family, wrong_stops, wrong_turn}) {
        if (auto wrong = check(axis); !wrong.key.empty()) return wrong;
    }
    return {};
}

// A shipped file that cannot be read is not there; the tests read them all.
std::vector<AxisKind> parse_shipped() {
    std::vector<AxisKind> axes;
    for (const auto& file : shipped_axis_files()) {
        auto parsed = parse_axis(std::string(file.text));
        if (auto* axis = std::get_if<AxisKind>(&parsed)) axes.push_back(std::move(*axis));
    }
    std::ranges::sort(axes, {}, &AxisKind::key);
    return axes;
}

}  // namespace

std::variant<AxisKind, FileError> parse_axis(const std::string& text) {
    auto parsed = parse_settings(text);
    if (auto* error = std::get_if<FileError>(&parsed)) return *error;
    const auto& document = std::get<JsonDocument>(parsed);
    AxisKind axis;
    Setters setters = identity_setters(axis);
    setters.merge(motor_setters(axis));
    setters.merge(mechanics_setters(axis));
    std::vector<std::string> required;
    for (const auto& [key, setter] : setters) required.push_back(key);
    setters.emplace("sources", [](const json&) { return Reason(); });
    const Walk walk(document);
    if (auto error = walk.object(document.root, "", setters, required)) return *error;
    if (const auto wrong = contradiction(axis); !wrong.key.empty()) return walk.error("", wrong.key, wrong.reason);
    return axis;
}

std::span<const AxisKind> shipped_axes() {
    static const auto axes = parse_shipped();
    return axes;
}

const AxisKind* shipped_axis(std::string_view word) {
    std::string key(word);
    for (auto& letter : key) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    const auto begins = [&](const AxisKind& axis) { return !key.empty() && axis.key.starts_with(key); };
    const auto axes = shipped_axes();
    const auto found = std::ranges::find_if(axes, begins);
    if (found == axes.end()) return nullptr;
    const bool alone = found->key == key || std::none_of(found + 1, axes.end(), begins);
    return alone ? &*found : nullptr;
}

bool names_axis_file(std::string_view word) {
    return word.ends_with(".json") || word.find('/') != std::string_view::npos;
}

std::string unknown_axis() {
    std::string keys;
    for (const auto& axis : shipped_axes()) keys += fmt::format("{}{}", keys.empty() ? "" : ", ", axis.key);
    return fmt::format("must be the name of a .json file, or one of {}", keys);
}

}  // namespace servobus::adapter
