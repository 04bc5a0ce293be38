#include "adapter/arp_packet.hpp"

#include "adapter/ethernet_frame.hpp"
#include "cip/wire.hpp"

namespace servobus::adapter {
namespace {

constexpr std::uint16_t ethernet = 1;
constexpr std::uint8_t mac_octets = 6;
constexpr std::uint8_t address_octets = 4;

void describe(auto& io, auto& packet) {
    io.big_endian_field(packet.operation);
    io.field(packet.sender_mac);
    io.big_endian_field(packet.sender_address);
    io.field(packet.target_mac);
    io.big_endian_field(packet.target_address);
}

cip::Bytes to_everybody(const ArpPacket& packet) {
    const auto payload = packet.encode();
    return EthernetFrame{
        .destination = broadcast_mac, .source = packet.sender_mac, .type = EtherType::arp, .payload = payload}
        .encode();
}

}  // namespace

cip::Bytes ArpPacket::encode() const {
    cip::Bytes payload;
    cip::Writer writer(payload);
    writer.big(ethernet);
    writer.big(EtherType::ipv4);
    writer.u8(mac_octets);
    writer.u8(address_octets);
    describe(writer, *this);
    return payload;
}

cip::Decoded<ArpPacket> ArpPacket::parse(cip::ByteView payload) {
    cip::Reader reader(payload);
    const bool known = reader.big<std::uint16_t>() == ethernet && reader.big<EtherType>() == EtherType::ipv4 &&
                       reader.u8() == mac_octets && reader.u8() == address_octets;
    if (!reader.ok()) return cip::DecodeError::truncated;
    if (!known) return cip::DecodeError::bad_value;
    ArpPacket packet;
    describe(reader, packet);
    if (!reader.ok()) return cip::DecodeError::truncated;
    if (packet.operation != Operation::request && packet.operation != Operation::reply) {
        return cip::DecodeError::bad_value;
    }
    return packet;
}

cip::Bytes arp_probe(const MacAddress& own, std::uint32_t address) {
    return to_everybody({.sender_mac = own, .target_address = address});
}

cip::Bytes arp_announcement(const MacAddress& own, std::uint32_t address) {
    return to_everybody({.sender_mac = own, .sender_address = address, .target_address = address});
}

}  // namespace servobus::adapter
