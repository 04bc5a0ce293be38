// What can be set of the device's network, and is kept over a power cycle: behind the classes 0xF5, 0xF6, 0x48 and 0x43.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string>

#include "cip/bytes.hpp"
#include "enip/dscp.hpp"

namespace servobus::adapter {

/// Attribute 5 of the TCP/IP Interface object (R-TCP-6). IPv4 addresses in host order.
struct InterfaceConfiguration {
    std::uint32_t address = 0;
    std::uint32_t mask = 0;
    std::uint32_t gateway = 0;
    std::uint32_t name_server_1 = 0;
    std::uint32_t name_server_2 = 0;
    std::string domain{};
    friend bool operator==(const InterfaceConfiguration&, const InterfaceConfiguration&) = default;
};

/// How the device gets its address: attribute 3, bits 3..0 (R-TCP-4). On an ordinary host the address is given by the
/// host, so this is what a client reads and sets, and nothing asks a server (R-DHC-5).
enum class AddressMethod : std::uint8_t { stored = 0, bootp = 1, dhcp = 2 };

/// Attribute 9 (R-MC-2). Not chosen: the addresses follow from the device's own (R-MC-1), and the rest does not count.
struct MulticastAllocation {
    bool chosen = false;
    std::uint16_t count = 1;  ///< 1..32
    std::uint32_t start = 0;  ///< of class D, in host order
    friend bool operator==(const MulticastAllocation&, const MulticastAllocation&) = default;
};

/// Attribute 11 of 0xF5 (R-TCP-10): all zero while no conflict has been seen.
using LastConflict = std::array<std::uint8_t, 35>;

/// DSCP values of 0x48 (R-QOS-2).
struct QualityOfService {
    std::uint8_t tag_enable = 0;
    /// Attributes 4 to 8: urgent, scheduled, high, low, explicit.
    std::array<std::uint8_t, 5> dscp{enip::dscp_urgent, enip::dscp_scheduled, enip::dscp_high, enip::dscp_low,
                                     enip::dscp_explicit};
    /// Attributes 2 and 3: PTP event and general messages.
    std::array<std::uint8_t, 2> ptp_dscp{enip::dscp_ptp_event, enip::dscp_ptp_general};
    friend bool operator==(const QualityOfService&, const QualityOfService&) = default;
};

/// Of the Time Sync object (0x43).
struct TimeSyncSettings {
    bool enabled = true;  ///< attribute 1
    std::uint64_t max_offset_from_master =
        1'000'000;  ///< attribute 6, in ns: a clock that is farther off is not synchronised
    friend bool operator==(const TimeSyncSettings&, const TimeSyncSettings&) = default;
};

struct NetworkSettings {
    AddressMethod method = AddressMethod::dhcp;  ///< 000 §2.1: DHCP is on by default
    InterfaceConfiguration configured;           ///< the address that is in force when the method is `stored`
    std::string host_name;
    std::uint8_t ttl = 1;  ///< attribute 8, of what is produced by multicast (R-IO-11)
    MulticastAllocation multicast;
    bool select_acd = true;  ///< attribute 10; in force from the next restart on (R-TCP-9)
    LastConflict last_conflict{};
    std::uint16_t inactivity_seconds = 120;  ///< attribute 13; it is in force at once (R-TCP-11)
    /// Per port: attribute 6 of 0xF6, control bits and forced speed (R-ETH-6).
    struct LinkControl {
        std::uint16_t bits = 1;
        std::uint16_t forced_speed = 0;
        friend bool operator==(const LinkControl&, const LinkControl&) = default;
    };
    std::array<LinkControl, 2> links{};
    QualityOfService qos;
    TimeSyncSettings time_sync;
    friend bool operator==(const NetworkSettings&, const NetworkSettings&) = default;
};

}  // namespace servobus::adapter
