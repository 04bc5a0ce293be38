#include "enip/asio/interfaces.hpp"

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace servobus::enip::asio {
namespace {

std::optional<std::uint32_t> ipv4(const sockaddr* address) {
    if (address == nullptr || address->sa_family != AF_INET) return std::nullopt;
    sockaddr_in copy{};
    std::memcpy(&copy, address, sizeof copy);
    return ntohl(copy.sin_addr.s_addr);
}

}  // namespace

std::vector<Interface> interfaces() {
    std::vector<Interface> found;
    ifaddrs* list = nullptr;
    if (::getifaddrs(&list) != 0) return found;
    const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owner(list, ::freeifaddrs);
    for (const auto* entry = list; entry != nullptr; entry = entry->ifa_next) {
        const auto address = ipv4(entry->ifa_addr);
        const auto mask = ipv4(entry->ifa_netmask);
        if (!address || !mask) continue;
        const auto flags = entry->ifa_flags;
        found.push_back({.name = entry->ifa_name,
                         .index = ::if_nametoindex(entry->ifa_name),
                         .address = *address,
                         .mask = *mask,
                         .loopback = (flags & IFF_LOOPBACK) != 0,
                         .broadcasts = (flags & IFF_UP) != 0 && (flags & (IFF_BROADCAST | IFF_LOOPBACK)) != 0});
    }
    return found;
}

std::optional<Interface> interface_of(std::uint32_t address) {
    if (address == 0) return std::nullopt;
    const auto all = interfaces();
    const auto found = std::ranges::find_if(all, [&](const Interface& each) {
        return each.loopback ? (each.address & each.mask) == (address & each.mask) : each.address == address;
    });
    return found != all.end() ? std::optional(*found) : std::nullopt;
}

}  // namespace servobus::enip::asio
