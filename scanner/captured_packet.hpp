// A packet of a capture, freed of its link layer: UDP and TCP over IPv4.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "cip/bytes.hpp"
#include "enip/endpoint.hpp"
#include "scanner/pcapng.hpp"

namespace servobus::scanner {

struct CapturedPacket {
    enum class Transport : std::uint8_t { udp, tcp };

    CaptureTime time{};
    Transport transport = Transport::udp;
    enip::Endpoint source;
    enip::Endpoint destination;
    std::uint32_t sequence = 0;  ///< of TCP
    bool syn = false;
    bool fin = false;  ///< or a reset
    cip::ByteView payload;
};

/// Why a frame is no packet that counts here.
enum class FrameFault : std::uint8_t {
    none,
    foreign,    ///< another protocol; nothing wrong with it
    fragment,   ///< of an IPv4 datagram: they are not put together
    cut,        ///< the capture has kept less than there was
    malformed,  ///< lengths that contradict each other
};

/// Link types of captures (LINKTYPE_...).
enum class LinkType : std::uint16_t {
    null = 0,
    ethernet = 1,
    raw_bsd = 12,
    raw_openbsd = 14,
    raw = 101,
    loop = 108,
    linux_cooked = 113,
    raw_ipv4 = 228,
    linux_cooked_v2 = 276,
};
[[nodiscard]] bool is_known(LinkType type);

/// VLAN tags in a row that are passed over.
inline constexpr std::size_t max_vlan_tags = 2;

/// Takes a frame apart. `original_octets` is what it had on the wire. `packet` is filled in when there is no fault, but
/// for its time; its payload lies in `frame`.
[[nodiscard]] FrameFault read_frame(LinkType type, cip::ByteView frame, std::size_t original_octets,
                                    CapturedPacket& packet);

}  // namespace servobus::scanner
