// The IPv4 addresses of this machine and the interfaces that they belong to.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace servobus::enip::asio {

/// One address of an interface. Addresses in host order.
struct Interface {
    std::string name{};
    unsigned index = 0;
    std::uint32_t address = 0;
    std::uint32_t mask = 0;
    bool loopback = false;
    /// Up, and a datagram to its broadcast address arrives. Loopback has no broadcast flag and still delivers to
    /// 127.255.255.255.
    bool broadcasts = false;

    /// The directed broadcast of the subnet.
    [[nodiscard]] std::uint32_t broadcast() const { return address | ~mask; }
};

/// All of them; none when the system does not tell.
[[nodiscard]] std::vector<Interface> interfaces();

/// The one that an address belongs to. The whole of 127.0.0.0/8 belongs to the loopback interface, any other address only
/// to its own. Nullopt for 0.0.0.0 and for an address that no interface covers.
[[nodiscard]] std::optional<Interface> interface_of(std::uint32_t address);

}  // namespace servobus::enip::asio
