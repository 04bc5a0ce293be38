// Axes from files: those that ship, and what is refused in those of users.
#include "adapter/axis_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "adapter/config.hpp"
#include "adapter/shipped_axis_files.hpp"
#include "tests/support/places.hpp"

namespace servobus::adapter {
namespace {

using drive::AxisKind;
using nlohmann::json;
using testing::HasSubstr;

/// `line:column: reason`, or "accepted".
std::string problem(const std::string& text) {
    const auto parsed = parse_axis(text);
    const auto* error = std::get_if<FileError>(&parsed);
    if (error == nullptr) return "accepted";
    return std::to_string(error->line) + ':' + std::to_string(error->column) + ": " + error->reason;
}

/// A whole axis, linear or rotative; a test changes one thing in it.
json good(std::string_view key = default_axis) {
    for (const auto& file : shipped_axis_files()) {
        auto axis = json::parse(file.text);
        if (axis.at("key") == key) return axis;
    }
    ADD_FAILURE() << key << " does not ship";
    return {};
}
json good_turning() { return good("rotax-rxvp-28t0-04"); }

/// The reason alone, when these members are put into an axis.
std::string reason(json axis, const json& changes) {
    axis.update(changes);
    const auto parsed = parse_axis(axis.dump());
    const auto* error = std::get_if<FileError>(&parsed);
    return error != nullptr ? error->reason : "accepted";
}

TEST(ShippedAxes, AreAllFilesOfTheFolderAndAllSound) {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(test::data_path("../drive/axes"))) {
        if (entry.path().extension() != ".json") continue;
        ++count;
        std::ifstream stream(entry.path(), std::ios::binary);
        const std::string text(std::istreambuf_iterator<char>(stream), {});
        EXPECT_EQ(problem(text), "accepted") << entry.path();
        EXPECT_NE(shipped_axis(entry.path().stem().string()), nullptr) << "a file has the name of its key";
        EXPECT_EQ(std::ranges::count(shipped_axis_files(), std::string_view(text), &ShippedAxisFile::text), 1)
            << entry.path() << " is not in the program as it is";
    }
    EXPECT_GT(count, 0U);
    EXPECT_EQ(shipped_axes().size(), count);
    EXPECT_EQ(shipped_axis_files().size(), count);
}

TEST(ShippedAxes, TheDefaultIsThatOfTheType) {
    const auto* axis = shipped_axis(default_axis);
    ASSERT_NE(axis, nullptr);
    const AxisKind standard;
    EXPECT_EQ(axis->key, standard.key);
    EXPECT_EQ(axis->name, standard.name);
    EXPECT_DOUBLE_EQ(axis->increments_per_unit, standard.increments_per_unit);
    EXPECT_DOUBLE_EQ(axis->stop_positive, standard.stop_positive);
    EXPECT_EQ(shipped_axis("linax"), nullptr) << "two begin so";
    EXPECT_EQ(shipped_axis(""), nullptr);
    ASSERT_NE(shipped_axis("ELAX"), nullptr);
    EXPECT_EQ(shipped_axis("ELAX")->key, "elax-ex-50f20");
}

TEST(AxisFile, TakesEveryMember) {
    const auto parsed = parse_axis(R"({
        "key": "press-7", "name": "Press 7", "motor_type": "999", "family": "third_party", "motion": "rotative",
        "reference": "absolute", "increments_per_unit": 1, "moving_mass": 2, "force_constant": 3, "peak_current": 5,
        "nominal_current": 4, "resistance": 6.5, "inductance": 7e-3, "supply_voltage": 8, "friction_static": 9,
        "friction_dynamic": 8.5, "friction_viscous": 10, "cogging": 11, "cogging_period": 12, "has_stops": true,
        "stop_negative": -13, "stop_positive": 14, "stop_stiffness": 15, "start_position": 1, "travel": 16,
        "mark_distance": 17, "increments_per_turn": 100, "z_mark": 18, "sensor_position": 19, "sensor_width": 20,
        "pole_pairs": 21, "thermal_resistance": 22, "thermal_time": 23, "temperature_limit": 24,
        "sources": {"peak_current": "the type plate"}})");
    ASSERT_TRUE(std::holds_alternative<AxisKind>(parsed));
    const auto& axis = std::get<AxisKind>(parsed);
    EXPECT_EQ(axis.key, "press-7");
    EXPECT_EQ(axis.name, "Press 7");
    EXPECT_EQ(axis.motor_type, "999");
    EXPECT_EQ(axis.family, AxisKind::Family::third_party);
    EXPECT_EQ(axis.motion, AxisKind::Motion::rotative);
    EXPECT_EQ(axis.reference, AxisKind::Reference::absolute);
    const std::vector<double> numbers{axis.increments_per_unit, axis.moving_mass,         axis.force_constant,
                                      axis.peak_current,        axis.nominal_current,     axis.resistance,
                                      axis.inductance,          axis.supply_voltage,      axis.friction_static,
                                      axis.friction_dynamic,    axis.friction_viscous,    axis.cogging,
                                      axis.cogging_period,      axis.stop_negative,       axis.stop_positive,
                                      axis.stop_stiffness,      axis.start_position,      axis.travel,
                                      axis.mark_distance,       axis.increments_per_turn, axis.z_mark,
                                      axis.sensor_position,     axis.sensor_width,        axis.thermal_resistance,
                                      axis.thermal_time,        axis.temperature_limit};
    EXPECT_EQ(numbers, (std::vector<double>{1,   2,  3,  5, 4,  6.5, 7e-3, 8,  9,  8.5, 10, 11, 12,
                                            -13, 14, 15, 1, 16, 17,  100,  18, 19, 20,  22, 23, 24}));
    EXPECT_TRUE(axis.has_stops);
    EXPECT_EQ(axis.pole_pairs, 21);
}

