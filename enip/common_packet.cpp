#include "enip/common_packet.hpp"

#include <algorithm>

#include "enip/socket_address.hpp"

namespace servobus::enip {

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
        writer.field(item.type);
        writer.u16(static_cast<std::uint16_t>(item.data.size()));
        writer.bytes(item.data);
    }
}

cip::Decoded<CommonPacket> CommonPacket::parse(cip::ByteView bytes) {
    cip::Reader reader(bytes);
    CommonPacket packet;
    const std::size_t count = reader.u16();
    if (!reader.ok()) return cip::DecodeError::truncated;
    if (count > max_items) return cip::DecodeError::too_many;
    packet.items.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        Item item;
        reader.field(item.type);
        const auto length = reader.u16();
        const auto data = reader.take(length);
        if (!reader.ok()) return cip::DecodeError::truncated;
        item.data.assign(data.begin(), data.end());
        packet.items.push_back(std::move(item));
    }
    if (reader.remaining() > 0) return cip::DecodeError::trailing;
    return packet;
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
