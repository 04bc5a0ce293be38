// What a request is addressed to, and the electronic key.
#include "cip/request_path.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <string_view>

#include "tests/support/octets.hpp"

namespace servobus::cip {
namespace {

using test::octets;

GeneralStatus status_of(std::string_view path) {
    const auto parsed = RequestPath::parse(octets(path));
    return parsed ? GeneralStatus::success : parsed.error().general;
}

TEST(RequestPath, R_PTH_10_class_instance_attribute) {
    const auto path = RequestPath::parse(octets("20 66 24 01 30 24")).value();
    EXPECT_EQ(path.class_id, 0x66U);
    EXPECT_EQ(path.instance, 1U);
    EXPECT_EQ(path.attribute, 0x24U);
    EXPECT_FALSE(path.key);
}

TEST(RequestPath, R_PTH_10_the_attribute_may_be_left_out) {
    const auto path = RequestPath::parse(octets("20 66 24 01")).value();
    EXPECT_EQ(path.instance, 1U);
    EXPECT_EQ(path.attribute, std::nullopt);
}

TEST(RequestPath, R_DEV_4_attribute_0_is_an_attribute) {
    EXPECT_EQ(RequestPath::parse(octets("20 64 24 01 30 00")).value().attribute, 0U);
}

TEST(RequestPath, R_PTH_3_all_widths_mean_the_same) {
    for (const auto* text :
         {"20 64 24 01 30 06", "21 00 64 00 25 00 01 00 31 00 06 00",
          "22 00 64 00 00 00 26 00 01 00 00 00 32 00 06 00 00 00", "20 64 26 00 01 00 00 00 30 06"}) {
        const auto path = RequestPath::parse(octets(text));
        ASSERT_TRUE(path) << text;
        EXPECT_EQ(path->class_id, 0x64U);
        EXPECT_EQ(path->instance, 1U);
        EXPECT_EQ(path->attribute, 6U);
    }
}

TEST(RequestPath, R_PTH_11_instance_0_is_the_class_also_when_left_out) {
    EXPECT_EQ(RequestPath::parse(octets("20 01 24 00 30 01")).value().instance, 0U);
    EXPECT_EQ(RequestPath::parse(octets("20 01 30 01")).value().instance, 0U);
}

TEST(RequestPath, R_PTH_10_an_empty_path_is_an_unknown_destination) {
    EXPECT_EQ(status_of(""), GeneralStatus::path_destination_unknown);
}

TEST(RequestPath, R_PTH_10_a_class_alone_is_an_unknown_destination) {
    EXPECT_EQ(status_of("20 66"), GeneralStatus::path_destination_unknown);
    EXPECT_EQ(status_of("34 04 6D05 2B00 0975 0101 20 66"), GeneralStatus::path_destination_unknown);
}

TEST(RequestPath, R_PTH_10_a_key_may_lead) {
    const auto path = RequestPath::parse(octets("34 04 6D05 2B00 0975 8101 20 66 24 01 30 24")).value();
    EXPECT_EQ(path.key, (ElectronicKey{1389, 43, 0x7509, 0x81, 1}));
    EXPECT_EQ(path.attribute, 0x24U);
}

TEST(RequestPath, R_PTH_10_wrong_order_is_a_path_segment_error) {
    for (const auto* text : {
             "24 01",                                  // no class
             "30 01",                                  //
             "24 01 20 66",                            // instance first
             "30 01 20 66 24 01",                      // attribute first
             "20 66 30 01 24 01",                      // attribute before instance
             "34 04 6D05 2B00 0975 0101",              // key alone
             "20 66 34 04 6D05 2B00 0975 0101 24 01",  // key behind the class
         }) {
        EXPECT_EQ(status_of(text), GeneralStatus::path_segment_error) << text;
    }
}

TEST(RequestPath, R_PTH_10_each_segment_at_most_once) {
    for (const auto* text : {"20 66 20 66 24 01", "20 66 24 01 24 01", "20 66 24 01 30 01 30 01",
                             "34 04 000000000000 0000 34 04 000000000000 0000 20 66 24 01"}) {
        EXPECT_EQ(status_of(text), GeneralStatus::path_segment_error) << text;
    }
}

TEST(RequestPath, R_PTH_12_nothing_else_belongs_there) {
    for (const auto* text : {
             "20 66 24 01 30 24 28 01",  // member
             "20 66 24 01 28 01",        //
             "20 66 2C 65",              // connection point
             "20 66 24 01 38 0E",        // service id
             "01 00 20 66 24 01",        // port
             "43 05 20 66 24 01",        // network
             "91 02 61 62",              // symbol, R-PTH-9
             "61 61",                    //
             "20 66 24 01 80 01 00 00",  // data
         }) {
        EXPECT_EQ(status_of(text), GeneralStatus::path_segment_error) << text;
    }
}

TEST(RequestPath, R_ERR_2_what_is_no_segment_or_a_cut_one_is_a_path_segment_error) {
    for (const auto* text : {"20 64 E0 01", "20 64 C7 01", "20 64 27 01", "35 00 00 00", "20 66 25 00", "34 06 0000",
                             "20 66 24 01 3C 00"}) {
        EXPECT_EQ(status_of(text), GeneralStatus::path_segment_error) << text;
    }
}

// The table of R-CON-11 for a node 1389, type 43, product 0x7509, revision 2.5.
struct KeyCase {
    std::string_view what;
    ElectronicKey key;
    std::optional<ConnectionFailure> failure;
};

TEST(ElectronicKey, R_CON_11_mismatch_table) {
    constexpr NodeIdentity node{1389, 43, 0x7509, 2, 5};
    constexpr auto product = ConnectionFailure::vendor_or_product_mismatch;
    constexpr auto type = ConnectionFailure::device_type_mismatch;
    constexpr auto revision = ConnectionFailure::revision_mismatch;
    const std::vector<KeyCase> cases{
        {"all zero", {0, 0, 0, 0, 0}, std::nullopt},
        {"all equal", {1389, 43, 0x7509, 2, 5}, std::nullopt},
        {"other vendor", {77, 43, 0x7509, 2, 5}, product},
        {"other product", {1389, 43, 0x7508, 2, 5}, product},
        {"other type", {1389, 12, 0x7509, 2, 5}, type},
        {"vendor before type", {77, 12, 0x7509, 1, 1}, product},
        {"product before type", {1389, 12, 0x7508, 1, 1}, product},
        {"type before revision", {1389, 12, 0x7509, 1, 1}, type},
        {"any vendor, other type", {0, 12, 0, 0, 0}, type},
        {"lower major", {1389, 43, 0x7509, 1, 5}, revision},
        {"higher major", {1389, 43, 0x7509, 3, 5}, revision},
        {"lower minor", {1389, 43, 0x7509, 2, 4}, revision},
        {"higher minor", {1389, 43, 0x7509, 2, 6}, revision},
        {"any minor", {1389, 43, 0x7509, 2, 0}, std::nullopt},
        {"any major, other minor", {1389, 43, 0x7509, 0, 6}, std::nullopt},
        {"compatible, equal", {1389, 43, 0x7509, 0x82, 5}, std::nullopt},
        {"compatible, lower minor", {1389, 43, 0x7509, 0x82, 1}, std::nullopt},
        {"compatible, higher minor", {1389, 43, 0x7509, 0x82, 6}, revision},
        {"compatible, any minor", {1389, 43, 0x7509, 0x82, 0}, std::nullopt},
        {"compatible, lower major", {1389, 43, 0x7509, 0x81, 5}, revision},
        {"compatible, higher major", {1389, 43, 0x7509, 0x83, 1}, revision},
        {"compatible, any of all", {0, 0, 0, 0x80, 0}, std::nullopt},
    };
    for (const auto& each : cases) EXPECT_EQ(mismatch(each.key, node), each.failure) << each.what;
}

}  // namespace
}  // namespace servobus::cip
