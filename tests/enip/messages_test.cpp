// The data portions of the encapsulation commands.
#include "enip/messages.hpp"

#include <gtest/gtest.h>

#include <string>

#include "enip/encapsulation.hpp"
#include "enip/target.hpp"
#include "tests/support/octets.hpp"

namespace servobus::enip {
namespace {

using cip::Bytes;
using cip::ByteView;
using cip::DecodeError;
using test::error_of;
using test::hex;
using test::octets;

template <class Message>
void expect_no_other_length(const Bytes& whole) {
    ASSERT_TRUE(Message::parse(whole));
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_EQ(error_of(Message::parse(ByteView(whole).first(length))), DecodeError::truncated) << length;
    }
    EXPECT_EQ(error_of(Message::parse(test::operator+(whole, {0}))), DecodeError::trailing);
}

TEST(RegisterSession, R_ENC_17_version_and_options) {
    EXPECT_EQ(hex(RegisterSession{}.encode()), "01 00 00 00");
    EXPECT_EQ(RegisterSession::parse(octets("02 00 01 80")).value(), (RegisterSession{2, 0x8001}));
    expect_no_other_length<RegisterSession>(octets("01 00 00 00"));
}

constexpr auto identity_octets =
    "0100 0002 AF12 C0A80264 0000000000000000 6D05 2B00 0975 01 02 3000 C3B2A100 0F 58454E415820587669203735563853 03";

IdentityItem identity() {
    IdentityItem item;
    item.socket = {.port = tcp_port, .address = 0xC0A80264};
    item.vendor = 1389;
    item.device_type = 43;
    item.product_code = 0x7509;
    item.major_revision = 1;
    item.minor_revision = 2;
    item.status = 0x0030;
    item.serial_number = 0x00A1B2C3;
    item.product_name = "XENAX Xvi 75V8S";
    item.state = 3;
    return item;
}

TEST(IdentityItem, R_CPF_5_layout) {
    EXPECT_EQ(hex(identity().encode()), hex(identity_octets));
    EXPECT_EQ(identity().encode().size(), 34U + 15U);
    EXPECT_EQ(IdentityItem::parse(octets(identity_octets)).value(), identity());
    expect_no_other_length<IdentityItem>(octets(identity_octets));
}

TEST(IdentityItem, R_CPF_5_without_name_and_with_the_longest) {
    auto item = identity();
    item.product_name.clear();
    EXPECT_EQ(item.encode().size(), 34U);
    EXPECT_EQ(IdentityItem::parse(item.encode()).value(), item);
    item.product_name.assign(255, 'x');
    EXPECT_EQ(IdentityItem::parse(item.encode()).value(), item);
}

TEST(ServiceItem, R_CPF_4_and_R_ENC_12_layout) {
    EXPECT_EQ(hex(ServiceItem{}.encode()), hex("0100 2001 436F6D6D756E69636174696F6E73 0000"));
    EXPECT_EQ(ServiceItem::parse(ServiceItem{}.encode()).value(), ServiceItem{});
    expect_no_other_length<ServiceItem>(ServiceItem{}.encode());
}

TEST(ServiceItem, R_CPF_4_a_name_of_sixteen_characters_has_no_terminator) {
    ServiceItem item;
    item.name = "sixteencharacter";
    EXPECT_EQ(item.encode().size(), 20U);
    EXPECT_EQ(ServiceItem::parse(item.encode()).value(), item);
    item.name += "s";
    EXPECT_EQ(ServiceItem::parse(item.encode()).value().name, "sixteencharacter");
}

TEST(SendData, R_ENC_22_unconnected_layout) {
    const auto data = SendData::unconnected(octets("0E 03 20 64 24 01 30 00"));
    EXPECT_EQ(hex(data.encode()), hex("00000000 0000 0200 0000 0000 B200 0800 0E03206424013000"));
    EXPECT_EQ(SendData::parse(data.encode()).value(), data);
    expect_no_other_length<SendData>(data.encode());
}

TEST(SendData, R_ENC_23_connected_layout) {
    const auto data = SendData::connected(0x56A0000B, 0x0102, octets("0E 00"));
    EXPECT_EQ(hex(data.encode()), hex("00000000 0000 0200 A100 0400 0B00A056 B100 0400 0201 0E00"));
    EXPECT_EQ(SendData::parse(data.encode()).value(), data);
    expect_no_other_length<SendData>(data.encode());
}

TEST(SendData, R_ENC_22_interface_handle_and_timeout_are_read) {
    const auto data = SendData::parse(octets("04030201 0A00 0000")).value();
    EXPECT_EQ(data.interface_handle, 0x01020304U);
    EXPECT_EQ(data.timeout, 10);
}

TEST(UnconnectedMessage, R_ENC_22_is_the_second_item) {
    const auto data = SendData::unconnected(octets("0E 00"));
    EXPECT_EQ(hex(unconnected_message(data).value()), "0E 00");
}

TEST(UnconnectedMessage, R_CPF_10_further_items_are_ignored) {
    auto data = SendData::unconnected(octets("0E 00"));
    data.packet.items.push_back({ItemType::sockaddr_t_to_o, Bytes(16)});
    data.packet.items.push_back({static_cast<ItemType>(0x1234), Bytes(3)});
    EXPECT_EQ(hex(unconnected_message(data).value()), "0E 00");
}

TEST(UnconnectedMessage, R_ENC_22_the_timeout_is_ignored_but_the_interface_handle_is_not) {
    auto data = SendData::unconnected(octets("0E 00"));
    data.timeout = 0xFFFF;
    EXPECT_TRUE(unconnected_message(data));
    data.interface_handle = 1;
    EXPECT_EQ(error_of(unconnected_message(data)), DecodeError::bad_value);
}

TEST(UnconnectedMessage, R_CPF_2_every_other_shape_is_refused) {
    const Item null{ItemType::null_address, {}};
    const Item message{ItemType::unconnected_data, octets("0E 00")};
    const std::vector<CommonPacket> broken{
        {{}},
        {{null}},
        {{message}},
        {{message, null}},
        {{message, message}},
        {{null, null}},
        {{null, {ItemType::connected_data, octets("0100 0E00")}}},
        {{{ItemType::null_address, {0}}, message}},
        {{{ItemType::connected_address, octets("01000000")}, message}},
        {{null, null, message}},
    };
    for (std::size_t i = 0; i < broken.size(); ++i) {
        EXPECT_EQ(error_of(unconnected_message({0, 0, broken[i]})), DecodeError::bad_value) << i;
    }
}

TEST(ConnectedMessage, R_CON_45_id_sequence_message) {
    const auto data = SendData::connected(0x56A0000B, 0xFFFE, octets("0E 00"));
    const auto message = connected_message(data).value();
    EXPECT_EQ(message.connection_id, 0x56A0000BU);
    EXPECT_EQ(message.sequence, 0xFFFE);
    EXPECT_EQ(hex(message.message), "0E 00");
}

TEST(ConnectedMessage, R_CON_45_the_message_may_be_empty) {
    EXPECT_TRUE(connected_message(SendData::connected(1, 2, {})).value().message.empty());
}

TEST(ConnectedMessage, R_ENC_23_every_other_shape_is_refused) {
    const Item address{ItemType::connected_address, octets("01000000")};
    const Item message{ItemType::connected_data, octets("0100 0E00")};
    const std::vector<CommonPacket> broken{
        {{}},
        {{address}},
        {{message, address}},
        {{address, {ItemType::unconnected_data, octets("0E00")}}},
        {{{ItemType::null_address, {}}, message}},
        {{{ItemType::sequenced_address, octets("0100000001000000")}, message}},
    };
    for (std::size_t i = 0; i < broken.size(); ++i) {
        EXPECT_EQ(error_of(connected_message({0, 0, broken[i]})), DecodeError::bad_value) << i;
    }
    EXPECT_EQ(error_of(connected_message({1, 0, {{address, message}}})), DecodeError::bad_value);
    for (const auto* id : {"", "010000", "0100000000"}) {
        const Item odd{ItemType::connected_address, octets(id)};
        EXPECT_EQ(error_of(connected_message({0, 0, {{odd, message}}})), DecodeError::bad_length) << id;
    }
    for (const auto* payload : {"", "01"}) {
        const Item cut{ItemType::connected_data, octets(payload)};
        EXPECT_EQ(error_of(connected_message({0, 0, {{address, cut}}})), DecodeError::bad_length) << payload;
    }
}

TEST(SendDataView, is_read_like_what_is_owned) {
    const auto unconnected = SendData::unconnected(octets("0E 00")).encode();
    EXPECT_EQ(hex(unconnected_message(SendDataView::parse(unconnected).value()).value()), "0E 00");
    const auto connected = SendData::connected(0x56A0000B, 0xFFFE, octets("0E 00")).encode();
    const auto message = connected_message(SendDataView::parse(connected).value()).value();
    EXPECT_EQ(message.connection_id, 0x56A0000BU);
    EXPECT_EQ(message.sequence, 0xFFFE);
    EXPECT_EQ(hex(message.message), "0E 00");
    EXPECT_EQ(error_of(unconnected_message(SendDataView::parse(connected).value())), DecodeError::bad_value);
    EXPECT_EQ(error_of(connected_message(SendDataView::parse(unconnected).value())), DecodeError::bad_value);
    EXPECT_EQ(error_of(SendDataView::parse(octets("00000000 00"))), DecodeError::truncated);
}

TEST(UnconnectedReply, R_CPF_8_has_the_octets_of_the_packet_that_it_stands_for) {
    const cip::Response response{0x54, cip::ConnectionFailure::ownership_conflict, octets("0102 03")};
    EXPECT_EQ(hex(unconnected_reply(response)), hex(SendData::unconnected(response.encode()).encode()));
    const auto address = octets("0002 08AE EFC00D60 0000000000000000");
    auto beside = SendData::unconnected(response.encode());
    beside.packet.items.push_back({ItemType::sockaddr_t_to_o, address});
    const std::vector<ItemView> items{{ItemType::sockaddr_t_to_o, address}};
    EXPECT_EQ(hex(unconnected_reply(response, items)), hex(beside.encode()));
}

TEST(ConnectedReply, R_CON_45_has_the_octets_of_the_packet_that_it_stands_for) {
    const auto message = octets("8E00 0000 2A");
    EXPECT_EQ(hex(connected_reply(0x56A0000B, 0x0102, message)),
              hex(SendData::connected(0x56A0000B, 0x0102, message).encode()));
}

TEST(Endpoint, has_a_text) { EXPECT_EQ(to_string(Endpoint{0xC0A80264, tcp_port}), "192.168.2.100:44818"); }

}  // namespace
}  // namespace servobus::enip
