// The axes that ship, for the tests of the machine. The files are flat: one member on a line.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "drive/axis_kind.hpp"
#include "tests/support/places.hpp"

namespace servobus::drive {

using Members = std::map<std::string, std::string>;

inline Members read_members(const std::filesystem::path& path) {
    std::ifstream file(path);
    Members members;
    for (std::string line; std::getline(file, line);) {
        const auto key = line.find('"');
        const auto colon = line.find("\": ");
        if (key == std::string::npos || colon == std::string::npos) {
            continue;
        }
        std::string value = line.substr(colon + 3);
        value.erase(std::remove(value.begin(), value.end(), '"'), value.end());
        if (value.ends_with(',')) {
            value.pop_back();
        }
        members[line.substr(key + 1, colon - key - 1)] = value;
    }
    return members;
}

inline AxisKind::Family family_named(const std::string& name) {
    static const std::map<std::string, AxisKind::Family> names{{"linax", AxisKind::Family::linax},
                                                               {"elax", AxisKind::Family::elax},
                                                               {"rotax_rxvp", AxisKind::Family::rotax_rxvp},
                                                               {"rotax_rxhq", AxisKind::Family::rotax_rxhq},
                                                               {"third_party", AxisKind::Family::third_party}};
    return names.at(name);
}

inline AxisKind::Reference reference_named(const std::string& name) {
    static const std::map<std::string, AxisKind::Reference> names{
        {"distance_coded_marks", AxisKind::Reference::distance_coded_marks},
        {"z_mark", AxisKind::Reference::z_mark},
        {"absolute", AxisKind::Reference::absolute}};
    return names.at(name);
}

inline const std::vector<std::pair<std::string, double AxisKind::*>>& numbers_of_axes() {
    static const std::vector<std::pair<std::string, double AxisKind::*>> numbers{
        {"increments_per_unit", &AxisKind::increments_per_unit},
        {"moving_mass", &AxisKind::moving_mass},
        {"force_constant", &AxisKind::force_constant},
        {"peak_current", &AxisKind::peak_current},
        {"nominal_current", &AxisKind::nominal_current},
        {"resistance", &AxisKind::resistance},
        {"inductance", &AxisKind::inductance},
        {"supply_voltage", &AxisKind::supply_voltage},
        {"friction_static", &AxisKind::friction_static},
        {"friction_dynamic", &AxisKind::friction_dynamic},
        {"friction_viscous", &AxisKind::friction_viscous},
        {"cogging", &AxisKind::cogging},
        {"cogging_period", &AxisKind::cogging_period},
        {"stop_negative", &AxisKind::stop_negative},
        {"stop_positive", &AxisKind::stop_positive},
        {"stop_stiffness", &AxisKind::stop_stiffness},
        {"start_position", &AxisKind::start_position},
        {"travel", &AxisKind::travel},
        {"mark_distance", &AxisKind::mark_distance},
        {"increments_per_turn", &AxisKind::increments_per_turn},
        {"z_mark", &AxisKind::z_mark},
        {"sensor_position", &AxisKind::sensor_position},
        {"sensor_width", &AxisKind::sensor_width},
        {"thermal_resistance", &AxisKind::thermal_resistance},
        {"thermal_time", &AxisKind::thermal_time},
        {"temperature_limit", &AxisKind::temperature_limit}};
    return numbers;
}

inline AxisKind axis_of(const Members& members) {
    AxisKind kind;
    kind.key = members.at("key");
    kind.name = members.at("name");
    kind.motor_type = members.at("motor_type");
    kind.family = family_named(members.at("family"));
    kind.motion = members.at("motion") == "linear" ? AxisKind::Motion::linear : AxisKind::Motion::rotative;
    kind.reference = reference_named(members.at("reference"));
    kind.has_stops = members.at("has_stops") == "true";
    kind.pole_pairs = std::stoi(members.at("pole_pairs"));
    for (const auto& [name, member] : numbers_of_axes()) {
        kind.*member = std::stod(members.at(name));
    }
    return kind;
}

/// By key.
inline std::vector<AxisKind> shipped_kinds() {
    std::vector<AxisKind> kinds;
    for (const auto& entry : std::filesystem::directory_iterator(test::data_path("../drive/axes"))) {
        kinds.push_back(axis_of(read_members(entry.path())));
    }
    std::ranges::sort(kinds, {}, &AxisKind::key);
    return kinds;
}

inline AxisKind shipped_kind(const std::string& key) {
    for (const AxisKind& kind : shipped_kinds()) {
        if (kind.key == key) {
            return kind;
        }
    }
    throw std::out_of_range(key);
}

}  // namespace servobus::drive