TEST(AxisFile, ErrorsHaveTheirPlace) {
    EXPECT_EQ(problem("{\n  \"name\": 5}"), "2:3: 'name' must be a text");
    EXPECT_EQ(problem("[]"), "1:1: the file must hold one object in braces");
    EXPECT_EQ(problem("{\"key\": \"a\",\n \"key\": \"a\"}"), "2:2: 'key' stands here a second time");
    EXPECT_THAT(problem("{\"mass\": 1}"), HasSubstr("1:2: 'mass' is not a setting; here may stand: cogging, "));
    EXPECT_EQ(problem("{\"key\": 1e999}").substr(0, 5), "1:13:");
}

TEST(AxisFile, EveryMemberMustBeThereSaveTheSources) {
    const auto whole = good();
    for (const auto& [key, value] : whole.items()) {
        auto axis = whole;
        axis.erase(key);
        EXPECT_EQ(problem(axis.dump()), key == "sources" ? "accepted" : "1:1: '" + key + "' is missing");
    }
}

TEST(AxisFile, TextsAndWords) {
    EXPECT_EQ(reason(good(), {{"key", "Press 7"}}), "'key' must be a text of small letters, digits and dashes");
    EXPECT_EQ(reason(good(), {{"key", ""}}), "'key' must be a text of small letters, digits and dashes");
    EXPECT_EQ(reason(good(), {{"motor_type", ""}}), "'motor_type' must be a text");
    EXPECT_EQ(reason(good(), {{"motion", "up"}}), "'motion' must be one of \"linear\", \"rotative\"");
    EXPECT_EQ(reason(good(), {{"reference", 1}}),
              "'reference' must be one of \"distance_coded_marks\", \"z_mark\", \"absolute\"");
    EXPECT_EQ(reason(good(), {{"has_stops", 1}}), "'has_stops' must be true or false");
    EXPECT_EQ(reason(good(), {{"pole_pairs", 1.5}}), "'pole_pairs' must be a whole number from 0 to 1000");
    EXPECT_EQ(reason(good(), {{"pole_pairs", 1001}}), "'pole_pairs' must be a whole number from 0 to 1000");
    EXPECT_EQ(reason(good(), {{"pole_pairs", 1000}}), "accepted");
}

TEST(AxisFile, WhatIsDividedByIsAboveZero) {
    for (const auto* key :
         {"increments_per_unit", "moving_mass", "force_constant", "peak_current", "nominal_current", "resistance",
          "inductance", "supply_voltage", "thermal_resistance", "thermal_time", "temperature_limit"}) {
        EXPECT_THAT(reason(good(), {{key, 0}}), HasSubstr("' must be a number above 0, ")) << key;
        EXPECT_THAT(reason(good(), {{key, -1}}), HasSubstr("' must be a number above 0, ")) << key;
        EXPECT_THAT(reason(good(), {{key, 1e12}}), HasSubstr("' must be a number above 0, ")) << key;
        EXPECT_THAT(reason(good(), {{key, "1"}}), HasSubstr("' must be a number above 0, ")) << key;
    }
    EXPECT_EQ(reason(good(), {{"friction_viscous", -0.1}}), "'friction_viscous' must be a number from 0 to 1000000");
    EXPECT_EQ(reason(good(), {{"friction_viscous", 0}}), "accepted");
    EXPECT_EQ(reason(good(), {{"stop_negative", -2147483648.0}}),
              "'stop_negative' must be a number from -2147483647 to 2147483647");
}

