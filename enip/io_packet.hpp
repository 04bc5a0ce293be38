// A class 0 or 1 datagram: a sequenced address item and a data item, without encapsulation header (R-IO-1, R-IO-2).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"

namespace servobus::enip {

/// Octets in front of the data.
inline constexpr std::size_t io_packet_overhead = 18;

struct IoPacket {
    std::uint32_t connection_id = 0;
    std::uint32_t sequence = 0;  ///< of the encapsulation: one more with each datagram
    cip::ByteView data;          ///< of the data item, sequence count and run/idle header included; in the datagram

    /// truncated: an item ends behind the datagram; bad_value: not two items, or others than these (R-IO-7). Octets
    /// behind the items are ignored (R-IO-8).
    [[nodiscard]] static cip::Decoded<IoPacket> parse(cip::ByteView datagram);
};

/// Writes what stands in front of the data. `datagram` has io_packet_overhead octets and those of the data, whose place
/// is returned.
std::span<std::uint8_t> begin_io_packet(std::span<std::uint8_t> datagram, std::uint32_t connection_id,
                                        std::uint32_t sequence);

}  // namespace servobus::enip
