// Where a datagram or a connection comes from and goes to.
#pragma once

#include <cstdint>
#include <string>

namespace servobus::enip {

/// An IPv4 address and port, in host order.
struct Endpoint {
    std::uint32_t address = 0;
    std::uint16_t port = 0;
    friend auto operator<=>(const Endpoint&, const Endpoint&) = default;  // NOLINT(modernize-use-nullptr): misread
};

/// `192.168.2.100`.
[[nodiscard]] std::string address_text(std::uint32_t address);
/// `192.168.2.100:44818`.
[[nodiscard]] std::string to_string(Endpoint endpoint);

/// Class D, 224.0.0.0 to 239.255.255.255.
[[nodiscard]] constexpr bool is_multicast(std::uint32_t address) { return address >> 28 == 0xE; }

}  // namespace servobus::enip
