#include "enip/asio/interface_addresses.hpp"

#include <linux/if_addr.h>
#include <sys/socket.h>

#include <cerrno>

#include "enip/asio/netlink.hpp"

namespace servobus::enip::asio {
namespace {

using boost::system::error_code;
using netlink::Answer;
using netlink::Request;

constexpr unsigned longest_prefix = 32;

Request address_request(std::uint16_t type, int flags, unsigned interface_index, const InterfaceAddress& address) {
    ifaddrmsg body{};
    body.ifa_family = AF_INET;
    body.ifa_prefixlen = static_cast<std::uint8_t>(address.prefix);
    body.ifa_index = interface_index;
    Request request(type, flags | NLM_F_ACK, body);
    request.address(IFA_LOCAL, address.address).address(IFA_ADDRESS, address.address);
    return request;
}

Request route_request(std::uint16_t type, int flags, unsigned interface_index, std::uint32_t gateway) {
    rtmsg body{};
    body.rtm_family = AF_INET;
    body.rtm_table = RT_TABLE_MAIN;
    body.rtm_protocol = address_owner;
    body.rtm_scope = RT_SCOPE_UNIVERSE;
    body.rtm_type = RTN_UNICAST;
    Request request(type, flags | NLM_F_ACK, body);
    request.address(RTA_GATEWAY, gateway).attribute(RTA_OIF, interface_index).attribute(RTA_PRIORITY, route_metric);
    return request;
}

// One of ours, on this interface.
std::optional<InterfaceAddress> own_address(const Answer& answer, unsigned interface_index) {
    const auto body = answer.as<ifaddrmsg>();
    if (answer.header.nlmsg_type != RTM_NEWADDR || !body || body->ifa_index != interface_index) return std::nullopt;
    if (answer.attribute<std::uint8_t, ifaddrmsg>(IFA_PROTO) != address_owner) return std::nullopt;
    const auto address = answer.attribute<std::uint32_t, ifaddrmsg>(IFA_LOCAL);
    if (!address) return std::nullopt;
    return InterfaceAddress{ntohl(*address), body->ifa_prefixlen, 0};
}

// The gateway of one of ours, through this interface.
std::optional<std::uint32_t> own_route(const Answer& answer, unsigned interface_index) {
    const auto body = answer.as<rtmsg>();
    if (answer.header.nlmsg_type != RTM_NEWROUTE || !body) return std::nullopt;
    if (body->rtm_protocol != address_owner || body->rtm_dst_len != 0) return std::nullopt;
    const auto gateway = answer.attribute<std::uint32_t, rtmsg>(RTA_GATEWAY);
    if (answer.attribute<std::uint32_t, rtmsg>(RTA_OIF) != interface_index || !gateway) return std::nullopt;
    return ntohl(*gateway);
}

template <class Body>
Request dump(std::uint16_t type, Body body) {
    return {type, NLM_F_DUMP, body};
}

}  // namespace

// Nobody has this address, and whoever may not remove any is told that instead.
bool InterfaceAddresses::allowed() const {
    const auto word = netlink::ask(
        address_request(RTM_DELADDR, 0, interface_index_, {.address = 0, .prefix = longest_prefix, .gateway = 0}));
    return word != boost::system::errc::operation_not_permitted;
}

std::vector<InterfaceAddress> InterfaceAddresses::remove_leftovers() {
    std::vector<std::uint32_t> gateways;
    rtmsg routes{};
    routes.rtm_family = AF_INET;
    static_cast<void>(netlink::ask(dump(RTM_GETROUTE, routes), [&](const Answer& answer) {
        if (const auto gateway = own_route(answer, interface_index_)) gateways.push_back(*gateway);
    }));
    for (const auto gateway : gateways) static_cast<void>(remove_route(gateway));
    std::vector<InterfaceAddress> found;
    ifaddrmsg addresses{};
    addresses.ifa_family = AF_INET;
    static_cast<void>(netlink::ask(dump(RTM_GETADDR, addresses), [&](const Answer& answer) {
        if (const auto address = own_address(answer, interface_index_)) found.push_back(*address);
    }));
    std::erase_if(found, [&](const auto& address) { return remove(address).failed(); });
    return found;
}

// Another subnet of the same address is added before the one that was goes, so that sockets keep their address.
error_code InterfaceAddresses::set(const std::optional<InterfaceAddress>& address) {
    if (gateway_ != 0) static_cast<void>(remove_route(gateway_));
    gateway_ = 0;
    const auto before = address_;
    const bool same = before && address && before->address == address->address && before->prefix == address->prefix;
    if (before && !same && (!address || before->address != address->address)) {
        static_cast<void>(remove(*before));
        address_.reset();
    }
    if (!address) return {};
    if (!same) {
        const auto error = add(*address);
        if (error && error != boost::system::errc::file_exists) return error;
        if (address_) static_cast<void>(remove(*address_));
        address_.reset();
        if (!error) address_ = address;
    }
    if (address->gateway == 0) return {};
    const auto error = add_route(address->gateway);
    if (!error) gateway_ = address->gateway;
    return {};
}

error_code InterfaceAddresses::add(const InterfaceAddress& address) {
    auto request = address_request(RTM_NEWADDR, NLM_F_CREATE | NLM_F_EXCL, interface_index_, address);
    const auto host_bits = address.prefix >= longest_prefix ? 0 : 0xFFFFFFFFU >> address.prefix;
    request.address(IFA_BROADCAST, address.address | host_bits).attribute(IFA_PROTO, address_owner);
    return netlink::ask(std::move(request));
}

error_code InterfaceAddresses::remove(const InterfaceAddress& address) {
    return netlink::ask(address_request(RTM_DELADDR, 0, interface_index_, address));
}

error_code InterfaceAddresses::add_route(std::uint32_t gateway) {
    return netlink::ask(route_request(RTM_NEWROUTE, NLM_F_CREATE | NLM_F_EXCL, interface_index_, gateway));
}

error_code InterfaceAddresses::remove_route(std::uint32_t gateway) {
    return netlink::ask(route_request(RTM_DELROUTE, 0, interface_index_, gateway));
}

}  // namespace servobus::enip::asio
