#include "adapter/udp_frame.hpp"

#include <cstddef>

#include "adapter/ethernet_frame.hpp"
#include "cip/wire.hpp"

namespace servobus::adapter {
namespace {

constexpr std::uint8_t version_and_words = 0x45;  // IPv4, a header without options
constexpr std::size_t ip_octets = 20;
constexpr std::size_t udp_octets = 8;
constexpr std::size_t ip_checksum_at = 10;
constexpr std::size_t udp_checksum_at = 6;
constexpr std::uint8_t time_to_live = 64;
constexpr std::uint8_t udp = 17;
constexpr std::uint16_t fragmented = 0x3FFF;  // more fragments, or an offset

// The sum of RFC 1071, not yet complemented.
std::uint16_t sum_of(cip::ByteView octets, std::uint32_t sum = 0) {
    for (std::size_t i = 0; i < octets.size(); ++i) sum += i % 2 == 0 ? std::uint32_t{octets[i]} << 8 : octets[i];
    while (sum >> 16 != 0) sum = (sum & 0xFFFF) + (sum >> 16);
    return static_cast<std::uint16_t>(sum);
}

// What the UDP checksum covers beside the datagram.
std::uint16_t pseudo_header_sum(std::uint32_t source, std::uint32_t destination, std::size_t length) {
    cip::Bytes header;
    cip::Writer writer(header);
    writer.big(source);
    writer.big(destination);
    writer.big(std::uint16_t{udp});
    writer.big(static_cast<std::uint16_t>(length));
    return sum_of(header);
}

void put_checksum(cip::Bytes& octets, std::size_t at, std::uint16_t checksum) {
    octets[at] = static_cast<std::uint8_t>(checksum >> 8);
    octets[at + 1] = static_cast<std::uint8_t>(checksum);
}

cip::Bytes encode_udp(const UdpFrame& frame) {
    cip::Bytes octets;
    cip::Writer writer(octets);
    writer.big(frame.source.port);
    writer.big(frame.destination.port);
    const auto length = udp_octets + frame.payload.size();
    writer.big(static_cast<std::uint16_t>(length));
    writer.u16(0);
    writer.bytes(frame.payload);
    const auto sum = sum_of(octets, pseudo_header_sum(frame.source.address, frame.destination.address, length));
    const auto checksum = static_cast<std::uint16_t>(~sum);
    put_checksum(octets, udp_checksum_at, checksum == 0 ? 0xFFFF : checksum);  // 0 would mean that there is none
    return octets;
}

cip::Bytes encode_ip(const UdpFrame& frame, cip::ByteView datagram) {
    cip::Bytes octets;
    cip::Writer writer(octets);
    writer.u8(version_and_words);
    writer.u8(0);  // type of service
    writer.big(static_cast<std::uint16_t>(ip_octets + datagram.size()));
    writer.u16(0);  // identification: it is never a fragment
    writer.u16(0);  // flags and offset
    writer.u8(time_to_live);
    writer.u8(udp);
    writer.u16(0);
    writer.big(frame.source.address);
    writer.big(frame.destination.address);
    put_checksum(octets, ip_checksum_at, static_cast<std::uint16_t>(~sum_of(octets)));
    writer.bytes(datagram);
    return octets;
}

struct IpHeader {
    std::uint32_t source = 0;
    std::uint32_t destination = 0;
    cip::ByteView payload;
};

cip::Decoded<IpHeader> parse_ip(cip::ByteView octets) {
    cip::Reader reader(octets);
    const auto version = reader.u8();
    const std::size_t header_octets = std::size_t{4} * (version & 0x0FU);
    reader.u8();
    const std::size_t total = reader.big<std::uint16_t>();
    reader.u16();
    const auto fragment = reader.big<std::uint16_t>();
    reader.u8();
    const auto protocol = reader.u8();
    reader.u16();
    IpHeader header;
    reader.big_endian_field(header.source);
    reader.big_endian_field(header.destination);
    if (!reader.ok()) return cip::DecodeError::truncated;
    if (version >> 4 != 4 || protocol != udp || (fragment & fragmented) != 0) return cip::DecodeError::bad_value;
    if (header_octets < ip_octets || total < header_octets) return cip::DecodeError::bad_length;
    if (total > octets.size()) return cip::DecodeError::truncated;
    if (sum_of(octets.first(header_octets)) != 0xFFFF) return cip::DecodeError::bad_value;
    header.payload = octets.subspan(header_octets, total - header_octets);
    return header;
}

}  // namespace

cip::Bytes UdpFrame::encode() const {
    const auto packet = encode_ip(*this, encode_udp(*this));
    return EthernetFrame{
        .destination = destination_mac, .source = source_mac, .type = EtherType::ipv4, .payload = packet}
        .encode();
}

cip::Decoded<UdpFrame> UdpFrame::parse(cip::ByteView octets, bool checksummed) {
    const auto ethernet = EthernetFrame::parse(octets);
    if (!ethernet) return ethernet.error();
    if (ethernet->type != EtherType::ipv4) return cip::DecodeError::bad_value;
    const auto ip = parse_ip(ethernet->payload);
    if (!ip) return ip.error();
    UdpFrame frame{.destination_mac = ethernet->destination, .source_mac = ethernet->source};
    frame.source.address = ip->source;
    frame.destination.address = ip->destination;
    cip::Reader reader(ip->payload);
    reader.big_endian_field(frame.source.port);
    reader.big_endian_field(frame.destination.port);
    const std::size_t length = reader.big<std::uint16_t>();
    const auto checksum = reader.big<std::uint16_t>();
    if (!reader.ok()) return cip::DecodeError::truncated;
    if (length < udp_octets || length > ip->payload.size()) return cip::DecodeError::bad_length;
    const auto datagram = ip->payload.first(length);
    const auto sum = sum_of(datagram, pseudo_header_sum(ip->source, ip->destination, length));
    if (checksummed && checksum != 0 && sum != 0xFFFF) return cip::DecodeError::bad_value;
    frame.payload = datagram.subspan(udp_octets);
    return frame;
}

}  // namespace servobus::adapter
