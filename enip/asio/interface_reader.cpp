#include "enip/asio/interface_reader.hpp"

#include <ifaddrs.h>
#include <linux/ethtool.h>
#include <linux/if_link.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <netpacket/packet.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace servobus::enip::asio {
namespace {

// The driver's word on speed and duplex; nullopt when it has none.
std::optional<ethtool_cmd> link_settings(const std::string& name) {
    const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (socket < 0) return std::nullopt;
    ethtool_cmd settings{};
    settings.cmd = ETHTOOL_GSET;
    ifreq request{};
    name.copy(request.ifr_name, IFNAMSIZ - 1);
    request.ifr_data = reinterpret_cast<char*>(&settings);  // NOLINT(*-reinterpret-cast): what the ioctl takes
    const bool told = ::ioctl(socket, SIOCETHTOOL, &request) == 0;
    ::close(socket);
    return told ? std::optional(settings) : std::nullopt;
}

InterfaceFacts facts_of(const ifaddrs& entry) {
    InterfaceFacts facts;
    sockaddr_ll address{};
    std::memcpy(&address, entry.ifa_addr, sizeof address);
    std::copy_n(std::begin(address.sll_addr), facts.mac.size(), facts.mac.begin());
    facts.ethernet = (entry.ifa_flags & IFF_LOOPBACK) == 0;
    facts.link = (entry.ifa_flags & IFF_RUNNING) != 0;
    if (entry.ifa_data == nullptr) return facts;
    rtnl_link_stats stats{};
    std::memcpy(&stats, entry.ifa_data, sizeof stats);
    facts.counters = interface_counters(stats);
    facts.media = media_counters(stats);
    return facts;
}

InterfaceFacts facts_of(const std::string& name) {
    ifaddrs* list = nullptr;
    if (::getifaddrs(&list) != 0) return {};
    const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owner(list, ::freeifaddrs);
    for (const auto* entry = list; entry != nullptr; entry = entry->ifa_next) {
        const bool is_link = entry->ifa_addr != nullptr && entry->ifa_addr->sa_family == AF_PACKET;
        if (!is_link || name != entry->ifa_name) continue;
        auto facts = facts_of(*entry);
        const auto settings = facts.ethernet ? link_settings(name) : std::nullopt;
        if (settings) tell_link(*settings, facts);
        return facts;
    }
    return {};
}

}  // namespace

InterfaceCounters interface_counters(const rtnl_link_stats& stats) {
    return {.in_octets = stats.rx_bytes,
            .in_unicast = stats.rx_packets - stats.multicast,
            .in_non_unicast = stats.multicast,
            .in_discards = stats.rx_dropped,
            .in_errors = stats.rx_errors,
            .in_unknown_protocols = stats.rx_nohandler,
            .out_octets = stats.tx_bytes,
            .out_unicast = stats.tx_packets,
            .out_discards = stats.tx_dropped,
            .out_errors = stats.tx_errors};
}

MediaCounters media_counters(const rtnl_link_stats& stats) {
    return {.alignment_errors = stats.rx_frame_errors,
            .fcs_errors = stats.rx_crc_errors,
            .single_collisions = stats.collisions,
            .sqe_test_errors = stats.tx_heartbeat_errors,
            .late_collisions = stats.tx_window_errors,
            .excessive_collisions = stats.tx_aborted_errors,
            .mac_transmit_errors = stats.tx_fifo_errors,
            .carrier_sense_errors = stats.tx_carrier_errors,
            .frames_too_long = stats.rx_length_errors,
            .mac_receive_errors = stats.rx_fifo_errors};
}

void tell_link(const ethtool_cmd& settings, InterfaceFacts& facts) {
    if (!facts.link) return;
    const auto speed = ethtool_cmd_speed(&settings);
    if (speed != static_cast<std::uint32_t>(SPEED_UNKNOWN)) facts.speed = speed;
    facts.full_duplex = settings.duplex == DUPLEX_FULL;
    facts.negotiation = settings.autoneg == AUTONEG_ENABLE ? Negotiation::done : Negotiation::not_attempted;
}

const InterfaceFacts& InterfaceReader::read() {
    const auto now = std::chrono::steady_clock::now();
    if (!read_at_ || now - *read_at_ >= interface_look_interval) {
        facts_ = facts_of(name_);
        read_at_ = now;
    }
    return facts_;
}

}  // namespace servobus::enip::asio
