#include "enip/common_packet.hpp"

#include <algorithm>

#include "enip/socket_address.hpp"

namespace servobus::enip {
namespace {

ItemView read_item(cip::Reader& reader) {
    ItemView item;
    reader.field(item.type);
    const auto length = reader.u16();
    item.data = reader.take(length);
    return item;
}

}  // namespace

cip::Bytes CommonPacket::encode() const {
    cip::Bytes bytes;
    bytes.reserve(encoded_size());
    cip::Writer writer(bytes);
    write(writer);
    return bytes;
}

std::size_t CommonPacket::encoded_size() const {
    std::size_t size = 2;
    for (const auto& item : items) size += 4 + item.data.size();
    return size;
}

void CommonPacket::write(cip::Writer& writer) const {
    writer.u16(static_cast<std::uint16_t>(items.size()));
    for (const auto& item : items) {
        write_item_head(writer, item.type, item.data.size());
        writer.bytes(item.data);
    }
}

void write_item_head(cip::Writer& writer, ItemType type, std::size_t octets) {
    writer.field(type);
    writer.u16(static_cast<std::uint16_t>(octets));
}

cip::Decoded<CommonPacket> CommonPacket::parse(cip::ByteView bytes) {
    const auto view = CommonPacketView::parse(bytes);
    if (!view) return view.error();
    CommonPacket packet;
    packet.items.reserve(view->size());
    for (std::size_t i = 0; i < view->size(); ++i) {
        const auto item = (*view)[i];
        packet.items.push_back({item.type, {item.data.begin(), item.data.end()}});
    }
    return packet;
}

cip::Decoded<CommonPacketView> CommonPacketView::parse(cip::ByteView bytes) {
    cip::Reader reader(bytes);
    CommonPacketView packet;
    packet.count_ = reader.u16();
    if (!reader.ok()) return cip::DecodeError::truncated;
    if (packet.count_ > max_items) return cip::DecodeError::too_many;
    packet.items_ = reader.rest();
    for (std::size_t i = 0; i < packet.count_; ++i) static_cast<void>(read_item(reader));
    if (!reader.ok()) return cip::DecodeError::truncated;
    if (reader.remaining() > 0) return cip::DecodeError::trailing;
    return packet;
}

ItemView CommonPacketView::operator[](std::size_t index) const {
    cip::Reader reader(items_);
    for (; index > 0; --index) static_cast<void>(read_item(reader));
    return read_item(reader);
}

const Item* CommonPacket::find(ItemType type) const {
    const auto found = std::ranges::find(items, type, &Item::type);
    return found != items.end() ? &*found : nullptr;
}

cip::Bytes SocketAddress::encode() const {
    cip::Bytes bytes;
    cip::Writer writer(bytes);
    describe_address(writer, *this);
    return bytes;
}

cip::Decoded<SocketAddress> SocketAddress::parse(cip::ByteView bytes) {
    cip::Reader reader(bytes);
    SocketAddress address;
    describe_address(reader, address);
    if (!reader.ok()) return cip::DecodeError::truncated;
    if (reader.remaining() > 0) return cip::DecodeError::trailing;
    return address;
}

}  // namespace servobus::enip
