// A UDP datagram as a whole Ethernet frame: for a node that has no address yet, and so no sockets (RFC 768, RFC 791).
#pragma once

#include <cstdint>

#include "adapter/mac_address.hpp"
#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"
#include "enip/endpoint.hpp"

namespace servobus::adapter {

inline constexpr std::uint32_t broadcast_address = 0xFFFFFFFF;

struct UdpFrame {
    MacAddress destination_mac{};
    MacAddress source_mac{};
    enip::Endpoint source{};
    enip::Endpoint destination{};
    cip::ByteView payload{};  ///< of the caller, or of the frame that was parsed

    /// With both checksums; at most 1472 octets of payload.
    [[nodiscard]] cip::Bytes encode() const;
    /// `truncated`: it ends too early. `bad_length`: its lengths contradict each other. `bad_value`: it is no UDP over
    /// IPv4, a fragment, or a checksum is wrong. `checksummed` is false for a frame of this machine whose UDP checksum
    /// the hardware was to compute.
    [[nodiscard]] static cip::Decoded<UdpFrame> parse(cip::ByteView octets, bool checksummed = true);
};

}  // namespace servobus::adapter
