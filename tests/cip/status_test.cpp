// Every status code that the reference prints has a text.
#include "cip/status.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <set>
#include <string>

#include "cip/decode_error.hpp"
#include "tests/support/octets.hpp"

namespace servobus::cip {
namespace {

TEST(Status, R_ERR_12_every_printed_general_status_has_a_text_of_its_own) {
    std::set<std::string_view> seen;
    for (unsigned code = 0x00; code <= 0x2E; ++code) {
        const auto words = text(static_cast<GeneralStatus>(code));
        EXPECT_FALSE(words.empty()) << code;
        EXPECT_NE(words, "reserved") << code;
        EXPECT_TRUE(seen.insert(words).second) << words;
    }
    for (unsigned code = 0x2F; code < 0xD0; ++code)
        EXPECT_EQ(text(static_cast<GeneralStatus>(code)), "reserved") << code;
    for (unsigned code = 0xD0; code <= 0xFF; ++code) {
        EXPECT_EQ(text(static_cast<GeneralStatus>(code)), "object class specific error") << code;
    }
}

// The codes of R-CON-40, as ranges.
constexpr std::array<std::pair<unsigned, unsigned>, 10> printed{{{0x0100, 0x0100},
                                                                 {0x0103, 0x0103},
                                                                 {0x0106, 0x0109},
                                                                 {0x0110, 0x0139},
                                                                 {0x0203, 0x0207},
                                                                 {0x0301, 0x0306},
                                                                 {0x0311, 0x0312},
                                                                 {0x0315, 0x031F},
                                                                 {0x0800, 0x080F},
                                                                 {0x0810, 0x0814}}};

TEST(Status, R_CON_40_every_printed_connection_failure_has_a_text_and_no_other_has) {
    const auto is_printed = [](unsigned word) {
        return std::ranges::any_of(printed, [&](auto range) { return word >= range.first && word <= range.second; });
    };
    for (unsigned word = 0; word <= 0xFFFF; ++word) {
        const auto words = extended_text(GeneralStatus::connection_failure, static_cast<std::uint16_t>(word));
        EXPECT_EQ(!words.empty(), is_printed(word)) << std::hex << word;
    }
}

TEST(Status, R_DEV_3_the_drives_refusal_has_a_text) {
    EXPECT_NE(extended_text(GeneralStatus::vendor_specific, drive_refuses), "");
    EXPECT_EQ(extended_text(GeneralStatus::vendor_specific, 2), "");
}

TEST(Status, R_ERR_12_an_extended_word_means_something_only_with_its_general_status) {
    EXPECT_EQ(extended_text(GeneralStatus::success, 0x0106), "");
    EXPECT_EQ(extended_text(GeneralStatus::invalid_parameter, 0x0001), "");
}

TEST(Status, describes_itself_for_people) {
    EXPECT_EQ(describe(GeneralStatus::attribute_not_settable), "0x0E attribute not settable");
    EXPECT_EQ(describe(ConnectionFailure::ownership_conflict), "0x01 connection failure, 0x0106 ownership conflict");
    EXPECT_EQ(describe(Status(GeneralStatus::connection_failure, {0x0127, 24})),
              "0x01 connection failure, 0x0127 invalid O->T size 0x0018");
    EXPECT_EQ(describe(Status(GeneralStatus::invalid_parameter, {8})), "0x20 invalid parameter, extended 0x0008");
    EXPECT_EQ(describe(static_cast<GeneralStatus>(0xD0)), "0xD0 object class specific error");
}

TEST(Status, R_ERR_12_a_connection_failure_is_general_status_1_with_one_word) {
    const Status status = ConnectionFailure::connection_not_found;
    EXPECT_EQ(status.general, GeneralStatus::connection_failure);
    EXPECT_EQ(status.extended, std::vector<std::uint16_t>{0x0107});
    EXPECT_FALSE(status.ok());
    EXPECT_TRUE(Status().ok());
}

TEST(DecodeError, every_error_is_a_sentence_of_its_own) {
    std::set<std::string_view> seen;
    for (const auto error :
         {DecodeError::truncated, DecodeError::trailing, DecodeError::path_too_long, DecodeError::bad_segment,
          DecodeError::bad_length, DecodeError::bad_value, DecodeError::too_many}) {
        EXPECT_TRUE(seen.insert(describe(error)).second);
        EXPECT_NE(describe(error), "unknown decode error");
    }
}

}  // namespace
}  // namespace servobus::cip
