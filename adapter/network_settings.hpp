// What can be set of the device's network, and is kept over a power cycle: behind the classes 0xF5, 0xF6 and 0x48.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string>

#include "cip/bytes.hpp"

namespace servobus::adapter {

/// Attribute 5 of the TCP/IP Interface object (R-TCP-6). IPv4 addresses in host order.
struct InterfaceConfiguration {
    std::uint32_t address = 0;
    std::uint32_t mask = 0;
    std::uint32_t gateway = 0;
    std::uint32_t name_server_1 = 0;
    std::uint32_t name_server_2 = 0;
    std::string domain;
};

/// How the device gets its address: attribute 3, bits 3..0 (R-TCP-4). On an ordinary host the address is given by the
/// host, so this is what a client reads and sets, and nothing asks a DHCP server (R-DHC-5).
enum class AddressMethod : std::uint8_t { stored = 0, dhcp = 2 };

/// Attribute 11 of 0xF5 (R-TCP-10): all zero while no conflict has been seen.
using LastConflict = std::array<std::uint8_t, 35>;

/// DSCP values of 0x48 by attribute 4 to 8 (R-QOS-2).
struct QualityOfService {
    std::uint8_t tag_enable = 0;
    std::array<std::uint8_t, 5> dscp{55, 47, 43, 31, 27};  ///< urgent, scheduled, high, low, explicit
};

struct NetworkSettings {
    AddressMethod method = AddressMethod::dhcp;  ///< 000 §2.1: DHCP is on by default
    InterfaceConfiguration configured;           ///< the address that is in force when the method is `stored`
    std::string host_name;
    bool select_acd = true;
    LastConflict last_conflict{};
    std::uint16_t inactivity_seconds = 120;  ///< attribute 13; it is in force at once (R-TCP-11)
    /// Per port: attribute 6 of 0xF6, control bits and forced speed (R-ETH-6).
    struct LinkControl {
        std::uint16_t bits = 1;
        std::uint16_t forced_speed = 0;
    };
    std::array<LinkControl, 2> links{};
    QualityOfService qos;
};

}  // namespace servobus::adapter
