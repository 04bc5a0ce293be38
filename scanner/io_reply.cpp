#include "scanner/io_reply.hpp"

#include <algorithm>

#include "enip/encapsulation.hpp"

namespace servobus::scanner {
namespace {

using std::chrono::microseconds;

error_code error_of(cip::DecodeError error) {
    return make_error_code(error == cip::DecodeError::truncated ? Error::missing_data : Error::unexpected_data);
}

boost::system::result<std::optional<enip::SocketAddress>> socket_address(std::span<const enip::Item> items,
                                                                         enip::ItemType type) {
    const auto is_wanted = [&](const enip::Item& item) { return item.type == type; };
    const auto found = std::ranges::find_if(items, is_wanted);
    if (found == items.end()) return std::optional<enip::SocketAddress>{};
    const auto address = enip::SocketAddress::parse(found->data);
    constexpr std::uint16_t inet = 2;
    if (std::ranges::count_if(items, is_wanted) > 1 || !address || address->family != inet || address->port == 0) {
        return make_error_code(Error::bad_socket_address);
    }
    return std::optional(*address);
}

bool is_possible(std::uint32_t api, const IoDirection& direction) {
    if (direction.type == cip::ConnectionType::null) return true;
    const microseconds granted(api);
    return granted >= shortest_api && granted <= std::max<microseconds>(longest_api, longest_stretch * direction.rpi);
}

boost::system::result<enip::Endpoint> group_of(const std::optional<enip::SocketAddress>& address) {
    if (!address || !enip::is_multicast(address->address)) return make_error_code(Error::bad_socket_address);
    return enip::Endpoint{address->address, address->port};
}

}  // namespace

boost::system::result<IoGrant> check_open_reply(const IoPlan& plan, const cip::ForwardOpen& request, cip::ByteView data,
                                                std::span<const enip::Item> items, enip::Endpoint peer) {
    auto reply = cip::ForwardOpenReply::parse(data);
    if (!reply) return error_of(reply.error());
    if (reply->triad != request.triad) return make_error_code(Error::wrong_connection);
    if (!is_possible(reply->o_to_t_api, plan.o_to_t) || !is_possible(reply->t_to_o_api, plan.t_to_o)) {
        return make_error_code(Error::bad_interval);
    }
    const auto o_to_t = socket_address(items, enip::ItemType::sockaddr_o_to_t);
    if (!o_to_t) return o_to_t.error();
    const auto t_to_o = socket_address(items, enip::ItemType::sockaddr_t_to_o);
    if (!t_to_o) return t_to_o.error();

    // The address in the item is the target's own; behind an address translation it is not the one to be reached. And
    // nobody is sent what he has not asked for.
    IoGrant grant{std::move(*reply), {peer.address, *o_to_t ? (*o_to_t)->port : enip::io_port}, {}};
    if (plan.o_to_t.type == cip::ConnectionType::multicast) {
        const auto group = group_of(*o_to_t);
        if (!group) return group.error();
        grant.target = *group;
    }
    if (plan.t_to_o.type == cip::ConnectionType::multicast) {
        const auto group = group_of(*t_to_o);
        if (!group) return group.error();
        grant.group = *group;
    }
    return grant;
}

// Other general statuses, and routers, have other data or none behind them (R-CM-10).
error_code check_refusal(const cip::ConnectionTriad& triad, const cip::Response& response) {
    if (response.status.general != cip::GeneralStatus::connection_failure) return {};
    const auto refusal = cip::ConnectionRefusal::parse(response.data);
    if (!refusal || refusal->triad == triad) return {};
    return make_error_code(Error::wrong_connection);
}

error_code check_close_reply(const cip::ConnectionTriad& triad, cip::ByteView data) {
    const auto reply = cip::ForwardCloseReply::parse(data);
    if (!reply) return error_of(reply.error());
    return reply->triad == triad ? error_code{} : make_error_code(Error::wrong_connection);
}

}  // namespace servobus::scanner
