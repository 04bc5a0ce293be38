#include "enip/asio/datagram_socket.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstring>

namespace servobus::enip::asio {
namespace {

using boost::asio::ip::udp;

sockaddr_in to_native(Endpoint endpoint) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(endpoint.port);
    address.sin_addr.s_addr = htonl(endpoint.address);
    return address;
}

// Room for one in_pktinfo, aligned as a control message must be.
struct alignas(cmsghdr) Control {
    std::array<char, CMSG_SPACE(sizeof(in_pktinfo))> octets{};
};

}  // namespace

boost::system::error_code DatagramSocket::open(Endpoint local, bool shared) {
    boost::system::error_code error;
    socket_.open(udp::v4(), error);
    if (!error && shared) socket_.set_option(udp::socket::reuse_address(true), error);
    if (!error) {
        const int on = 1;
        if (::setsockopt(socket_.native_handle(), IPPROTO_IP, IP_PKTINFO, &on, sizeof on) != 0) {
            error.assign(errno, boost::system::system_category());
        }
    }
    if (!error) socket_.bind({boost::asio::ip::address_v4(local.address), local.port}, error);
    if (!error) socket_.non_blocking(true, error);
    return error;
}

void DatagramSocket::close() {
    boost::system::error_code ignored;
    socket_.close(ignored);
}

std::optional<DatagramSocket::Received> DatagramSocket::receive(std::span<std::uint8_t> buffer) {
    sockaddr_in peer{};
    Control control;
    iovec part{buffer.data(), buffer.size()};
    msghdr message{};
    message.msg_name = &peer;
    message.msg_namelen = sizeof peer;
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.octets.data();
    message.msg_controllen = control.octets.size();
    const auto size = ::recvmsg(socket_.native_handle(), &message, MSG_DONTWAIT);
    if (size < 0) return std::nullopt;

    Received received;
    received.peer = {ntohl(peer.sin_addr.s_addr), ntohs(peer.sin_port)};
    received.octets = buffer.first(static_cast<std::size_t>(size));
    boost::system::error_code ignored;
    received.local.port = socket_.local_endpoint(ignored).port();
    for (auto* header = CMSG_FIRSTHDR(&message); header != nullptr; header = CMSG_NXTHDR(&message, header)) {
        if (header->cmsg_level != IPPROTO_IP || header->cmsg_type != IP_PKTINFO) continue;
        in_pktinfo info{};
        std::memcpy(&info, CMSG_DATA(header), sizeof info);
        received.local.address = ntohl(info.ipi_spec_dst.s_addr);
        received.broadcast = info.ipi_addr.s_addr != info.ipi_spec_dst.s_addr;
        received.interface_index = static_cast<unsigned>(info.ipi_ifindex);
    }
    return received;
}

void DatagramSocket::send(const Datagram& datagram) {
    auto peer = to_native(datagram.peer);
    Control control;
    auto octets = datagram.octets;
    iovec part{octets.data(), octets.size()};
    msghdr message{};
    message.msg_name = &peer;
    message.msg_namelen = sizeof peer;
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.octets.data();
    message.msg_controllen = control.octets.size();
    auto* header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = IPPROTO_IP;
    header->cmsg_type = IP_PKTINFO;
    header->cmsg_len = CMSG_LEN(sizeof(in_pktinfo));
    in_pktinfo info{};
    info.ipi_spec_dst.s_addr = htonl(datagram.local.address);
    std::memcpy(CMSG_DATA(header), &info, sizeof info);
    static_cast<void>(::sendmsg(socket_.native_handle(), &message, MSG_DONTWAIT | MSG_NOSIGNAL));
}

}  // namespace servobus::enip::asio
