// ARP for IPv4 over Ethernet (RFC 826), and the two packets that address conflict detection sends (R-ACD-2).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "adapter/mac_address.hpp"
#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"

namespace servobus::adapter {

/// IPv4 addresses in host order.
struct ArpPacket {
    enum class Operation : std::uint16_t { request = 1, reply = 2 };
    static constexpr std::size_t octets = 28;

    Operation operation = Operation::request;
    MacAddress sender_mac{};
    std::uint32_t sender_address = 0;
    MacAddress target_mac{};
    std::uint32_t target_address = 0;

    [[nodiscard]] cip::Bytes encode() const;
    /// `truncated`, or `bad_value` when it is for other addresses than these or neither request nor reply. Padding is
    /// ignored.
    [[nodiscard]] static cip::Decoded<ArpPacket> parse(cip::ByteView payload);
    friend bool operator==(const ArpPacket&, const ArpPacket&) = default;

    /// Somebody asks whether an address is free, without having one.
    [[nodiscard]] bool is_probe() const { return operation == Operation::request && sender_address == 0; }
};

/// Whole frames to everybody: is this address free? And: it is mine.
[[nodiscard]] cip::Bytes arp_probe(const MacAddress& own, std::uint32_t address);
[[nodiscard]] cip::Bytes arp_announcement(const MacAddress& own, std::uint32_t address);

}  // namespace servobus::adapter
