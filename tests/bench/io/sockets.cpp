#include "tests/bench/io/sockets.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

#include "tests/bench/io/image.hpp"

namespace servobus::bench {
namespace {

// Enough for 100 ms of 40,000 datagrams a second; the kernel gives less when it does not like it.
constexpr int buffer_octets = 8 * 1024 * 1024;

void allow(int socket, int level, int option, int value = 1) {
    ::setsockopt(socket, level, option, &value, sizeof value);
}

Descriptor open_socket(int type) {
    Descriptor result(::socket(AF_INET, type | SOCK_CLOEXEC, 0));
    if (result.number() < 0) give_up_errno("socket");
    return result;
}

void bind_to(const Descriptor& socket, enip::Endpoint local) {
    const auto address = to_sockaddr(local);
    if (::bind(socket.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        give_up_errno("bind to " + to_string(local));
    }
}

Nanoseconds time_of(msghdr& message) {
    for (auto* part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
        if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_TIMESTAMPNS) continue;
        timespec time{};
        std::memcpy(&time, CMSG_DATA(part), sizeof time);
        return nanoseconds(time);
    }
    give_up("the kernel puts no time on datagrams");
}

}  // namespace

void give_up(const std::string& why) {
    fmt::print(stderr, "servobus_io_bench: {}\n", why);
    std::exit(3);
}

void give_up_errno(const std::string& what) {
    give_up(what + ": " + std::strerror(errno));  // NOLINT(concurrency-mt-unsafe)
}

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
    if (this != &other) {
        close();
        number_ = other.release();
    }
    return *this;
}

int Descriptor::release() { return std::exchange(number_, -1); }

void Descriptor::close() {
    if (number_ >= 0) ::close(release());
}

sockaddr_in to_sockaddr(enip::Endpoint endpoint) {
    sockaddr_in result{};
    result.sin_family = AF_INET;
    result.sin_port = htons(endpoint.port);
    result.sin_addr.s_addr = htonl(endpoint.address);
    return result;
}

std::uint32_t parse_address(const std::string& text) {
    in_addr address{};
    if (::inet_pton(AF_INET, text.c_str(), &address) != 1) give_up("not an IPv4 address: " + text);
    return ntohl(address.s_addr);
}

enip::Endpoint parse_endpoint(const std::string& text) {
    const auto colon = text.find(':');
    if (colon == std::string::npos) return {parse_address(text), 0};
    return {parse_address(text.substr(0, colon)), static_cast<std::uint16_t>(std::stoul(text.substr(colon + 1)))};
}

Descriptor udp_socket(enip::Endpoint local) {
    auto result = open_socket(SOCK_DGRAM);
    allow(result.number(), SOL_SOCKET, SO_RCVBUF, buffer_octets);
    allow(result.number(), SOL_SOCKET, SO_RCVBUFFORCE, buffer_octets);
    bind_to(result, local);
    return result;
}

Descriptor tcp_listener(enip::Endpoint local) {
    auto result = open_socket(SOCK_STREAM);
    allow(result.number(), SOL_SOCKET, SO_REUSEADDR);
    bind_to(result, local);
    if (::listen(result.number(), 16) != 0) give_up_errno("listen");
    return result;
}

Descriptor tcp_accept(const Descriptor& listener) {
    Descriptor result(::accept4(listener.number(), nullptr, nullptr, SOCK_CLOEXEC));
    if (result.number() >= 0) allow(result.number(), IPPROTO_TCP, TCP_NODELAY);
    return result;
}

Descriptor tcp_connect(enip::Endpoint peer, std::uint32_t local_address) {
    auto result = open_socket(SOCK_STREAM);
    if (local_address != 0) bind_to(result, {local_address, 0});
    const auto address = to_sockaddr(peer);
    if (::connect(result.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return {};
    allow(result.number(), IPPROTO_TCP, TCP_NODELAY);
    return result;
}

enip::Endpoint local_endpoint(const Descriptor& socket) {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    ::getsockname(socket.number(), reinterpret_cast<sockaddr*>(&address), &size);
    return {ntohl(address.sin_addr.s_addr), ntohs(address.sin_port)};
}

void send_all(const Descriptor& socket, std::span<const std::uint8_t> octets) {
    while (!octets.empty()) {
        const auto sent = ::send(socket.number(), octets.data(), octets.size(), MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) give_up_errno("send");
        octets = octets.subspan(static_cast<std::size_t>(sent));
    }
}

bool receive_all(const Descriptor& socket, std::span<std::uint8_t> octets) {
    while (!octets.empty()) {
        const auto got = ::recv(socket.number(), octets.data(), octets.size(), 0);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        octets = octets.subspan(static_cast<std::size_t>(got));
    }
    return true;
}

std::size_t dropped(enip::Endpoint local) {
    // "  sl  local_address ... drops": the address is hexadecimal, in the machine's order; the drops are the last word.
    const auto wanted = fmt::format("{:08X}:{:04X}", htonl(local.address), local.port);
    std::ifstream table("/proc/net/udp");
    std::size_t result = 0;
    for (std::string line; std::getline(table, line);) {
        std::istringstream words(line);
        const std::vector<std::string> all{std::istream_iterator<std::string>(words), {}};
        if (all.size() > 2 && all[1] == wanted) result += std::stoul(all.back());
    }
    return result;
}

Receiver::Receiver(enip::Endpoint local) : socket_(udp_socket(local)) {
    allow(socket_.number(), SOL_SOCKET, SO_TIMESTAMPNS);
}

void Receiver::drain(std::vector<Arrival>& arrivals) {
    constexpr std::size_t batch = 64;
    struct Room {
        std::array<std::uint8_t, 512> octets;
        alignas(cmsghdr) std::array<char, 64> control;
    };
    static thread_local std::array<Room, batch> rooms;
    while (true) {
        std::array<iovec, batch> places;
        std::array<mmsghdr, batch> messages{};
        for (std::size_t i = 0; i < batch; ++i) {
            places[i] = {rooms[i].octets.data(), rooms[i].octets.size()};
            messages[i].msg_hdr.msg_iov = &places[i];
            messages[i].msg_hdr.msg_iovlen = 1;
            messages[i].msg_hdr.msg_control = rooms[i].control.data();
            messages[i].msg_hdr.msg_controllen = rooms[i].control.size();
        }
        const int got = ::recvmmsg(socket_.number(), messages.data(), batch, MSG_DONTWAIT, nullptr);
        for (int i = 0; i < got; ++i) {
            auto& message = messages[static_cast<std::size_t>(i)];
            const std::span octets(rooms[static_cast<std::size_t>(i)].octets);
            arrivals.push_back(read_arrival(octets.first(message.msg_len), time_of(message.msg_hdr)));
        }
        if (got < static_cast<int>(batch)) return;
    }
}

}  // namespace servobus::bench