TEST(AxisFile, MembersFitEachOther) {
    EXPECT_EQ(reason(good(), {{"start_position", -1500}}),
              "'start_position' must be between stop_negative and "
              "stop_positive");
    EXPECT_EQ(reason(good(), {{"stop_positive", -1500}}),
              "'start_position' must be between stop_negative and "
              "stop_positive");
    EXPECT_EQ(reason(good(), {{"travel", 1e9}}),
              "'travel' must not be longer than from stop_negative to stop_positive");
    EXPECT_EQ(reason(good(), {{"stop_stiffness", 0}}), "'stop_stiffness' must be above 0, since there are stops");
    EXPECT_EQ(reason(good(), {{"nominal_current", 1000}}), "'nominal_current' must not be more than peak_current");
    EXPECT_EQ(reason(good(), {{"friction_static", 0}}), "'friction_dynamic' must not be more than friction_static");
    EXPECT_EQ(reason(good(), {{"mark_distance", 0}}), "'mark_distance' must be above 0 for distance-coded marks");
    EXPECT_EQ(reason(good(), {{"motion", "rotative"}}), "'motion' must be \"linear\" for this family");
    EXPECT_EQ(reason(good_turning(), {{"motion", "linear"}}), "'motion' must be \"rotative\" for this family");
    EXPECT_EQ(reason(good(), {{"increments_per_turn", 1}}), "'increments_per_turn' must be 0 for a linear axis");
    EXPECT_EQ(reason(good_turning(), {{"increments_per_turn", 0}}),
              "'increments_per_turn' must be above 0 for a rotative axis");
    const double turn = good_turning().at("increments_per_turn");
    for (const auto* key : {"z_mark", "sensor_position", "sensor_width"}) {
        EXPECT_THAT(reason(good_turning(), {{key, turn}}), HasSubstr("' must be less than increments_per_turn"));
    }
}

TEST(ChosenAxis, DecidesTheMotorUnlessThatIsGiven) {
    Config config;
    EXPECT_EQ(motor_of(config), drive::Motor::any);
    EXPECT_EQ(axis_of(config).key, default_axis);
    EXPECT_EQ(choose_axis(std::string(default_axis), config), "");
    EXPECT_EQ(motor_of(config), drive::Motor::linear);
    EXPECT_EQ(choose_axis("rotax-rxvp-28t0-04", config), "");
    EXPECT_EQ(motor_of(config), drive::Motor::rotative);
    EXPECT_EQ(make_device(config).motor(), drive::Motor::rotative);
    config.motor = drive::Motor::any;
    EXPECT_EQ(motor_of(config), drive::Motor::any);
}

TEST(ChosenAxis, ThatDoesNotShipIsRefusedWithTheKeys) {
    Config config;
    EXPECT_THAT(choose_axis("linax", config), testing::StartsWith("must be the name of a .json file, or one of "));
    EXPECT_THAT(choose_axis("linax", config), HasSubstr("linax-lxc-230f10"));
    EXPECT_FALSE(config.axis || config.axis_file);
}

TEST(ChosenAxis, OfAFileIsReadFromIt) {
    const auto path = std::filesystem::path(testing::TempDir()) / "servobus_axis_file_test.json";
    auto axis = good();
    axis["key"] = "mine";
    std::ofstream(path) << axis.dump();
    Config config;
    EXPECT_EQ(choose_axis(path.string(), config), "");
    EXPECT_FALSE(load_axis(config));
    ASSERT_TRUE(config.axis);
    EXPECT_EQ(config.axis->key, "mine");
    std::ofstream(path) << "{}";
    EXPECT_EQ(choose_axis(path.string(), config), "");
    EXPECT_FALSE(config.axis) << "what was chosen before does not count any more";
    ASSERT_TRUE(load_axis(config));
    std::filesystem::remove(path);
    EXPECT_EQ(load_axis(config)->reason, "cannot be read");
}

}  // namespace
}  // namespace servobus::adapter
