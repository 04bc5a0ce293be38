#include "enip/io_packet.hpp"

#include "cip/wire.hpp"
#include "enip/common_packet.hpp"

namespace servobus::enip {
namespace {

constexpr std::uint16_t item_count = 2;
constexpr std::uint16_t address_octets = 8;

// Little-endian, in place: nothing here may allocate.
template <class T>
std::span<std::uint8_t> put(std::span<std::uint8_t> octets, T value) {
    auto raw = static_cast<std::uint64_t>(value);
    for (auto& octet : octets.first(sizeof(T))) {
        octet = static_cast<std::uint8_t>(raw);
        raw >>= 8;
    }
    return octets.subspan(sizeof(T));
}

}  // namespace

cip::Decoded<IoPacket> IoPacket::parse(cip::ByteView datagram) {
    cip::Reader reader(datagram);
    IoPacket packet;
    const auto count = reader.u16();
    const auto address = reader.little<ItemType>();
    const auto address_length = reader.u16();
    if (!reader.ok()) return cip::DecodeError::truncated;
    if (count != item_count || address != ItemType::sequenced_address || address_length != address_octets) {
        return cip::DecodeError::bad_value;
    }
    packet.connection_id = reader.u32();
    packet.sequence = reader.u32();
    const auto data = reader.little<ItemType>();
    const auto data_length = reader.u16();
    if (!reader.ok()) return cip::DecodeError::truncated;
    if (data != ItemType::connected_data) return cip::DecodeError::bad_value;
    packet.data = reader.take(data_length);
    if (!reader.ok()) return cip::DecodeError::truncated;
    return packet;
}

std::span<std::uint8_t> begin_io_packet(std::span<std::uint8_t> datagram, std::uint32_t connection_id,
                                        std::uint32_t sequence) {
    auto rest = put(datagram, item_count);
    rest = put(rest, static_cast<std::uint16_t>(ItemType::sequenced_address));
    rest = put(rest, address_octets);
    rest = put(rest, connection_id);
    rest = put(rest, sequence);
    rest = put(rest, static_cast<std::uint16_t>(ItemType::connected_data));
    return put(rest, static_cast<std::uint16_t>(datagram.size() - io_packet_overhead));
}

}  // namespace servobus::enip
