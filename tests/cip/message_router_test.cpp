// The message router with two small objects: the order of the checks, lists, packets, limits.
#include "cip/message_router.hpp"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cip/services.hpp"
#include "tests/support/octets.hpp"

namespace servobus::cip {
namespace {

using test::hex;
using test::octets;

constexpr std::uint16_t values_class = 0x99;
constexpr std::uint16_t plain_class = 0x64;
constexpr std::uint8_t own_service = 0x4B;

/// Instances 1 and 0x12345. Attributes: 1 UINT get; 2 UINT set only; 3 UDINT get and set, at most 100; 4 UINT get, but
/// its get() fails; 5 STRING of 600 characters; 6 SINT get and set. Offers 0x01, 0x03, 0x04, 0x0E, 0x10 and 0x4B.
class Values : public Object {
public:
    static constexpr std::array<std::uint16_t, 4> class_attributes{1, 2, 6, 7};
    std::uint32_t third = 20;
    std::uint8_t sixth = 0;
    std::vector<std::string> calls;

    ClassInfo info() const override {
        return {.class_id = values_class,
                .revision = 3,
                .max_instance = 0x12345,
                .instances = 2,
                .max_instance_attribute = 6,
                .class_attributes_all = class_attributes};
    }
    bool has_instance(std::uint32_t instance) const override { return instance == 1 || instance == 0x12345; }
    bool offers(std::uint8_t code) const override {
        return code == service::get_attributes_all || code == service::get_attribute_list ||
               code == service::set_attribute_list || code == service::get_attribute_single ||
               code == service::set_attribute_single || code == own_service;
    }
    std::optional<AttributeAccess> attribute(std::uint32_t, std::uint32_t id) const override {
        if (id == 2) return AttributeAccess{false, true};
        if (id == 3 || id == 6) return AttributeAccess{true, true};
        if (id >= 1 && id <= 5) return AttributeAccess{};
        return std::nullopt;
    }
    Status get(std::uint32_t, std::uint32_t id, Writer& value) const override {
        if (id == 1) value.u16(0x1234);
        if (id == 3) value.u32(third);
        if (id == 4) {
            value.u16(0xDEAD);  // what is written before a refusal does not go out
            return Status(GeneralStatus::vendor_specific, {drive_refuses});
        }
        if (id == 5) value.zeros(600);
        if (id == 6) value.u8(sixth);
        return {};
    }
    Status set(std::uint32_t, std::uint32_t id, ByteView value) override {
        const std::size_t size = id == 6 ? 1 : id == 3 ? 4 : 2;
        if (value.size() < size) return GeneralStatus::not_enough_data;
        if (value.size() > size) return GeneralStatus::too_much_data;
        if (id == 6) sixth = value[0];
        if (id != 3) return {};
        const auto number = Reader(value).u32();
        if (number > 100) return GeneralStatus::invalid_attribute_value;
        third = number;
        return {};
    }
    std::optional<std::size_t> value_size(std::uint32_t, std::uint32_t id, ByteView) const override {
        return id == 6 ? 1 : id == 3 ? 4 : 2;
    }
    std::span<const std::uint16_t> attributes_all() const override {
        static constexpr std::array<std::uint16_t, 2> order{3, 1};
        return order;
    }
    Response call(const RequestView& request, const RequestPath& path, const Origin&) override {
        calls.push_back(hex(request.data));
        return {request.service, GeneralStatus::invalid_parameter, {static_cast<std::uint8_t>(path.instance)}};
    }
};

/// As the parameter classes: attribute 0, which a missing segment means. Offers 0x0E only, and has no list order.
class Plain : public Object {
public:
    ClassInfo info() const override { return {.class_id = plain_class}; }
    bool offers(std::uint8_t code) const override { return code == service::get_attribute_single; }
    std::optional<AttributeAccess> attribute(std::uint32_t, std::uint32_t id) const override {
        return id == 0 ? std::optional(AttributeAccess{}) : std::nullopt;
    }
    std::optional<std::uint32_t> implied_attribute() const override { return 0; }
    Status get(std::uint32_t, std::uint32_t, Writer& value) const override {
        value.u8(7);
        return {};
    }
};

class Router : public testing::Test {
protected:
    Router() {
        auto object = std::make_unique<Values>();
        values = object.get();
        router.add(std::move(object));
        router.add(std::make_unique<Plain>());
    }
    std::string answer(std::string_view request) {
        const auto response = router.handle(octets(request), origin);
        return response ? hex(response->encode()) : "nothing";
    }

