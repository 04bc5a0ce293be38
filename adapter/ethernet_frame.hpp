// An Ethernet II frame without its check sequence, with or without a VLAN tag.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "adapter/mac_address.hpp"
#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"

namespace servobus::adapter {

enum class EtherType : std::uint16_t { ipv4 = 0x0800, arp = 0x0806, vlan = 0x8100, ring = 0x80E1 };

struct EthernetFrame {
    MacAddress destination{};
    MacAddress source{};
    std::optional<std::uint16_t> vlan_tag{};  ///< priority, drop eligible, VLAN id, as they stand in the tag
    EtherType type{};                         ///< of the payload
    cip::ByteView payload;                    ///< of the caller; when it was received, with the padding

    /// Filled up to the shortest payload that Ethernet has.
    [[nodiscard]] cip::Bytes encode() const;
    /// `truncated`: it ends within its header. The payload is part of `octets`.
    [[nodiscard]] static cip::Decoded<EthernetFrame> parse(cip::ByteView octets);
};

inline constexpr std::size_t shortest_payload = 46;

}  // namespace servobus::adapter
