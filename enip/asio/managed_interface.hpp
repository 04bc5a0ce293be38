// An interface whose address a device decides: what the AddressUser wants is set on it, and the target's station listens
// there, as the address comes and goes. Needs CAP_NET_RAW and CAP_NET_ADMIN.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "enip/asio/interface_addresses.hpp"
#include "enip/asio/link_station.hpp"
#include "enip/asio/silent_port.hpp"
#include "enip/asio/target_server.hpp"
#include "enip/asio/target_station.hpp"
#include "enip/link_user.hpp"

namespace servobus::enip::asio {

class ManagedInterface {
public:
    /// Station and user outlive this. `problem`: see TargetServer.
    ManagedInterface(boost::asio::io_context& context, TargetStation& station, AddressUser& user,
                     std::function<void(const std::string&)> problem);

    /// Takes away what a predecessor has left behind. The error is one sentence.
    [[nodiscard]] std::optional<ListenError> open(ManageOptions options);
    [[nodiscard]] std::array<std::uint8_t, 6> mac() const { return link_.mac(); }
    /// Once the station serves.
    void start() { link_.start(); }
    /// Something has happened to the target: another address may be wanted.
    void settle();
    /// Nothing that was set on the interface stays.
    void shut_down();

private:
    void move_to(const std::optional<InterfaceAddress>& wanted);
    void listen();
    void report(const std::string& line) const {
        if (problem_) problem_(line);
    }

    TargetStation& station_;
    AddressUser& user_;
    std::function<void(const std::string&)> problem_;
    LinkStation link_;
    ManageOptions options_;
    std::unique_ptr<InterfaceAddresses> addresses_;
    std::unique_ptr<SilentPort> silent_;
    std::optional<InterfaceAddress> address_;  ///< that was wanted when it was looked at last
    boost::asio::steady_timer again_;
};

}  // namespace servobus::enip::asio
