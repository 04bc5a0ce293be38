#include "enip/messages.hpp"

#include "cip/strings.hpp"
#include "cip/wire.hpp"
#include "enip/socket_address.hpp"

namespace servobus::enip {
namespace {

constexpr std::size_t service_name_octets = 16;

template <class Message, class Describe>
cip::Decoded<Message> parse_all(cip::ByteView data, Describe describe) {
    cip::Reader reader(data);
    Message message;
    describe(reader, message);
    if (!reader.ok()) return cip::DecodeError::truncated;
    if (reader.remaining() > 0) return cip::DecodeError::trailing;
    return message;
}

void describe_registration(auto& io, auto& message) {
    io.field(message.version);
    io.field(message.options);
}

void describe_identity(auto& io, auto& item) {
    io.field(item.version);
    describe_address(io, item.socket);
    io.field(item.vendor);
    io.field(item.device_type);
    io.field(item.product_code);
    io.field(item.major_revision);
    io.field(item.minor_revision);
    io.field(item.status);
    io.field(item.serial_number);
}

template <class Message, class Packet>
cip::Decoded<Message> parse_send_data(cip::ByteView data) {
    cip::Reader reader(data);
    Message message;
    reader.field(message.interface_handle);
    reader.field(message.timeout);
    if (!reader.ok()) return cip::DecodeError::truncated;
    auto packet = Packet::parse(reader.rest());
    if (!packet) return packet.error();
    message.packet = std::move(*packet);
    return message;
}

// Of items that are owned, or seen.
cip::Decoded<cip::ByteView> unconnected_of(std::uint32_t interface_handle, const auto& items) {
    if (interface_handle != 0 || items.size() < 2) return cip::DecodeError::bad_value;
    const auto& address = items[0];
    const auto& message = items[1];
    if (address.type != ItemType::null_address || !address.data.empty()) return cip::DecodeError::bad_value;
    if (message.type != ItemType::unconnected_data) return cip::DecodeError::bad_value;
    return cip::ByteView(message.data);
}

cip::Decoded<ConnectedMessage> connected_of(std::uint32_t interface_handle, const auto& items) {
    if (interface_handle != 0 || items.size() < 2) return cip::DecodeError::bad_value;
    const auto& address = items[0];
    const auto& data = items[1];
    if (address.type != ItemType::connected_address || data.type != ItemType::connected_data) {
        return cip::DecodeError::bad_value;
    }
    cip::Reader id(address.data);
    cip::Reader payload(data.data);
    ConnectedMessage message;
    id.field(message.connection_id);
    payload.field(message.sequence);
    if (!id.done() || !payload.ok()) return cip::DecodeError::bad_length;
    message.message = payload.rest();
    return message;
}

constexpr std::size_t send_data_head_octets = 6;
constexpr std::size_t item_count_octets = 2;
constexpr std::size_t item_head_octets = 4;

// What stands in front of the packet.
void write_send_data_head(cip::Writer& writer, std::uint32_t interface_handle, std::uint16_t timeout) {
    writer.u32(interface_handle);
    writer.u16(timeout);
}

// A SendData up to its first item, with room for the rest: items with so many octets of data in all.
cip::Bytes begin_reply(std::size_t items, std::size_t octets) {
    cip::Bytes bytes;
    bytes.reserve(send_data_head_octets + item_count_octets + items * item_head_octets + octets);
    cip::Writer writer(bytes);
    write_send_data_head(writer, 0, 0);
    writer.u16(static_cast<std::uint16_t>(items));
    return bytes;
}

}  // namespace

cip::Bytes RegisterSession::encode() const {
    cip::Bytes bytes;
    cip::Writer writer(bytes);
    describe_registration(writer, *this);
    return bytes;
}

cip::Decoded<RegisterSession> RegisterSession::parse(cip::ByteView data) {
    return parse_all<RegisterSession>(data,
                                      [](auto& reader, auto& message) { describe_registration(reader, message); });
}

cip::Bytes IdentityItem::encode() const {
    cip::Bytes bytes;
    cip::Writer writer(bytes);
    describe_identity(writer, *this);
    cip::write_short_string(writer, product_name);
    writer.u8(state);
    return bytes;
}

cip::Decoded<IdentityItem> IdentityItem::parse(cip::ByteView data) {
    return parse_all<IdentityItem>(data, [](cip::Reader& reader, IdentityItem& item) {
        describe_identity(reader, item);
        item.product_name = cip::read_short_string(reader);
        reader.field(item.state);
    });
}

cip::Bytes ServiceItem::encode() const {
    cip::Bytes bytes;
    cip::Writer writer(bytes);
    writer.u16(version);
    writer.u16(flags);
    auto padded = name;
    padded.resize(service_name_octets, '\0');
    for (const char c : padded) writer.u8(static_cast<std::uint8_t>(c));
    return bytes;
}

cip::Decoded<ServiceItem> ServiceItem::parse(cip::ByteView data) {
    return parse_all<ServiceItem>(data, [](cip::Reader& reader, ServiceItem& item) {
        reader.field(item.version);
        reader.field(item.flags);
        const auto padded = reader.take(service_name_octets);
        item.name.assign(padded.begin(), padded.end());
        item.name.erase(std::min(item.name.find('\0'), item.name.size()));
    });
}

cip::Bytes SendData::encode() const {
    cip::Bytes bytes;
    bytes.reserve(send_data_head_octets + packet.encoded_size());
    cip::Writer writer(bytes);
    write_send_data_head(writer, interface_handle, timeout);
    packet.write(writer);
    return bytes;
}

cip::Decoded<SendData> SendData::parse(cip::ByteView data) { return parse_send_data<SendData, CommonPacket>(data); }

cip::Decoded<SendDataView> SendDataView::parse(cip::ByteView data) {
    return parse_send_data<SendDataView, CommonPacketView>(data);
}

SendData SendData::unconnected(cip::Bytes message) {
    SendData data;
    data.packet.items.reserve(2);
    data.packet.items.push_back({ItemType::null_address, {}});
    data.packet.items.push_back({ItemType::unconnected_data, std::move(message)});
    return data;
}

SendData SendData::connected(std::uint32_t connection_id, std::uint16_t sequence, cip::ByteView message) {
    SendData data;
    Item address{ItemType::connected_address, {}};
    cip::Writer(address.data).u32(connection_id);
    Item payload{ItemType::connected_data, {}};
    payload.data.reserve(2 + message.size());
    cip::Writer writer(payload.data);
    writer.u16(sequence);
    writer.bytes(message);
    data.packet.items.reserve(2);
    data.packet.items.push_back(std::move(address));
    data.packet.items.push_back(std::move(payload));
    return data;
}

cip::Decoded<cip::ByteView> unconnected_message(const SendData& data) {
    return unconnected_of(data.interface_handle, data.packet.items);
}

cip::Decoded<cip::ByteView> unconnected_message(const SendDataView& data) {
    return unconnected_of(data.interface_handle, data.packet);
}

cip::Decoded<ConnectedMessage> connected_message(const SendData& data) {
    return connected_of(data.interface_handle, data.packet.items);
}

cip::Decoded<ConnectedMessage> connected_message(const SendDataView& data) {
    return connected_of(data.interface_handle, data.packet);
}

cip::Bytes unconnected_reply(const cip::Response& response, std::span<const ItemView> beside) {
    auto octets = response.encoded_size();
    for (const auto& item : beside) octets += item.data.size();
    auto bytes = begin_reply(2 + beside.size(), octets);
    cip::Writer writer(bytes);
    write_item_head(writer, ItemType::null_address, 0);
    write_item_head(writer, ItemType::unconnected_data, response.encoded_size());
    response.write(writer);
    for (const auto& item : beside) {
        write_item_head(writer, item.type, item.data.size());
        writer.bytes(item.data);
    }
    return bytes;
}

cip::Bytes connected_reply(std::uint32_t connection_id, std::uint16_t sequence, cip::ByteView message) {
    const auto payload_octets = sizeof(sequence) + message.size();
    auto bytes = begin_reply(2, sizeof(connection_id) + payload_octets);
    cip::Writer writer(bytes);
    write_item_head(writer, ItemType::connected_address, sizeof(connection_id));
    writer.u32(connection_id);
    write_item_head(writer, ItemType::connected_data, payload_octets);
    writer.u16(sequence);
    writer.bytes(message);
    return bytes;
}

}  // namespace servobus::enip
