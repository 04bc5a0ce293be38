#include "enip/asio/packet_socket.hpp"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace servobus::enip::asio {
namespace {

using boost::system::error_code;

constexpr std::size_t macs = 12;  // octets in front of the VLAN tag
constexpr std::size_t tag_octets = 4;
constexpr std::uint16_t ring_ether_type = 0x80E1;  // R-DLR-7
constexpr std::uint16_t dhcp_client_port = 68;

// A classic BPF program, as an instruction a line.
using Program = std::span<const sock_filter>;

constexpr sock_filter load_half(std::uint32_t at) { return BPF_STMT(BPF_LD | BPF_H | BPF_ABS, at); }
constexpr sock_filter load_byte(std::uint32_t at) { return BPF_STMT(BPF_LD | BPF_B | BPF_ABS, at); }
constexpr sock_filter if_equal(std::uint32_t value, std::uint8_t then, std::uint8_t otherwise) {
    return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, then, otherwise);
}
constexpr sock_filter if_any(std::uint32_t bits, std::uint8_t then, std::uint8_t otherwise) {
    return BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, bits, then, otherwise);
}
constexpr sock_filter load_header_length(std::uint32_t at) { return BPF_STMT(BPF_LDX | BPF_B | BPF_MSH, at); }
constexpr sock_filter load_half_behind_header(std::uint32_t at) { return BPF_STMT(BPF_LD | BPF_H | BPF_IND, at); }
constexpr sock_filter hear_it() { return BPF_STMT(BPF_RET | BPF_K, 0x40000); }
constexpr sock_filter drop_it() { return BPF_STMT(BPF_RET | BPF_K, 0); }

// Tags are off when the program runs.
constexpr std::uint32_t ether_type_at = 12;
constexpr std::uint32_t ip_at = 14;
constexpr std::array<sock_filter, 12> addressing{
    load_half(ether_type_at),
    if_equal(ETH_P_ARP, 8, 0),    // heard
    if_equal(ETH_P_IP, 0, 8),     // or dropped
    load_byte(ip_at + 9),         // protocol
    if_equal(IPPROTO_UDP, 0, 6),  // or dropped
    load_half(ip_at + 6),         // offset of a fragment
    if_any(0x1FFF, 4, 0),         // dropped
    load_header_length(ip_at),
    load_half_behind_header(ip_at + 2),  // port of the destination
    if_equal(dhcp_client_port, 0, 1),
    hear_it(),
    drop_it(),
};
constexpr std::array<sock_filter, 4> ring{load_half(ether_type_at), if_equal(ring_ether_type, 0, 1), hear_it(),
                                          drop_it()};

Program program_of(Traffic traffic) { return traffic == Traffic::ring ? Program(ring) : Program(addressing); }

// Beacons, neighbour checks and sign-on, announcements, advertisements, learning updates (R-DLR-11).
constexpr std::uint8_t ring_groups = 5;
constexpr std::array<std::uint8_t, 5> ring_group{0x01, 0x21, 0x6C, 0x00, 0x00};

template <class Value>
bool set(int socket, int level, int option, const Value& value) {
    return ::setsockopt(socket, level, option, &value, sizeof value) == 0;
}

bool join_ring(int socket, unsigned interface_index) {
    packet_mreq membership{};
    membership.mr_ifindex = static_cast<int>(interface_index);
    membership.mr_type = PACKET_MR_MULTICAST;
    membership.mr_alen = ETH_ALEN;
    std::ranges::copy(ring_group, std::begin(membership.mr_address));
    for (std::uint8_t group = 1; group <= ring_groups; ++group) {
        membership.mr_address[ring_group.size()] = group;
        if (!set(socket, SOL_PACKET, PACKET_ADD_MEMBERSHIP, membership)) return false;
    }
    return true;
}

