// What a node that speaks below IP is to its ports: frames and time in, frames and the next deadline out (decision 2).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cip/bytes.hpp"
#include "enip/time.hpp"

namespace servobus::enip {

/// A whole Ethernet frame without its check sequence, with its VLAN tag if it has one.
struct LinkFrame {
    std::size_t port = 0;  ///< of those of the user, from 0 on
    cip::Bytes octets;
};

/// A frame that a port has heard.
struct HeardFrame {
    cip::ByteView octets;
    /// False: it comes from this machine, and the hardware was to put the checksum of UDP into it.
    bool checksummed = true;
};

/// All calls come from one thread at a time; `now` never goes back.
class LinkUser {
public:
    virtual ~LinkUser() = default;

    virtual void on_frame(std::size_t port, const HeardFrame& frame, Time now) = 0;
    /// The port has, or has lost, its link. Before the first call it is taken to have it.
    virtual void on_link(std::size_t port, bool up, Time now) = 0;
    /// To be called at or after next_deadline().
    virtual void on_timer(Time now) = 0;
    [[nodiscard]] virtual std::optional<Time> next_deadline() const = 0;
    /// What is to be sent now.
    [[nodiscard]] virtual std::vector<LinkFrame> take_frames() = 0;

protected:
    LinkUser() = default;
    LinkUser(const LinkUser&) = default;
    LinkUser& operator=(const LinkUser&) = default;
};

/// An address of an interface, in its subnet. In host order.
struct InterfaceAddress {
    std::uint32_t address = 0;
    unsigned prefix = 0;        ///< length of the subnet's
    std::uint32_t gateway = 0;  ///< of everything outside the subnet; 0: there is none
    friend bool operator==(const InterfaceAddress&, const InterfaceAddress&) = default;
};

/// One who decides which address its only port has.
class AddressUser : public LinkUser {
public:
    /// The one that the port is to have now.
    [[nodiscard]] virtual std::optional<InterfaceAddress> address() const = 0;
};

}  // namespace servobus::enip
