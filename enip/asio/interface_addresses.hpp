// Address and default route of an interface of this machine, set and taken away. Needs CAP_NET_ADMIN. What it has not set
// itself it does not touch.
#pragma once

#include <boost/system/error_code.hpp>
#include <cstdint>
#include <optional>
#include <vector>

#include "enip/link_user.hpp"

namespace servobus::enip::asio {

/// What marks an address or a route as set by this program: IFA_PROTO (since Linux 5.18), rtm_protocol.
inline constexpr std::uint8_t address_owner = 0x5B;
/// Of the default route: one that somebody else has set, with any usual metric, goes first.
inline constexpr std::uint32_t route_metric = 4200;

class InterfaceAddresses {
public:
    explicit InterfaceAddresses(unsigned interface_index) : interface_index_(interface_index) {}
    /// What was set goes.
    ~InterfaceAddresses() { static_cast<void>(set(std::nullopt)); }
    InterfaceAddresses(const InterfaceAddresses&) = delete;
    InterfaceAddresses& operator=(const InterfaceAddresses&) = delete;

    /// Whether they may be set.
    [[nodiscard]] bool allowed() const;
    /// Takes away what a program of this kind has set on the interface and left behind. Returns the addresses.
    std::vector<InterfaceAddress> remove_leftovers();

    /// The interface has this address from now on, instead of the one that was set before. An address that it had before,
    /// from somebody else, is used and left to him. An error: it has none.
    [[nodiscard]] boost::system::error_code set(const std::optional<InterfaceAddress>& address);

private:
    [[nodiscard]] boost::system::error_code add(const InterfaceAddress& address);
    [[nodiscard]] boost::system::error_code remove(const InterfaceAddress& address);
    [[nodiscard]] boost::system::error_code add_route(std::uint32_t gateway);
    [[nodiscard]] boost::system::error_code remove_route(std::uint32_t gateway);

    unsigned interface_index_;
    std::optional<InterfaceAddress> address_;  ///< that we have set
    std::uint32_t gateway_ = 0;                ///< of the route that we have set
};

}  // namespace servobus::enip::asio