    MessageRouter router{NodeIdentity{1389, 43, 0x7509, 1, 1}};
    Values* values = nullptr;
    Origin origin{};
};

TEST_F(Router, R_MSG_10_get_attribute_single) {
    EXPECT_EQ(answer("0E 03 20 99 24 01 30 01"), "8E 00 00 00 34 12");
    EXPECT_EQ(answer("0E 03 20 99 24 01 30 01 FF FF"), "8E 00 00 00 34 12") << "extra request data is accepted";
}

TEST_F(Router, R_MSG_11_set_attribute_single) {
    EXPECT_EQ(answer("10 03 20 99 24 01 30 03 32000000"), "90 00 00 00");
    EXPECT_EQ(values->third, 50U);
}

TEST_F(Router, R_PTH_3_all_widths_lead_to_the_same_object) {
    for (const auto* path :
         {"03 20 99 24 01 30 01", "06 2100 9900 2500 0100 3100 0100", "09 2200 99000000 2600 01000000 3200 01000000"}) {
        EXPECT_EQ(answer("0E" + std::string(path)), "8E 00 00 00 34 12") << path;
    }
    EXPECT_EQ(answer("0E 05 20 99 2600 45230100 30 01"), "8E 00 00 00 34 12") << "a large instance number";
    EXPECT_EQ(answer("0E 04 20 99 2500 4523 30 01"), "8E 00 05 00") << "which is not cut to 16 bits";
    EXPECT_EQ(answer("0E 05 2200 99000100 24 01 30 01"), "8E 00 05 00") << "nor is a class";
    EXPECT_EQ(answer("0E 05 20 99 24 01 3200 01000100"), "8E 00 14 00") << "nor an attribute";
}

TEST_F(Router, R_DEV_4_a_missing_attribute_means_the_implied_one) {
    EXPECT_EQ(answer("0E 02 20 64 24 01"), "8E 00 00 00 07");
    EXPECT_EQ(answer("0E 02 20 99 24 01"), "8E 00 14 00") << "where there is none it is missing, R-ERR-5";
    EXPECT_EQ(answer("10 02 20 99 24 01 0000"), "90 00 14 00");
}

TEST_F(Router, R_MSG_3_shorter_than_two_octets_is_no_request) {
    EXPECT_EQ(answer(""), "nothing");
    EXPECT_EQ(answer("0E"), "nothing");
    EXPECT_EQ(answer("0E 00"), "8E 00 05 00");
}

TEST_F(Router, R_MSG_3_a_service_with_the_reply_bit_is_not_supported) {
    EXPECT_EQ(answer("8E 03 20 99 24 01 30 01"), "8E 00 08 00");
    EXPECT_EQ(answer("81 02 20 99 24 00"), "81 00 08 00") << "at a class";
    EXPECT_EQ(answer("8E 03 20 99 24 00 30 01"), "8E 00 08 00");
    EXPECT_EQ(answer("8A 02 20 02 24 01 0000"), "8A 00 08 00") << "at the message router";
    EXPECT_EQ(answer("8A 02 20 02 24 00 0000"), "8A 00 08 00");
    EXPECT_EQ(answer("FF 02 20 99 24 01"), "FF 00 08 00");
}

TEST_F(Router, R_MSG_3_a_response_names_its_service_without_the_reply_bit) {
    for (const auto* text : {"8E 03 20 99 24 01 30 01", "8E 03 20 99 24 00 30 01", "8E 03 20 02 24 00 30 01",
                             "8E 03 20 02 24 01 30 01", "8E 00", "8E 09 20", "8E 02 20 77 24 01"}) {
        EXPECT_EQ(router.handle(octets(text), origin).value().service, 0x0E) << text;
    }
}

// Section 2.4: each request breaks two rules; the first one of the list decides.
TEST_F(Router, R_ERR_1_path_size_before_segments) {
    EXPECT_EQ(answer("0E 09 20 64 24 01 30 05"), "8E 00 26 00");
    EXPECT_EQ(answer("0E 09 E0 64 24 01 30 05"), "8E 00 26 00");
}
TEST_F(Router, R_ERR_2_segments_before_class) {
    EXPECT_EQ(answer("0E 02 20 99 E0 01"), "8E 00 04 00");
    EXPECT_EQ(answer("0E 02 20 77 E0 01"), "8E 00 04 00");
    EXPECT_EQ(answer("0E 02 91 02 61 62"), "8E 00 04 00");
}
TEST_F(Router, R_ERR_3_class_and_instance_before_service) {
    EXPECT_EQ(answer("4C 03 20 77 24 01 30 01"), "CC 00 05 00");
    EXPECT_EQ(answer("4C 03 20 99 24 02 30 01"), "CC 00 05 00");
    EXPECT_EQ(answer("8E 03 20 99 24 02 30 01"), "8E 00 05 00");
    EXPECT_EQ(answer("0E 02 20 02 24 02"), "8E 00 05 00") << "the message router has one instance";
}
TEST_F(Router, R_ERR_4_service_before_attribute) {
    EXPECT_EQ(answer("4C 03 20 99 24 01 30 63"), "CC 00 08 00");
    EXPECT_EQ(answer("10 03 20 64 24 01 30 63 00"), "90 00 08 00") << "not 0x0E and not 0x14";
    EXPECT_EQ(answer("01 02 20 64 24 01"), "81 00 08 00");
}
TEST_F(Router, R_ERR_5_attribute_before_access) {
    EXPECT_EQ(answer("0E 03 20 99 24 01 30 63"), "8E 00 14 00");
    EXPECT_EQ(answer("10 03 20 99 24 01 30 63"), "90 00 14 00");
}
TEST_F(Router, R_ERR_6_access_before_data_length) {
    EXPECT_EQ(answer("0E 03 20 99 24 01 30 02"), "8E 00 2C 00");
    EXPECT_EQ(answer("10 03 20 99 24 01 30 01"), "90 00 0E 00");
    EXPECT_EQ(answer("10 03 20 99 24 01 30 01 0000000000"), "90 00 0E 00");
}
TEST_F(Router, R_ERR_8_data_length_before_value) {
    EXPECT_EQ(answer("10 03 20 99 24 01 30 03 FFFFFF"), "90 00 13 00");
    EXPECT_EQ(answer("10 03 20 99 24 01 30 03 FFFFFFFFFF"), "90 00 15 00");
}
TEST_F(Router, R_ERR_9_value_and_R_ERR_11_a_refused_set_changes_nothing) {
    EXPECT_EQ(answer("10 03 20 99 24 01 30 03 65000000"), "90 00 09 00");
    EXPECT_EQ(values->third, 20U);
}
TEST_F(Router, R_ERR_10_what_the_object_refuses_goes_out_with_its_extended_word_and_without_data) {
    EXPECT_EQ(answer("0E 03 20 99 24 01 30 04"), "8E 00 1F 01 01 00");
}

TEST_F(Router, R_PTH_10_a_key_in_the_path_must_fit) {
    EXPECT_EQ(answer("0E 08 34 04 6D05 2B00 0975 8101 20 99 24 01 30 01"), "8E 00 00 00 34 12");
    EXPECT_EQ(answer("0E 08 34 04 0000 0000 0000 0000 20 99 24 01 30 01"), "8E 00 00 00 34 12");
    EXPECT_EQ(answer("0E 08 34 04 4D00 2B00 0975 8101 20 99 24 01 30 01"), "8E 00 25 00");
    EXPECT_EQ(answer("0E 08 34 04 6D05 2B00 0975 0201 20 99 24 01 30 01"), "8E 00 25 00");
    EXPECT_EQ(answer("0E 08 34 06 6D05 2B00 0975 0101 20 99 24 01 30 01"), "8E 00 04 00") << "no such key format";
}

TEST_F(Router, R_MSG_12_get_attributes_all_takes_the_objects_order) {
    EXPECT_EQ(answer("01 02 20 99 24 01"), "81 00 00 00 14 00 00 00 34 12");
}

TEST_F(Router, R_OBJ_1_class_attributes) {
    EXPECT_EQ(answer("0E 03 20 99 24 00 30 01"), "8E 00 00 00 03 00");
    EXPECT_EQ(answer("0E 03 20 99 24 00 30 02"), "8E 00 00 00 45 23") << "an UINT holds no more of 0x12345";
    EXPECT_EQ(answer("0E 03 20 99 24 00 30 03"), "8E 00 00 00 02 00");
    EXPECT_EQ(answer("0E 03 20 99 24 00 30 06"), "8E 00 00 00 07 00");
    EXPECT_EQ(answer("0E 03 20 99 24 00 30 07"), "8E 00 00 00 06 00");
    EXPECT_EQ(answer("0E 02 20 99 30 01"), "8E 00 00 00 03 00") << "instance 0 left out";
    for (const auto* id : {"00", "04", "05", "08", "FF"}) {
        EXPECT_EQ(answer("0E 03 20 99 24 00 30" + std::string(id)), "8E 00 14 00") << id;
    }
    EXPECT_EQ(answer("0E 02 20 64 24 00"), "8E 00 14 00") << "a class implies no attribute";
}

TEST_F(Router, R_OBJ_1_a_class_offers_reading_only) {
    EXPECT_EQ(answer("10 03 20 99 24 00 30 01 0100"), "90 00 08 00");
    EXPECT_EQ(answer("4B 02 20 99 24 00"), "CB 00 08 00");
    EXPECT_EQ(answer("03 02 20 99 24 00 0100 0100"), "83 00 08 00");
}

TEST_F(Router, R_OBJ_3_get_attributes_all_of_a_class_where_offered) {
    EXPECT_EQ(answer("01 02 20 99 24 00"), "81 00 00 00 03 00 45 23 07 00 06 00");
    EXPECT_EQ(answer("01 02 20 64 24 00"), "81 00 08 00");
}

TEST_F(Router, R_MR_1_the_message_router_offers_packets_and_its_class_attributes) {
    EXPECT_EQ(answer("0E 03 20 02 24 01 30 01"), "8E 00 08 00");
    EXPECT_EQ(answer("01 02 20 02 24 01"), "81 00 08 00");
    EXPECT_EQ(answer("0E 03 20 02 24 00 30 01"), "8E 00 00 00 01 00");
    EXPECT_EQ(answer("0A 02 20 02 24 00 0000"), "8A 00 08 00");
    EXPECT_EQ(router.classes(), (std::vector<std::uint16_t>{0x02, plain_class, values_class}));
}

TEST_F(Router, R_MSG_4_an_objects_own_service_gets_the_request_as_it_came) {
    EXPECT_EQ(answer("4B 02 20 99 24 01 AA BB"), "CB 00 20 00 01");
    EXPECT_EQ(values->calls, std::vector<std::string>{"AA BB"});
}

// R-MSG-14
TEST_F(Router, R_MSG_14_get_attribute_list) {
    EXPECT_EQ(answer("03 02 20 99 24 01 0200 0100 0300"), hex("83 00 00 00 0200 0100 0000 3412 0300 0000 14000000"));
    EXPECT_EQ(answer("03 02 20 99 24 01 0000"), hex("83 00 00 00 0000"));
}
TEST_F(Router, R_MSG_14_each_attribute_has_its_own_status) {
    EXPECT_EQ(answer("03 02 20 99 24 01 0400 6300 0200 0400 0100"),
              hex("83 00 0A 00 0400 6300 1400 0200 2C00 0400 1F00 0100 0000 3412"));
}
TEST_F(Router, R_MSG_14_the_count_must_fit_the_data) {
    EXPECT_EQ(answer("03 02 20 99 24 01"), "83 00 13 00");
    EXPECT_EQ(answer("03 02 20 99 24 01 01"), "83 00 13 00");
    EXPECT_EQ(answer("03 02 20 99 24 01 0200 0100"), "83 00 13 00");
    EXPECT_EQ(answer("03 02 20 99 24 01 0200 0100 03"), "83 00 13 00");
    EXPECT_EQ(answer("03 02 20 99 24 01 0100 0100 0300"), "83 00 15 00");
    EXPECT_EQ(answer("03 02 20 99 24 01 FFFF 0100"), "83 00 13 00");
}
TEST_F(Router, R_MSG_14_stops_where_the_reply_is_full) {
    origin.reply_limit = 4 + 2 + 6 + 603;  // the string needs 604
    EXPECT_EQ(answer("03 02 20 99 24 01 0300 0100 0500 0300"), hex("83 00 11 00 0100 0100 0000 3412"));
    origin.reply_limit = 4 + 2 + 6;
    EXPECT_EQ(answer("03 02 20 99 24 01 0100 0100"), hex("83 00 00 00 0100 0100 0000 3412"));
    origin.reply_limit = 4 + 2 + 5;
    EXPECT_EQ(answer("03 02 20 99 24 01 0100 0100"), hex("83 00 11 00 0000"));
    origin.reply_limit = 4;
    EXPECT_EQ(answer("03 02 20 99 24 01 0100 0100"), "83 00 11 00");
}

// R-MSG-15
TEST_F(Router, R_MSG_15_set_attribute_list) {
    EXPECT_EQ(answer("04 02 20 99 24 01 0200 0300 32000000 0600 05"), hex("84 00 00 00 0200 0300 0000 0600 0000"));
    EXPECT_EQ(values->third, 50U);
    EXPECT_EQ(values->sixth, 5);
}
TEST_F(Router, R_MSG_15_each_attribute_has_its_own_status) {
    EXPECT_EQ(answer("04 02 20 99 24 01 0300 0300 65000000 0100 0000 0600 05"),
              hex("84 00 0A 00 0300 0300 0900 0100 0E00 0600 0000"));
    EXPECT_EQ(values->third, 20U);
    EXPECT_EQ(values->sixth, 5) << "those that are good are set";
}
TEST_F(Router, R_MSG_15_behind_an_unknown_attribute_nothing_can_be_found) {
    EXPECT_EQ(answer("04 02 20 99 24 01 0300 0600 05 6300 01000000 0600 06"),
              hex("84 00 0A 00 0300 0600 0000 6300 1400 0000 1C00"));
    EXPECT_EQ(values->sixth, 5);
}
TEST_F(Router, R_MSG_15_a_value_that_is_cut) {
    EXPECT_EQ(answer("04 02 20 99 24 01 0100 0300 3200"), hex("84 00 0A 00 0100 0300 1300"));
    EXPECT_EQ(values->third, 20U);
}
TEST_F(Router, R_MSG_15_the_count_must_fit_the_data) {
    EXPECT_EQ(answer("04 02 20 99 24 01"), "84 00 13 00");
    EXPECT_EQ(answer("04 02 20 99 24 01 0200 0600 05"), "84 00 13 00");
    EXPECT_EQ(answer("04 02 20 99 24 01 FFFF 0600 05"), "84 00 13 00");
    EXPECT_EQ(answer("04 02 20 99 24 01 0100 0600 05 FF"), "84 00 15 00");
    EXPECT_EQ(values->sixth, 0) << "surplus data is found before anything is set";
    EXPECT_EQ(answer("04 02 20 99 24 01 0000"), hex("84 00 00 00 0000"));
}
TEST_F(Router, R_MSG_15_a_reply_that_would_not_fit_sets_nothing) {
    origin.reply_limit = 4 + 2 + 7;
    EXPECT_EQ(answer("04 02 20 99 24 01 0200 0300 32000000 0600 05"), "84 00 11 00");
    EXPECT_EQ(values->third, 20U);
    origin.reply_limit = 4 + 2 + 8;
    EXPECT_EQ(answer("04 02 20 99 24 01 0200 0300 32000000 0600 05"), hex("84 00 00 00 0200 0300 0000 0600 0000"));
}

// R-MSG-16
TEST_F(Router, R_MSG_16_packet_of_two) {
    EXPECT_EQ(answer("0A 02 20 02 24 01 0200 0600 0E00 0E 03 20 99 24 01 30 01 0E 03 20 99 24 01 30 03"),
              hex("8A 00 00 00 0200 0600 0C00 8E 00 00 00 3412 8E 00 00 00 14000000"));
}
TEST_F(Router, R_MSG_16_an_inner_error_is_told_outside_and_the_order_is_kept) {
    EXPECT_EQ(answer("0A 02 20 02 24 01 0300 0800 1000 1800"
                     "0E 03 20 99 24 01 30 63  10 03 20 64 24 01 30 00  0E 03 20 99 24 01 30 01"),
              hex("8A 00 1E 00 0300 0800 0C00 1000 8E 00 14 00 90 00 08 00 8E 00 00 00 3412"));
}
TEST_F(Router, R_MSG_16_an_inner_path_beyond_its_part) {
    EXPECT_EQ(answer("0A 02 20 02 24 01 0200 0600 0A00 0E 03 20 99 0E 03 20 99 24 01 30 01"),
              hex("8A 00 1E 00 0200 0600 0A00 8E 00 26 00 8E 00 00 00 3412"));
}
TEST_F(Router, R_MSG_16_without_parts) { EXPECT_EQ(answer("0A 02 20 02 24 01 0000"), hex("8A 00 00 00 0000")); }
TEST_F(Router, R_MSG_16_a_packet_in_a_packet_is_not_supported) {
    EXPECT_EQ(answer("0A 02 20 02 24 01 0200 0600 0E00 0A 02 20 02 24 01 0000 0E 03 20 99 24 01 30 01"),
              hex("8A 00 1E 00 0200 0600 0A00 8A 00 08 00 8E 00 00 00 3412"));
}
TEST_F(Router, R_MSG_16_a_packet_embedded_once_is_answered) {
    origin.depth = max_embedding - 1;
    EXPECT_EQ(answer("0A 02 20 02 24 01 0100 0400 0E 03 20 99 24 01 30 01"),
              hex("8A 00 00 00 0100 0400 8E 00 00 00 3412"));
    origin.depth = max_embedding;
    EXPECT_EQ(answer("0A 02 20 02 24 01 0100 0400 0E 03 20 99 24 01 30 01"), "8A 00 08 00");
}
TEST_F(Router, R_MSG_16_offsets_outside_the_data) {
    const std::vector<std::string> broken{
        "",                                               // no count
        "01",                                             //
        "0100",                                           // no offset
        "0200 0600",                                      // one of two
        "FFFF 0600 0800",                                 //
        "0100 0300 0E 03 20 99 24 01 30 01",              // into the offsets
        "0100 0C00 0E 03 20 99 24 01 30 01",              // at the end
        "0100 0B00 0E 03 20 99 24 01 30 01",              // one octet left
        "0100 FFFF 0E 03 20 99 24 01 30 01",              // far outside
        "0200 0E00 0600 0E0320992401300110032099240130",  // backwards
        "0200 0600 0600 0E 03 20 99 24 01 30 01",         // nothing between
        "0200 0600 0700 0E 03 20 99 24 01 30 01",         // one octet between
    };
    for (const auto& data : broken) {
        EXPECT_EQ(answer("0A 02 20 02 24 01" + data), "8A 00 13 00") << data;
    }
}
TEST_F(Router, R_MSG_16_a_part_that_does_not_fit_is_too_large_in_its_place) {
    // The string needs 604 octets, the two others 6 each, the head of three 8 and its own reply header 4.
    constexpr auto packet =
        "0A 02 20 02 24 01 0300 0800 1000 1800"
        "0E 03 20 99 24 01 30 01  0E 03 20 99 24 01 30 05  0E 03 20 99 24 01 30 01";
    origin.reply_limit = 4 + 8 + 6 + 604 + 6;
    EXPECT_EQ(router.handle(octets(packet), origin).value().encoded_size(), origin.reply_limit);
    origin.reply_limit -= 3;  // 4 octets are kept for the last part, not its 6
    EXPECT_EQ(answer(packet), hex("8A 00 1E 00 0300 0800 0E00 1200 8E 00 00 00 3412 8E 00 11 00 8E 00 00 00 3412"));
    origin.reply_limit = 4 + 8 + 3 * 4;
    EXPECT_EQ(answer(packet), hex("8A 00 1E 00 0300 0800 0C00 1000 8E 00 11 00 8E 00 11 00 8E 00 11 00"));
    origin.reply_limit -= 1;
    EXPECT_EQ(answer(packet), "8A 00 11 00");
}

TEST_F(Router, R_ENC_27_a_reply_beyond_the_limit_is_too_large) {
    origin.reply_limit = 604;
    EXPECT_EQ(router.handle(octets("0E 03 20 99 24 01 30 05"), origin).value().encoded_size(), 604U);
    origin.reply_limit = 603;
    EXPECT_EQ(answer("0E 03 20 99 24 01 30 05"), "8E 00 11 00");
    origin.reply_limit = 4 + 6;
    EXPECT_EQ(answer("01 02 20 99 24 01"), "81 00 00 00 14 00 00 00 34 12");
    origin.reply_limit = 4 + 5;
    EXPECT_EQ(answer("01 02 20 99 24 01"), "81 00 11 00");
}

}  // namespace
}  // namespace servobus::cip
