// The common packet format: items, limits, socket addresses.
#include "enip/common_packet.hpp"

#include <gtest/gtest.h>

#include "tests/support/octets.hpp"

namespace servobus::enip {
namespace {

using cip::Bytes;
using cip::ByteView;
using cip::DecodeError;
using test::error_of;
using test::hex;
using test::octets;

constexpr auto example_octets = "0300 0000 0000 B200 0200 0E00 0180 1000 0002 08AE EFC00D60 0000000000000000";

CommonPacket example() {
    return {{{ItemType::null_address, {}},
             {ItemType::unconnected_data, octets("0E 00")},
             {ItemType::sockaddr_t_to_o, octets("0002 08AE EFC00D60 0000000000000000")}}};
}

CommonPacket of(std::size_t count) { return {std::vector<Item>(count, Item{ItemType::null_address, {}})}; }

TEST(CommonPacket, R_CPF_1_count_and_items_without_padding) {
    EXPECT_EQ(hex(example().encode()), hex(example_octets));
    EXPECT_EQ(CommonPacket::parse(octets(example_octets)).value(), example());
}

TEST(CommonPacket, R_CPF_1_an_odd_item_is_not_padded) {
    const auto packet = CommonPacket::parse(octets("0200 B200 0300 010203 0000 0000")).value();
    ASSERT_EQ(packet.items.size(), 2U);
    EXPECT_EQ(hex(packet.items[0].data), "01 02 03");
    EXPECT_EQ(hex(packet.encode()), hex("0200 B200 0300 010203 0000 0000"));
}

TEST(CommonPacket, R_ENC_16_without_items) {
    EXPECT_EQ(hex(CommonPacket{}.encode()), "00 00");
    EXPECT_TRUE(CommonPacket::parse(octets("00 00")).value().items.empty());
}

TEST(CommonPacket, R_CPF_2_is_truncated_at_every_shorter_length) {
    const auto whole = octets(example_octets);
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_EQ(error_of(CommonPacket::parse(ByteView(whole).first(length))), DecodeError::truncated) << length;
    }
}

TEST(CommonPacket, R_CPF_2_an_item_length_beyond_the_message_is_truncated) {
    EXPECT_EQ(error_of(CommonPacket::parse(octets("0100 B200 FFFF 0E00"))), DecodeError::truncated);
    EXPECT_EQ(error_of(CommonPacket::parse(octets("0200 B200 0200 0E00"))), DecodeError::truncated);
}

TEST(CommonPacket, octets_behind_the_last_item_trail) {
    EXPECT_EQ(error_of(CommonPacket::parse(test::operator+(octets(example_octets), {0}))), DecodeError::trailing);
    EXPECT_EQ(error_of(CommonPacket::parse(octets("0000 00"))), DecodeError::trailing);
}

TEST(CommonPacket, holds_max_items_and_not_one_more) {
    EXPECT_EQ(CommonPacket::parse(of(max_items).encode()).value(), of(max_items));
    EXPECT_EQ(error_of(CommonPacket::parse(of(max_items + 1).encode())), DecodeError::too_many);
    EXPECT_EQ(error_of(CommonPacket::parse(octets("FF FF"))), DecodeError::too_many) << "before anything is read";
}

TEST(CommonPacket, R_CPF_10_unknown_items_are_kept) {
    const auto packet = CommonPacket::parse(octets("0300 0000 0000 B200 0200 0E00 3412 0100 AA")).value();
    ASSERT_EQ(packet.items.size(), 3U);
    EXPECT_EQ(packet.items[2].type, static_cast<ItemType>(0x1234));
}

TEST(CommonPacketView, R_CPF_1_shows_the_items_where_they_are) {
    const auto whole = octets(example_octets);
    const auto view = CommonPacketView::parse(whole).value();
    const auto packet = example();
    ASSERT_EQ(view.size(), packet.items.size());
    for (std::size_t i = 0; i < view.size(); ++i) {
        EXPECT_EQ(view[i].type, packet.items[i].type) << i;
        EXPECT_EQ(hex(view[i].data), hex(packet.items[i].data)) << i;
    }
    EXPECT_EQ(view[1].data.data(), whole.data() + 10) << "not copied";
}

TEST(CommonPacketView, R_CPF_2_is_refused_like_a_packet) {
    const auto whole = octets(example_octets);
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_EQ(error_of(CommonPacketView::parse(ByteView(whole).first(length))), DecodeError::truncated) << length;
    }
    EXPECT_EQ(error_of(CommonPacketView::parse(octets("0000 00"))), DecodeError::trailing);
    EXPECT_EQ(error_of(CommonPacketView::parse(of(max_items + 1).encode())), DecodeError::too_many);
    EXPECT_EQ(CommonPacketView::parse(of(max_items).encode()).value().size(), max_items);
}

TEST(CommonPacket, finds_the_first_item_of_a_type) {
    auto packet = example();
    packet.items.push_back({ItemType::unconnected_data, octets("FF")});
    EXPECT_EQ(packet.find(ItemType::unconnected_data), &packet.items[1]);
    EXPECT_EQ(packet.find(ItemType::sockaddr_o_to_t), nullptr);
}

TEST(SocketAddress, R_CPF_8_is_big_endian) {
    const SocketAddress address{.port = 2222, .address = 0xEFC00D60};
    EXPECT_EQ(hex(address.encode()), hex("0002 08AE EFC00D60 0000000000000000"));
    EXPECT_EQ(SocketAddress::parse(address.encode()).value(), address);
}

TEST(SocketAddress, R_CPF_9_family_and_zeros_are_read_as_they_are) {
    const auto address = SocketAddress::parse(octets("0A00 0000 00000000 0102030405060708")).value();
    EXPECT_EQ(address.family, 0x0A00);
    EXPECT_EQ(hex(address.zero), "01 02 03 04 05 06 07 08");
    EXPECT_EQ(hex(address.encode()), hex("0A00 0000 00000000 0102030405060708"));
}

TEST(SocketAddress, R_CPF_9_every_other_length_is_refused) {
    const auto whole = SocketAddress{.port = 2222}.encode();
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_EQ(error_of(SocketAddress::parse(ByteView(whole).first(length))), DecodeError::truncated) << length;
    }
    EXPECT_EQ(error_of(SocketAddress::parse(test::operator+(whole, {0}))), DecodeError::trailing);
}

}  // namespace
}  // namespace servobus::enip
