// What is so of the device's network now: found by the program, or agreed with the network; gone with the power.
#pragma once

#include <cstdint>

#include "adapter/mac_address.hpp"
#include "adapter/network_settings.hpp"
#include "enip/encapsulation.hpp"

namespace servobus::adapter {

/// What a ring node reports (R-DLR-2). A device with one interface reports a line (R-DLR-12).
struct RingStatus {
    std::uint8_t topology = 0;
    std::uint8_t status = 0;
    std::uint32_t supervisor_address = 0;
    MacAddress supervisor_mac{};
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
    MacAddress mac{0x02, 0x00, 0x00, 0x00, 0x00, 0x64};
    std::uint16_t io_port = enip::io_port;  ///< where class 0 and 1 data comes in
    RingStatus ring;
};

/// Both together: what the objects of the classes 0xF5, 0xF6, 0x48 and 0x47 are made of.
struct Network {
    NetworkSettings settings;
    NetworkState state;
};

}  // namespace servobus::adapter
