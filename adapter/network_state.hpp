// What is so of the device's network now: found by the program, or agreed with the network; gone with the power.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "adapter/mac_address.hpp"
#include "adapter/network_settings.hpp"
#include "enip/encapsulation.hpp"
#include "enip/interface_facts.hpp"

namespace servobus::adapter {

/// What a ring node reports (R-DLR-2). A device with one interface reports a line (R-DLR-12).
struct RingStatus {
    std::uint8_t topology = 0;
    std::uint8_t status = 0;
    std::uint32_t supervisor_address = 0;
    MacAddress supervisor_mac{};
    std::uint8_t supervisor_precedence = 0;  ///< attribute 11
    bool announce_based = false;             ///< it looks at announcements, not at beacons: attribute 12
};

/// Who cares for the address of the device: bit 0 of attribute 2 of 0xF5 (R-TCP-3).
enum class AddressService : std::uint8_t {
    none,            ///< the host has one, whatever is set (R-DHC-5)
    dhcp_and_bootp,  ///< somebody asks servers for it
};

/// How the device stands with its IPv4 address: what attribute 1 of 0xF5 says (R-TCP-2).
struct AddressStatus {
    bool configured = true;        ///< bits 3..0: an address is in force
    bool pending = false;          ///< bit 5: what was set is not in force yet
    bool conflict = false;         ///< bit 6: somebody else claims the address now
    bool without_address = false;  ///< bit 7: no address can be used because of a conflict
};

struct NetworkState {
    InterfaceConfiguration interface;  ///< in force: attribute 5
    AddressStatus address;
    AddressService address_service = AddressService::none;
    /// The address that the host has, when `interface` is only what clients are told. None: `interface` is real.
    std::optional<InterfaceConfiguration> host{};
    MacAddress mac{0x02, 0x00, 0x00, 0x00, 0x00, 0x64};
    /// Who tells what port 1 and 2 are and have counted, when it is asked. Nobody: port 1 is that of a module at rest, and
    /// nothing is plugged into port 2.
    std::array<std::function<enip::InterfaceFacts()>, 2> ports{};
    std::uint16_t io_port = enip::io_port;  ///< where class 0 and 1 data comes in
    RingStatus ring;

    /// Where datagrams come and go, whatever clients are told.
    [[nodiscard]] const InterfaceConfiguration& place() const { return host ? *host : interface; }
};

/// Both together: what the objects of the classes 0xF5, 0xF6, 0x48 and 0x47 are made of.
struct Network {
    NetworkSettings settings;
    NetworkState state;
};

/// What is set of the address comes into force as far as a host lets it (R-DHC-5): a stored address is what clients are
/// told from now on, and for a lease stands the address of the host.
void apply_address_settings(Network& network);

}  // namespace servobus::adapter
