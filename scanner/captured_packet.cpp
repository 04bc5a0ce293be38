#include "scanner/captured_packet.hpp"

#include <algorithm>

#include "cip/wire.hpp"

namespace servobus::scanner {
namespace {

constexpr std::uint16_t ether_ipv4 = 0x0800;
constexpr std::uint16_t ether_vlan = 0x8100;
constexpr std::uint16_t ether_service_vlan = 0x88A8;
constexpr std::uint8_t protocol_tcp = 6;
constexpr std::uint8_t protocol_udp = 17;
constexpr std::uint32_t family_ipv4 = 2;

constexpr std::size_t ip_octets = 20;
constexpr std::size_t udp_octets = 8;
constexpr std::size_t tcp_octets = 20;

/// Passes over VLAN tags behind an EtherType; the one that follows them.
std::uint16_t behind_tags(cip::Reader& reader, std::uint16_t type) {
    for (std::size_t tags = 0; tags < max_vlan_tags && (type == ether_vlan || type == ether_service_vlan); ++tags) {
        reader.take(2);
        type = reader.big<std::uint16_t>();
    }
    return type;
}

/// Passes over the link layer. False when what follows is not IPv4.
bool skip_link(LinkType type, cip::Reader& reader) {
    switch (type) {
        case LinkType::ethernet:
            reader.take(12);
            return behind_tags(reader, reader.big<std::uint16_t>()) == ether_ipv4;
        case LinkType::linux_cooked:
            reader.take(14);
            return behind_tags(reader, reader.big<std::uint16_t>()) == ether_ipv4;
        case LinkType::linux_cooked_v2: {
            const auto protocol = reader.big<std::uint16_t>();
            reader.take(18);
            return behind_tags(reader, protocol) == ether_ipv4;
        }
        case LinkType::null:
        case LinkType::loop: {
            // In the byte order of whoever has captured it.
            const auto family = reader.u32();
            return family == family_ipv4 || family == family_ipv4 << 24;
        }
        case LinkType::raw_bsd:
        case LinkType::raw_openbsd:
        case LinkType::raw:
        case LinkType::raw_ipv4:
            return true;
    }
    return false;
}

FrameFault read_udp(cip::ByteView octets, CapturedPacket& packet) {
    cip::Reader reader(octets);
    packet.transport = CapturedPacket::Transport::udp;
    packet.source.port = reader.big<std::uint16_t>();
    packet.destination.port = reader.big<std::uint16_t>();
    const auto length = reader.big<std::uint16_t>();
    if (length < udp_octets || length > octets.size()) return FrameFault::malformed;
    packet.payload = octets.subspan(udp_octets, length - udp_octets);
    return FrameFault::none;
}

FrameFault read_tcp(cip::ByteView octets, CapturedPacket& packet) {
    cip::Reader reader(octets);
    packet.transport = CapturedPacket::Transport::tcp;
    packet.source.port = reader.big<std::uint16_t>();
    packet.destination.port = reader.big<std::uint16_t>();
    packet.sequence = reader.big<std::uint32_t>();
    reader.take(4);
    const std::size_t header = (reader.u8() >> 4) * std::size_t{4};
    const auto flags = reader.u8();
    if (!reader.ok() || header < tcp_octets || header > octets.size()) return FrameFault::malformed;
    packet.syn = (flags & 0x02) != 0;
    packet.fin = (flags & 0x05) != 0;
    packet.payload = octets.subspan(header);
    return FrameFault::none;
}

FrameFault read_ipv4(cip::ByteView octets, bool cut, CapturedPacket& packet) {
    if (octets.empty() || octets[0] >> 4 != 4) return FrameFault::foreign;
    const auto too_short = cut ? FrameFault::cut : FrameFault::malformed;
    if (octets.size() < ip_octets) return too_short;
    const std::size_t header = (octets[0] & 0x0F) * std::size_t{4};
    cip::Reader reader(octets.subspan(2));
    // A card that cuts long TCP sends itself is given datagrams without a length.
    const auto stated = reader.big<std::uint16_t>();
    const std::size_t total = stated == 0 ? octets.size() : stated;
    reader.take(2);
    const auto fragment = reader.big<std::uint16_t>();
    reader.take(1);
    const auto protocol = reader.u8();
    reader.take(2);
    packet.source.address = reader.big<std::uint32_t>();
    packet.destination.address = reader.big<std::uint32_t>();
    if (protocol != protocol_tcp && protocol != protocol_udp) return FrameFault::foreign;
    if (header < ip_octets || header > total) return FrameFault::malformed;
    if ((fragment & 0x3FFF) != 0) return FrameFault::fragment;
    if (total > octets.size()) return too_short;
    // Short frames are padded: what is behind the datagram is not its payload.
    const auto transport = octets.first(total).subspan(header);
    return protocol == protocol_udp ? read_udp(transport, packet) : read_tcp(transport, packet);
}

}  // namespace

bool is_known(LinkType type) {
    using enum LinkType;
    constexpr LinkType known[] = {null, ethernet,     raw_bsd,  raw_openbsd,    raw,
                                  loop, linux_cooked, raw_ipv4, linux_cooked_v2};
    return std::ranges::find(known, type) != std::end(known);
}

FrameFault read_frame(LinkType type, cip::ByteView frame, std::size_t original_octets, CapturedPacket& packet) {
    const bool cut = frame.size() < original_octets;
    cip::Reader reader(frame);
    const bool ipv4 = skip_link(type, reader);
    if (!reader.ok()) return cut ? FrameFault::cut : FrameFault::malformed;
    return ipv4 ? read_ipv4(reader.rest(), cut, packet) : FrameFault::foreign;
}

}  // namespace servobus::scanner
