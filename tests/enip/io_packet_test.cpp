// Class 0 and 1 datagrams octet by octet: the golden ones, every cut, and what is no I/O datagram (R-IO-1 to R-IO-8).
#include "enip/io_packet.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/golden.hpp"
#include "tests/support/octets.hpp"

namespace servobus::enip {
namespace {

using test::error_of;
using test::golden_vectors;
using test::hex;
using test::octets;

//                            count address length id       sequence data length
constexpr auto heartbeat = "0200 0280 0800 0800A056 01000000 B100 0200 0100";

TEST(IoPacket, R_IO_3_golden_heartbeat) {
    const auto packet = IoPacket::parse(octets(heartbeat));
    ASSERT_TRUE(packet);
    EXPECT_EQ(packet->connection_id, 0x56A00008U);
    EXPECT_EQ(packet->sequence, 1U);
    EXPECT_EQ(hex(test::find_golden_vector("io_o2t_heartbeat")->octets), hex(heartbeat));
}

// What is written with begin_io_packet is the golden datagram again.
TEST(IoPacket, R_IO_1_golden_datagrams_come_out_as_they_went_in) {
    unsigned datagrams = 0;
    for (const auto& vector : golden_vectors()) {
        if (!vector.is_io_datagram()) continue;
        SCOPED_TRACE(vector.name);
        const auto packet = IoPacket::parse(vector.octets);
        ASSERT_TRUE(packet);
        EXPECT_EQ(packet->data.size() + io_packet_overhead, vector.octets.size());
        cip::Bytes written(vector.octets.size(), 0xEE);
        const auto place = begin_io_packet(written, packet->connection_id, packet->sequence);
        ASSERT_EQ(place.size(), packet->data.size());
        std::ranges::copy(packet->data, place.begin());
        EXPECT_EQ(hex(written), hex(vector.octets));
        ++datagrams;
    }
    EXPECT_EQ(datagrams, 14U);
}

TEST(IoPacket, EveryCutIsTruncated) {
    for (const auto& vector : golden_vectors()) {
        if (!vector.is_io_datagram()) continue;
        for (std::size_t length = 0; length < vector.octets.size(); ++length) {
            EXPECT_EQ(error_of(IoPacket::parse(cip::ByteView(vector.octets).first(length))),
                      cip::DecodeError::truncated)
                << vector.name << ' ' << length;
        }
    }
}

TEST(IoPacket, R_IO_8_octets_behind_the_items_are_ignored) {
    const auto longer = octets(std::string(heartbeat) + "DEADBEEF");
    const auto packet = IoPacket::parse(longer);
    ASSERT_TRUE(packet);
    EXPECT_EQ(hex(packet->data), "01 00");
}

TEST(IoPacket, DataMayBeEmpty) {
    const auto packet = IoPacket::parse(octets("0200 0280 0800 0800A056 01000000 B100 0000"));
    ASSERT_TRUE(packet) << "what is too short is said by who knows the size";
    EXPECT_TRUE(packet->data.empty());
}

TEST(IoPacket, R_IO_7_other_items_are_refused) {
    for (const auto* wrong : {
             "0100 0280 0800 0800A056 01000000 B100 0200 0100",  // one item
             "0300 0280 0800 0800A056 01000000 B100 0200 0100",  // three
             "0000 0280 0800 0800A056 01000000 B100 0200 0100",  // none
             "0200 A100 0800 0800A056 01000000 B100 0200 0100",  // a connected address
             "0200 0280 0400 0800A056 01000000 B100 0200 0100",  // a short one
             "0200 0280 0C00 0800A056 01000000 B100 0200 0100",  // a long one
             "0200 0280 0800 0800A056 01000000 B200 0200 0100",  // unconnected data
             "0200 B100 0200 0100 0280 0800 0800A056 01000000",  // the other way round
         }) {
        EXPECT_EQ(error_of(IoPacket::parse(octets(wrong))), cip::DecodeError::bad_value) << wrong;
    }
    EXPECT_EQ(error_of(IoPacket::parse(octets("0200 0280 0800 0800A056 01000000 B100 FFFF 0100"))),
              cip::DecodeError::truncated);
}

TEST(IoPacket, AllNumbersAreLittleEndian) {
    cip::Bytes written(io_packet_overhead + 0x0102);
    begin_io_packet(written, 0x01020304, 0x05060708);
    EXPECT_EQ(hex(cip::ByteView(written).first(io_packet_overhead)), hex("0200 0280 0800 04030201 08070605 B100 0201"));
}

}  // namespace
}  // namespace servobus::enip
