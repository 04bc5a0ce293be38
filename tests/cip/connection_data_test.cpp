// What the Connection Manager tells of a connection, octet by octet (R-CM-7, R-CM-8).
#include "cip/connection_data.hpp"

#include <gtest/gtest.h>

#include "tests/support/octets.hpp"

namespace servobus::cip {
namespace {

using test::error_of;
using test::hex;
using test::octets;

constexpr ConnectionTriad triad{0x1234, 0x004D, 0x11223344};

ConnectionData example() {
    return {.number = 0x0201,
            .state = connection_established,
            .originator_port = 3000,
            .target_port = 2222,
            .triad = triad,
            .o_to_t_id_at_originator = 0x01020304,
            .o_to_t_id_at_target = 0x05060708,
            .o_to_t_multiplier = 2,
            .o_to_t_rpi = 10'000,
            .o_to_t_api = 10'001,
            .t_to_o_id_at_originator = 0x0A0B0C0D,
            .t_to_o_id_at_target = 0x1A1B1C1D,
            .t_to_o_multiplier = 7,
            .t_to_o_rpi = 20'000,
            .t_to_o_api = 20'001};
}
// number, state, ports | triad | ids, multiplier, reserved, intervals | the same of T->O
constexpr auto example_octets =
    "0102 0300 B80B AE08 3412 4D00 44332211 04030201 08070605 02 000000 10270000 11270000 0D0C0B0A 1D1C1B1A 07 000000 "
    "204E0000 214E0000";

TEST(ConnectionData, R_CM_7_has_56_octets_in_this_order) {
    EXPECT_EQ(example().encode().size(), 56U);
    EXPECT_EQ(hex(example().encode()), hex(example_octets));
    EXPECT_EQ(ConnectionData::parse(octets(example_octets)).value(), example());
}

TEST(ConnectionData, R_CM_7_reserved_octets_are_ignored) {
    auto bytes = octets(example_octets);
    bytes[25] = bytes[26] = bytes[27] = bytes[45] = bytes[46] = bytes[47] = 0xFF;
    EXPECT_EQ(ConnectionData::parse(bytes).value(), example());
}

TEST(ConnectionData, R_CM_7_no_other_length) {
    const auto bytes = octets(example_octets);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
        EXPECT_EQ(error_of(ConnectionData::parse(ByteView(bytes).first(length))), DecodeError::truncated) << length;
    }
    EXPECT_EQ(error_of(ConnectionData::parse(test::operator+(bytes, Bytes{0}))), DecodeError::trailing);
}

TEST(ConnectionData, R_CO_1_is_established_unless_it_says_otherwise) {
    EXPECT_EQ(hex(ConnectionData{}.encode()).substr(0, 11), "00 00 03 00");
}

TEST(ConnectionOwner, R_CM_8_has_twelve_octets) {
    const ConnectionOwner owner{
        .connections = 1, .claim_output_ownership = 2, .ready_for_ownership = 3, .last_action = 4, .triad = triad};
    constexpr auto text = "01 02 03 04 3412 4D00 44332211";
    EXPECT_EQ(hex(owner.encode()), hex(text));
    EXPECT_EQ(ConnectionOwner::parse(octets(text)).value(), owner);
    const auto bytes = octets(text);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
        EXPECT_EQ(error_of(ConnectionOwner::parse(ByteView(bytes).first(length))), DecodeError::truncated) << length;
    }
    EXPECT_EQ(error_of(ConnectionOwner::parse(test::operator+(bytes, Bytes{0}))), DecodeError::trailing);
}

}  // namespace
}  // namespace servobus::cip
