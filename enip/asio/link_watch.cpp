#include "enip/asio/link_watch.hpp"

#include <net/if.h>
#include <net/if_arp.h>
#include <sys/socket.h>

#include <cerrno>
#include <vector>

#include "enip/asio/netlink.hpp"

namespace servobus::enip::asio {
namespace {

using boost::system::error_code;
using netlink::Answer;

// Messages in one go before other work has its turn.
constexpr int reads_at_once = 64;

// What a message says of the interface's link; nullopt when it is about something else.
std::optional<bool> link_in(const Answer& answer, unsigned interface_index) {
    const auto type = answer.header.nlmsg_type;
    const auto body = answer.as<ifinfomsg>();
    if ((type != RTM_NEWLINK && type != RTM_DELLINK) || !body || body->ifi_family != AF_UNSPEC) return std::nullopt;
    if (static_cast<unsigned>(body->ifi_index) != interface_index) return std::nullopt;
    return type == RTM_NEWLINK && (body->ifi_flags & IFF_RUNNING) != 0;
}

netlink::Request question(unsigned interface_index) {
    ifinfomsg body{};
    body.ifi_index = static_cast<int>(interface_index);
    return {RTM_GETLINK, NLM_F_ACK, body};
}

}  // namespace

error_code LinkWatch::open(unsigned interface_index) {
    interface_index_ = interface_index;
    const int socket = netlink::open(RTMGRP_LINK);
    if (socket < 0) return {errno, boost::system::system_category()};
    error_code error;
    descriptor_.assign(socket, error);
    return error;
}

void LinkWatch::close() {
    error_code ignored;
    descriptor_.close(ignored);
}

bool LinkWatch::has_link() const {
    bool up = false;
    static_cast<void>(netlink::ask(question(interface_index_),
                                   [&](const Answer& answer) { up = link_in(answer, interface_index_).value_or(up); }));
    return up;
}

std::optional<std::array<std::uint8_t, 6>> LinkWatch::mac() const {
    using Mac = std::array<std::uint8_t, 6>;
    std::optional<Mac> mac;
    static_cast<void>(netlink::ask(question(interface_index_), [&](const Answer& answer) {
        const auto body = answer.as<ifinfomsg>();
        if (answer.header.nlmsg_type != RTM_NEWLINK || !body || body->ifi_type != ARPHRD_ETHER) return;
        mac = answer.attribute<Mac, ifinfomsg>(IFLA_ADDRESS);
    }));
    return mac;
}

std::optional<bool> LinkWatch::news() {
    std::vector<std::byte> buffer(netlink::answer_octets);
    std::optional<bool> latest;
    for (int i = 0; i < reads_at_once; ++i) {
        const auto size = ::recv(descriptor_.native_handle(), buffer.data(), buffer.size(), MSG_DONTWAIT);
        if (size < 0 && errno == ENOBUFS) return has_link();  // some were lost
        if (size < 0) break;
        netlink::split(std::span(buffer).first(static_cast<std::size_t>(size)), [&](const Answer& answer) {
            if (const auto link = link_in(answer, interface_index_)) latest = link;
        });
    }
    return latest;
}

}  // namespace servobus::enip::asio
