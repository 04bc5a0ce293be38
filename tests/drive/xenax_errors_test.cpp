#include "drive/xenax_errors.hpp"

#include <gtest/gtest.h>

#include <cctype>
#include <set>
#include <string>

namespace servobus::drive::xenax {
namespace {

TEST(XenaxErrors, FindsAMessageByNumberAndByName) {
    const Message* const error = find_message(50);
    ASSERT_NE(error, nullptr);
    EXPECT_EQ(error->name, "following_error");
    EXPECT_EQ(error->severity, Severity::error);
    EXPECT_EQ(find_message("following_error"), error);
    EXPECT_EQ(&message("following_error"), error);
}

TEST(XenaxErrors, EveryMessageIsFoundByBothKeys) {
    for (const Message& row : message_table) {
        EXPECT_EQ(find_message(row.number), &row);
        EXPECT_EQ(find_message(row.name), &row);
    }
}

TEST(XenaxErrors, KnowsNoOtherNumberAndNoOtherName) {
    for (const std::int64_t number : {-1, 0, 1, 51, 99, 100, 256 + 50}) EXPECT_EQ(find_message(number), nullptr);
    EXPECT_EQ(find_message(""), nullptr);
    EXPECT_EQ(find_message("Following_Error"), nullptr);
}

TEST(XenaxErrors, TextIsThatOfTheTable) {
    EXPECT_EQ(error_text(0), "no error");
    EXPECT_EQ(error_text(50), find_message(50)->text);
    EXPECT_EQ(error_text(51), "unknown number");
    EXPECT_EQ(error_text(-1), "unknown number");
}

TEST(XenaxErrors, CodeIsTheNumberInTheVendorsRange) {
    EXPECT_EQ(error_code(0), 0);
    EXPECT_EQ(error_code(1), 0xFF01);
    EXPECT_EQ(error_code(50), 0xFF32);
    EXPECT_EQ(error_code(99), 0xFF63);
}

TEST(XenaxErrors, NamesAreIdentifiersAndTextsAreWrittenOnce) {
    std::set<std::string_view> texts;
    for (const Message& row : message_table) {
        EXPECT_TRUE(std::isalpha(static_cast<unsigned char>(row.name.front()))) << row.name;
        for (const char c : row.name) {
            EXPECT_TRUE(c == '_' || std::isdigit(static_cast<unsigned char>(c)) ||
                        std::islower(static_cast<unsigned char>(c)))
                << row.name;
        }
        EXPECT_NE(row.text.back(), '.') << row.name;
        EXPECT_TRUE(texts.insert(row.text).second) << row.text;
    }
}

TEST(XenaxErrors, HasWhatCanHappenToTheDrive) {
    for (const char* const name : {"over_temperature_motor",
                                   "over_temperature_power_stage",
                                   "i2t",
                                   "under_voltage",
                                   "over_voltage",
                                   "power_stage_dropped_out",
                                   "encoder_lost",
                                   "encoder_plausibility",
                                   "negative_limit_switch",
                                   "positive_limit_switch",
                                   "emergency_exit",
                                   "sto",
                                   "ss1",
                                   "ss2",
                                   "sls",
                                   "reference_mark_not_found",
                                   "reference_sensor_not_found",
                                   "reference_missing",
                                   "force_calibration_failed",
                                   "following_error",
                                   "jog_in_gantry",
                                   "soft_limit",
                                   "program_empty",
                                   "profile_empty",
                                   "command_not_now"}) {
        EXPECT_NE(find_message(name), nullptr) << name;
    }
}

TEST(XenaxErrors, ReactsAsTheCauseAllows) {
    // Without encoder or supply nothing can be ramped down; a safe torque off must not wait.
    for (const char* const name : {"encoder_lost", "under_voltage", "power_stage_dropped_out", "sto"}) {
        EXPECT_EQ(find_message(name)->reaction, Reaction::power_off) << name;
    }
    EXPECT_EQ(message("emergency_exit").reaction, Reaction::ramp_down);
    EXPECT_EQ(message("emergency_exit_power_on").reaction, Reaction::stop);
    EXPECT_EQ(message("soft_limit").reaction, Reaction::none);
}

TEST(XenaxErrors, TheMoreSevereIsShownAndOfEqualsTheFirst) {
    EXPECT_TRUE(outranks(message("following_error"), message("jog_in_gantry")));
    EXPECT_TRUE(outranks(message("jog_in_gantry"), message("soft_limit")));
    EXPECT_FALSE(outranks(message("soft_limit"), message("jog_in_gantry")));
    EXPECT_FALSE(outranks(message("encoder_lost"), message("following_error")));
}

}  // namespace
}  // namespace servobus::drive::xenax
