// The encapsulation header: frames as they stand in a datagram, and their replies.
#include "enip/encapsulation.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "tests/support/octets.hpp"

namespace servobus::enip {
namespace {

using cip::Bytes;
using cip::ByteView;
using cip::DecodeError;
using test::error_of;
using test::hex;
using test::octets;

// command, length | session | status | context | options | data
constexpr auto example_octets = "6500 0400 03020100 69000000 4756303030303034 78563412 01000000";

Frame example() {
    return {Command::register_session,
            0x00010203,
            EncapsulationStatus::unsupported_protocol,
            {0x47, 0x56, 0x30, 0x30, 0x30, 0x30, 0x30, 0x34},
            0x12345678,
            octets("01 00 00 00")};
}

TEST(Frame, R_ENC_2_layout) {
    EXPECT_EQ(hex(example().encode()), hex(example_octets));
    EXPECT_EQ(Frame::parse(octets(example_octets)).value(), example());
}

TEST(Frame, R_ENC_2_write_appends) {
    auto bytes = octets("AA");
    Frame{}.write(bytes);
    EXPECT_EQ(hex(bytes), hex("AA" + std::string(48, '0')));
}

TEST(Frame, R_ENC_3_is_truncated_at_every_shorter_length) {
    const auto whole = octets(example_octets);
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_EQ(error_of(Frame::parse(ByteView(whole).first(length))), DecodeError::truncated) << length;
    }
}

TEST(Frame, octets_behind_the_message_are_ignored) {
    EXPECT_EQ(Frame::parse(test::operator+(octets(example_octets), {1, 2, 3})).value(), example());
}

TEST(Frame, R_ENC_3_the_data_of_a_datagram_has_a_limit) {
    Frame frame{.command = Command::nop, .data = Bytes(max_data_bytes, 0x55)};
    EXPECT_EQ(Frame::parse(frame.encode()).value(), frame);
    frame.data.push_back(0);
    EXPECT_EQ(error_of(Frame::parse(frame.encode())), DecodeError::too_many);
}

TEST(Frame, R_ENC_6_an_unknown_command_is_a_frame_too) {
    auto bytes = octets(example_octets);
    bytes[0] = 0x34;
    bytes[1] = 0x12;
    EXPECT_EQ(Frame::parse(bytes).value().command, static_cast<Command>(0x1234));
}

TEST(Frame, R_ENC_9_a_reply_copies_command_session_and_context_and_has_no_options) {
    const auto reply = example().reply();
    EXPECT_EQ(hex(reply.encode()), hex("6500 0000 03020100 00000000 4756303030303034 00000000"));
    const auto refusal = example().reply(EncapsulationStatus::invalid_session, octets("AA BB"));
    EXPECT_EQ(hex(refusal.encode()), hex("6500 0200 03020100 64000000 4756303030303034 00000000 AABB"));
}

TEST(Encapsulation, R_ENC_4_every_status_has_a_text_of_its_own) {
    std::set<std::string> seen;
    for (const unsigned code : {0x00U, 0x01U, 0x02U, 0x03U, 0x64U, 0x65U, 0x69U}) {
        EXPECT_TRUE(seen.insert(describe(static_cast<EncapsulationStatus>(code))).second) << code;
    }
    EXPECT_EQ(describe(EncapsulationStatus::invalid_session), "invalid session handle");
    EXPECT_EQ(describe(static_cast<EncapsulationStatus>(0x6A)), "status 0x006A");
    EXPECT_EQ(describe(static_cast<EncapsulationStatus>(0xFFFFFFFF)), "status 0xFFFFFFFF");
}

TEST(Encapsulation, R_ENC_5_every_command_has_a_name) {
    EXPECT_EQ(describe(Command::nop), "NOP");
    EXPECT_EQ(describe(Command::list_services), "ListServices");
    EXPECT_EQ(describe(Command::list_identity), "ListIdentity");
    EXPECT_EQ(describe(Command::list_interfaces), "ListInterfaces");
    EXPECT_EQ(describe(Command::register_session), "RegisterSession");
    EXPECT_EQ(describe(Command::unregister_session), "UnRegisterSession");
    EXPECT_EQ(describe(Command::send_rr_data), "SendRRData");
    EXPECT_EQ(describe(Command::send_unit_data), "SendUnitData");
    EXPECT_EQ(describe(static_cast<Command>(0x0072)), "command 0x0072");
}

}  // namespace
}  // namespace servobus::enip
