#include "enip/asio/managed_interface.hpp"

#include <fmt/format.h>
#include <net/if.h>

#include <chrono>
#include <utility>

#include "enip/endpoint.hpp"

namespace servobus::enip::asio {
namespace {

constexpr std::uint16_t dhcp_client_port = 68;

// After it could not listen at its address.
constexpr std::chrono::seconds listen_pause{5};

std::string text_of(const InterfaceAddress& address) {
    return fmt::format("{}/{}", address_text(address.address), address.prefix);
}

}  // namespace

ManagedInterface::ManagedInterface(boost::asio::io_context& context, TargetStation& station, AddressUser& user,
                                   std::function<void(const std::string&)> problem)
    : station_(station),
      user_(user),
      problem_(std::move(problem)),
      link_(context, user, Traffic::addressing, [this] { station_.after_line(); }),
      again_(context) {}

std::optional<ListenError> ManagedInterface::open(ManageOptions options) {
    options_ = std::move(options);
    const auto& interface = options_.interface;
    if (auto reason = link_.open({interface})) return ListenError{*std::move(reason)};
    addresses_ = std::make_unique<InterfaceAddresses>(::if_nametoindex(interface.c_str()));
    if (!addresses_->allowed()) {
        return ListenError{fmt::format("the address of {} cannot be set: it takes root or CAP_NET_ADMIN", interface)};
    }
    for (const auto& left : addresses_->remove_leftovers()) {
        report(fmt::format("{} had {} of a program that did not end in order; it is taken away", interface,
                           text_of(left)));
    }
    silent_ = std::make_unique<SilentPort>(interface, dhcp_client_port);
    return std::nullopt;
}

void ManagedInterface::settle() {
    if (!addresses_) return;
    move_to(user_.address());
    link_.settle();
}

void ManagedInterface::move_to(const std::optional<InterfaceAddress>& wanted) {
    if (wanted == address_) return;
    const bool stays = wanted && address_ && wanted->address == address_->address;
    address_ = wanted;
    if (!stays) {
        again_.cancel();
        station_.leave();
    }
    if (const auto error = addresses_->set(wanted)) {
        report(fmt::format("{} cannot be set on {}: {}", text_of(*wanted), options_.interface, error.message()));
        return;
    }
    if (wanted && !stays) listen();
}

void ManagedInterface::listen() {
    const auto listening = station_.listen(
        {.address = address_text(address_->address), .port = options_.port, .io_port = options_.io_port});
    if (listening) {
        options_.listens(*listening);
        return;
    }
    report(listening.error().reason);
    again_.expires_after(listen_pause);
    again_.async_wait([this](const boost::system::error_code& cancelled) {
        if (!cancelled && address_ && addresses_) listen();
    });
}

void ManagedInterface::shut_down() {
    again_.cancel();
    link_.shut_down();
    addresses_.reset();
}

}  // namespace servobus::enip::asio
