// What an Ethernet port is and what it has counted: the facts behind the Ethernet Link object (0xF6).
#pragma once

#include <array>
#include <cstdint>

namespace servobus::enip {

/// How a port and its link partner came to speed and duplex: bits 4..2 of attribute 2 (R-ETH-2).
enum class Negotiation : std::uint8_t { in_progress, failed, duplex_defaulted, done, not_attempted };

/// Attribute 4 (R-ETH-4). They wrap, as the 32 bits on the wire do.
struct InterfaceCounters {
    std::uint32_t in_octets = 0;
    std::uint32_t in_unicast = 0;
    std::uint32_t in_non_unicast = 0;
    std::uint32_t in_discards = 0;
    std::uint32_t in_errors = 0;
    std::uint32_t in_unknown_protocols = 0;
    std::uint32_t out_octets = 0;
    std::uint32_t out_unicast = 0;
    std::uint32_t out_non_unicast = 0;
    std::uint32_t out_discards = 0;
    std::uint32_t out_errors = 0;
};

/// Attribute 5 (R-ETH-5).
struct MediaCounters {
    std::uint32_t alignment_errors = 0;
    std::uint32_t fcs_errors = 0;
    std::uint32_t single_collisions = 0;
    std::uint32_t multiple_collisions = 0;
    std::uint32_t sqe_test_errors = 0;
    std::uint32_t deferred_transmissions = 0;
    std::uint32_t late_collisions = 0;
    std::uint32_t excessive_collisions = 0;
    std::uint32_t mac_transmit_errors = 0;
    std::uint32_t carrier_sense_errors = 0;
    std::uint32_t frames_too_long = 0;
    std::uint32_t mac_receive_errors = 0;
};

struct InterfaceFacts {
    bool ethernet = false;  ///< false: the loopback interface; what is counted is all that there is to tell
    bool link = false;
    std::uint32_t speed = 0;  ///< Mbit/s; 0: unknown
    bool full_duplex = false;
    Negotiation negotiation = Negotiation::in_progress;
    std::array<std::uint8_t, 6> mac{};
    InterfaceCounters counters;
    MediaCounters media;
};

}  // namespace servobus::enip
