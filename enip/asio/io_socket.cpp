#include "enip/asio/io_socket.hpp"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <utility>
#include <vector>

#include "enip/asio/interfaces.hpp"

namespace servobus::enip::asio {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;
using std::chrono::nanoseconds;

/// A datagram that seems to have waited longer has not: somebody has set the clock of the day.
constexpr std::chrono::seconds longest_wait{1};

/// For all control messages that a datagram may have, aligned as they must be.
struct alignas(cmsghdr) Control {
    std::array<char, 2 * CMSG_SPACE(sizeof(int)) + CMSG_SPACE(sizeof(in_pktinfo)) + CMSG_SPACE(sizeof(timespec))>
        octets;  // NOLINT(cppcoreguidelines-pro-type-member-init): written before it is read
};

error_code last_error() { return {errno, boost::system::system_category()}; }

template <class T>
error_code set_option(int socket, int level, int name, const T& value) {
    if (::setsockopt(socket, level, name, &value, sizeof value) == 0) return {};
    return last_error();
}

sockaddr_in to_native(Endpoint endpoint) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(endpoint.port);
    address.sin_addr.s_addr = htonl(endpoint.address);
    return address;
}

/// Both clocks at one moment.
struct Clocks {
    Time steady = std::chrono::steady_clock::now();
    std::chrono::system_clock::time_point day = std::chrono::system_clock::now();

    [[nodiscard]] Time to_steady(const timespec& stamp) const {
        const auto taken = nanoseconds(std::chrono::seconds(stamp.tv_sec)) + nanoseconds(stamp.tv_nsec);
        const auto waited = std::chrono::duration_cast<nanoseconds>(day.time_since_epoch()) - taken;
        return steady - std::clamp<nanoseconds>(waited, nanoseconds(0), longest_wait);
    }
};

template <class T>
T content(cmsghdr* header) {
    T value{};
    std::memcpy(&value, CMSG_DATA(header), sizeof value);
    return value;
}

/// Appends control messages to a datagram.
class ControlWriter {
public:
    explicit ControlWriter(msghdr& message) : message_(message) {}

    template <class T>
    void add(int type, const T& value) {
        // Not CMSG_NXTHDR, which believes the lengths that an earlier datagram has left behind.
        auto* place = static_cast<char*>(message_.msg_control) + used_;
        cmsghdr header{};
        header.cmsg_level = IPPROTO_IP;
        header.cmsg_type = type;
        header.cmsg_len = CMSG_LEN(sizeof value);
        std::memcpy(place, &header, sizeof header);
        std::memcpy(place + CMSG_LEN(0), &value, sizeof value);
        used_ += CMSG_SPACE(sizeof value);
        message_.msg_controllen = used_;
    }

private:
    msghdr& message_;
    std::size_t used_ = 0;
};

}  // namespace

struct IoSocket::Room {
    Room() : octets(new std::uint8_t[io_batch * max_io_datagram]) {  // its pages come into being when needed
        for (std::size_t i = 0; i < io_batch; ++i) {
            parts[i] = {octets.get() + i * max_io_datagram, max_io_datagram};
            auto& message = messages[i].msg_hdr;
            message.msg_name = &peers[i];
            message.msg_iov = &parts[i];
            message.msg_iovlen = 1;
            message.msg_control = controls[i].octets.data();
        }
        prepare(io_batch);
    }

    /// The first of them are ready for the system once more: it has changed their lengths and nothing else.
    void prepare(std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            auto& message = messages[i].msg_hdr;
            message.msg_namelen = sizeof peers[i];
            message.msg_controllen = controls[i].octets.size();
            message.msg_flags = 0;
        }
    }

    std::unique_ptr<std::uint8_t[]> octets;  // NOLINT(cppcoreguidelines-avoid-c-arrays)
    std::array<mmsghdr, io_batch> messages{};
    std::array<iovec, io_batch> parts{};
    std::array<sockaddr_in, io_batch> peers{};
    std::array<Control, io_batch> controls{};
};

struct IoSocket::Outgoing {
    std::array<mmsghdr, io_batch> messages{};
    std::array<iovec, io_batch> parts{};
    std::array<sockaddr_in, io_batch> peers{};
    std::array<Control, io_batch> controls{};
};

std::shared_ptr<IoSocket::Room> IoSocket::make_room() { return std::make_shared<Room>(); }

IoSocket::IoSocket(const boost::asio::any_io_executor& executor, std::shared_ptr<Room> room)
    : socket_(executor), room_(std::move(room)) {}

IoSocket::~IoSocket() { close(); }

error_code IoSocket::open(Endpoint local, bool shared) {
    error_code error;
    socket_.open(udp::v4(), error);
    if (!error && shared) socket_.set_option(udp::socket::reuse_address(true), error);
    constexpr int on = 1;
    if (!error) error = set_option(native(), IPPROTO_IP, IP_PKTINFO, on);
    if (!error) error = set_option(native(), SOL_SOCKET, SO_TIMESTAMPNS, on);
    if (!error) error = set_option(native(), IPPROTO_IP, IP_MULTICAST_ALL, 0);
    // The first of them needs privileges, the second is cut to what the system allows; neither is a reason to fail.
    if (!error && set_option(native(), SOL_SOCKET, SO_RCVBUFFORCE, io_receive_buffer)) {
        static_cast<void>(set_option(native(), SOL_SOCKET, SO_RCVBUF, io_receive_buffer));
    }
    if (!error) socket_.bind({boost::asio::ip::address_v4(local.address), local.port}, error);
    if (!error) socket_.non_blocking(true, error);
    if (error) {
        close();
        return error;
    }
    local_ = {local.address, socket_.local_endpoint(error).port()};
    return error;
}

