// Unconnected_Send: the embedded request, its pad, and the route.
#include "cip/unconnected_send.hpp"

#include <gtest/gtest.h>

#include "tests/support/octets.hpp"

namespace servobus::cip {
namespace {

using std::chrono::milliseconds;
using test::error_of;
using test::hex;
using test::octets;

TEST(UnconnectedSend, R_CM_9_even_message) {
    const UnconnectedSend send{0x0A, 0x0E, octets("0E 03 20 66 24 01 30 01"), octets("01 00")};
    EXPECT_EQ(hex(send.encode()), hex("0A 0E 0800 0E03206624013001 01 00 0100"));
    EXPECT_EQ(UnconnectedSend::parse(send.encode()).value(), send);
}

TEST(UnconnectedSend, R_CM_9_odd_message_has_a_pad_octet_that_the_length_does_not_count) {
    const UnconnectedSend send{0x03, 0xFA, octets("10 03 20 64 24 01 30 04 01"), octets("01 00")};
    EXPECT_EQ(hex(send.encode()), hex("03 FA 0900 100320642401300401 00 01 00 0100"));
    EXPECT_EQ(UnconnectedSend::parse(send.encode()).value(), send);
    EXPECT_EQ(UnconnectedSend::parse(octets("03 FA 0900 100320642401300401 FF 01 AA 0100")).value(), send)
        << "neither the pad octet nor the reserved one is checked";
}

TEST(UnconnectedSend, R_CM_9_without_route) {
    const UnconnectedSend send{0x0A, 0x05, octets("01 02 20 01 24 01"), {}};
    EXPECT_EQ(hex(send.encode()), hex("0A 05 0600 010220012401 00 00"));
    EXPECT_EQ(UnconnectedSend::parse(send.encode()).value(), send);
}

TEST(UnconnectedSend, R_CM_10_every_other_length_is_refused) {
    for (const auto* text : {"0A 0E 0800 0E03206624013001 01 00 0100", "03 FA 0900 100320642401300401 00 01 00 0100"}) {
        const auto whole = octets(text);
        for (std::size_t length = 0; length < whole.size(); ++length) {
            EXPECT_EQ(error_of(UnconnectedSend::parse(ByteView(whole).first(length))), DecodeError::truncated)
                << length;
        }
        EXPECT_EQ(error_of(UnconnectedSend::parse(test::operator+(whole, {0}))), DecodeError::trailing);
    }
    EXPECT_EQ(error_of(UnconnectedSend::parse(octets("0A 0E FFFF 0E03"))), DecodeError::truncated);
}

TEST(UnconnectedSend, R_CM_9_timeout_is_ticks_of_a_power_of_two) {
    EXPECT_EQ(
        (UnconnectedSend{.priority_tick = 0x0A, .timeout_ticks = 0x0E, .message = {}, .route_path = {}}.timeout()),
        milliseconds(14 * 1024));
    EXPECT_EQ(
        (UnconnectedSend{.priority_tick = 0x13, .timeout_ticks = 0xFA, .message = {}, .route_path = {}}.timeout()),
        milliseconds(2000))
        << "bit 4 is the priority";
    EXPECT_EQ(
        (UnconnectedSend{.priority_tick = 0x0F, .timeout_ticks = 0xFF, .message = {}, .route_path = {}}.timeout()),
        milliseconds(255 * 32768));
}

}  // namespace
}  // namespace servobus::cip