// The filter before the interface, so that nothing else is heard in between.
bool prepare(int socket, unsigned interface_index, Traffic traffic) {
    const auto program = program_of(traffic);
    sock_fprog filter{};
    filter.len = static_cast<unsigned short>(program.size());
    filter.filter = const_cast<sock_filter*>(program.data());  // NOLINT(*-const-cast): the kernel only reads it
    if (!set(socket, SOL_SOCKET, SO_ATTACH_FILTER, filter)) return false;
    const int on = 1;
    if (!set(socket, SOL_PACKET, PACKET_AUXDATA, on)) return false;
    static_cast<void>(set(socket, SOL_PACKET, PACKET_IGNORE_OUTGOING, on));  // since Linux 4.20; receive() looks too
    sockaddr_ll address{};
    address.sll_family = AF_PACKET;
    address.sll_protocol = htons(ETH_P_ALL);  // the ports of a bridge are heard by no other
    address.sll_ifindex = static_cast<int>(interface_index);
    // NOLINTNEXTLINE(*-reinterpret-cast): what the call takes
    if (::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return false;
    return traffic != Traffic::ring || join_ring(socket, interface_index);
}

// What the kernel tells beside a frame.
std::optional<tpacket_auxdata> auxiliary(msghdr& message) {
    for (auto* header = CMSG_FIRSTHDR(&message); header != nullptr; header = CMSG_NXTHDR(&message, header)) {
        if (header->cmsg_level != SOL_PACKET || header->cmsg_type != PACKET_AUXDATA) continue;
        tpacket_auxdata data{};
        std::memcpy(&data, CMSG_DATA(header), sizeof data);
        return data;
    }
    return std::nullopt;
}

// Room for one tpacket_auxdata, aligned as a control message must be.
struct alignas(cmsghdr) Control {
    std::array<char, CMSG_SPACE(sizeof(tpacket_auxdata))> octets{};
};

}  // namespace

error_code PacketSocket::open(unsigned interface_index, Traffic traffic) {
    const auto failed = [] { return error_code(errno, boost::system::system_category()); };
    const int socket = ::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (socket < 0) return failed();
    if (!prepare(socket, interface_index, traffic)) {
        const auto error = failed();
        ::close(socket);
        return error;
    }
    error_code error;
    descriptor_.assign(socket, error);
    return error;
}

void PacketSocket::close() {
    error_code ignored;
    descriptor_.close(ignored);
}

std::optional<HeardFrame> PacketSocket::receive(std::span<std::uint8_t, max_link_frame> buffer) {
    // Behind the place of a tag that may have to go back.
    const auto place = buffer.subspan(tag_octets);
    for (;;) {
        sockaddr_ll from{};
        Control control;
        iovec part{place.data(), place.size()};
        msghdr message{};
        message.msg_name = &from;
        message.msg_namelen = sizeof from;
        message.msg_iov = &part;
        message.msg_iovlen = 1;
        message.msg_control = control.octets.data();
        message.msg_controllen = control.octets.size();
        const auto size = ::recvmsg(descriptor_.native_handle(), &message, MSG_DONTWAIT | MSG_TRUNC);
        if (size < 0) return std::nullopt;
        const auto octets = static_cast<std::size_t>(size);
        if (from.sll_pkttype == PACKET_OUTGOING || octets > place.size() || octets < macs) continue;
        const auto data = auxiliary(message);
        const bool checksummed = !data || (data->tp_status & TP_STATUS_CSUMNOTREADY) == 0;
        const auto frame = place.first(octets);
        if (!data || (data->tp_status & TP_STATUS_VLAN_VALID) == 0) return HeardFrame{frame, checksummed};
        const auto tagged = buffer.first(octets + tag_octets);
        std::copy_n(frame.begin(), macs, tagged.begin());
        const std::uint16_t type =
            (data->tp_status & TP_STATUS_VLAN_TPID_VALID) != 0 ? data->tp_vlan_tpid : ETH_P_8021Q;
        for (const auto& [at, word] : {std::pair(macs, type), std::pair(macs + 2, data->tp_vlan_tci)}) {
            tagged[at] = static_cast<std::uint8_t>(word >> 8);
            tagged[at + 1] = static_cast<std::uint8_t>(word);
        }
        return HeardFrame{tagged, checksummed};
    }
}

void PacketSocket::send(cip::ByteView frame) {
    static_cast<void>(::send(descriptor_.native_handle(), frame.data(), frame.size(), MSG_DONTWAIT | MSG_NOSIGNAL));
}

}  // namespace servobus::enip::asio