void IoSocket::tell_ttl() {
    constexpr int on = 1;
    static_cast<void>(set_option(native(), IPPROTO_IP, IP_RECVTTL, on));
}

void IoSocket::close() {
    error_code ignored;
    if (is_quiet()) ::close(std::exchange(quiet_, -1));
    socket_.close(ignored);
}

// The one way to keep the reactor from waking is not to be known to it.
void IoSocket::set_quiet(bool quiet) {
    if (quiet == is_quiet() || !is_open()) return;
    error_code error;
    if (quiet) {
        const auto native = socket_.release(error);
        if (!error) quiet_ = native;
        return;
    }
    socket_.assign(udp::v4(), quiet_, error);
    if (!error) quiet_ = -1;
}

error_code IoSocket::join(std::uint32_t group, std::uint32_t interface_address) {
    return membership(IP_ADD_MEMBERSHIP, group, interface_address);
}

error_code IoSocket::leave(std::uint32_t group, std::uint32_t interface_address) {
    return membership(IP_DROP_MEMBERSHIP, group, interface_address);
}

error_code IoSocket::membership(int option, std::uint32_t group, std::uint32_t address) {
    ip_mreqn request{};
    request.imr_multiaddr.s_addr = htonl(group);
    request.imr_address.s_addr = htonl(address);
    request.imr_ifindex = static_cast<int>(interface_index(address));
    return set_option(native(), IPPROTO_IP, option, request);
}

unsigned IoSocket::interface_index(std::uint32_t address) {
    auto& known = interfaces_;
    const auto found = std::ranges::find(known, address, &std::pair<std::uint32_t, unsigned>::first);
    if (found != known.end()) return found->second;
    const auto interface = interface_of(address);
    const auto index = interface ? interface->index : 0;
    known.emplace_back(address, index);
    return index;
}

std::size_t IoSocket::receive(const std::function<void(const Received&)>& take) {
    auto& in = *room_;
    const auto count = ::recvmmsg(native(), in.messages.data(), io_batch, MSG_DONTWAIT, nullptr);
    if (count <= 0) return 0;
    const Clocks clocks;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count) && is_open(); ++i) {
        auto& message = in.messages[i].msg_hdr;
        Received received{.peer = {ntohl(in.peers[i].sin_addr.s_addr), ntohs(in.peers[i].sin_port)},
                          .local = local_,
                          .octets = {static_cast<const std::uint8_t*>(in.parts[i].iov_base), in.messages[i].msg_len},
                          .time = clocks.steady};
        for (auto* header = CMSG_FIRSTHDR(&message); header != nullptr; header = CMSG_NXTHDR(&message, header)) {
            if (header->cmsg_level == IPPROTO_IP && header->cmsg_type == IP_PKTINFO) {
                received.local.address = ntohl(content<in_pktinfo>(header).ipi_addr.s_addr);
            }
            if (header->cmsg_level == IPPROTO_IP && header->cmsg_type == IP_TTL) {
                received.ttl = static_cast<std::uint8_t>(content<int>(header));
            }
            if (header->cmsg_level == SOL_SOCKET && header->cmsg_type == SCM_TIMESTAMPNS) {
                received.time = clocks.to_steady(content<timespec>(header));
            }
        }
        take(received);
    }
    in.prepare(static_cast<std::size_t>(count));
    return static_cast<std::size_t>(count);
}

IoSocket::Sent IoSocket::send(const IoQueue& queue) {
    if (!outgoing_) outgoing_ = std::make_unique<Outgoing>();  // many sockets never send, as others send for them
    auto& out = *outgoing_;
    Sent result;
    auto entries = queue.entries();
    while (!entries.empty()) {
        const auto count = std::min(entries.size(), io_batch);
        for (std::size_t i = 0; i < count; ++i) {
            const auto& route = entries[i].route;
            const auto octets = queue.octets(entries[i]);
            out.peers[i] = to_native(route.peer);
            // The system only reads what it sends.
            out.parts[i] = {const_cast<std::uint8_t*>(octets.data()), octets.size()};  // NOLINT(*-const-cast)
            auto& message = out.messages[i].msg_hdr;
            message = {};
            message.msg_name = &out.peers[i];
            message.msg_namelen = sizeof out.peers[i];
            message.msg_iov = &out.parts[i];
            message.msg_iovlen = 1;
            message.msg_control = out.controls[i].octets.data();
            ControlWriter control(message);
            in_pktinfo info{};
            info.ipi_spec_dst.s_addr = htonl(route.local.address);
            if (is_multicast(route.peer.address)) {
                info.ipi_ifindex = static_cast<int>(interface_index(route.local.address));
            }
            control.add(IP_PKTINFO, info);
            control.add(IP_TOS, int{route.dscp} << 2);
            if (route.ttl != 0) control.add(IP_TTL, int{route.ttl});
        }
        const auto sent =
            ::sendmmsg(native(), out.messages.data(), static_cast<unsigned>(count), MSG_DONTWAIT | MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR) continue;
        if (sent < 0) {  // the first of them; the others have their own chance
            ++result.failed;
            entries = entries.subspan(1);
            continue;
        }
        result.sent += static_cast<std::size_t>(sent);
        entries = entries.subspan(static_cast<std::size_t>(sent));
    }
    return result;
}

}  // namespace servobus::enip::asio
