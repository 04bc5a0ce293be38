// Plain sockets, so that what is measured with them owes nothing to the code that is measured.
#pragma once

#include <netinet/in.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "enip/endpoint.hpp"
#include "tests/bench/io/statistics.hpp"

namespace servobus::bench {

/// Ends the benchmark: it cannot be done here. There are no other errors.
[[noreturn]] void give_up(const std::string& why);
/// With the words of errno.
[[noreturn]] void give_up_errno(const std::string& what);

class Descriptor {
public:
    Descriptor() = default;
    explicit Descriptor(int number) : number_(number) {}
    Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}
    Descriptor& operator=(Descriptor&& other) noexcept;
    ~Descriptor() { close(); }

    [[nodiscard]] int number() const { return number_; }
    int release();
    void close();

private:
    int number_ = -1;
};

[[nodiscard]] sockaddr_in to_sockaddr(enip::Endpoint endpoint);
[[nodiscard]] std::uint32_t parse_address(const std::string& text);
[[nodiscard]] enip::Endpoint parse_endpoint(const std::string& text);

/// Port 0: a free one.
[[nodiscard]] Descriptor udp_socket(enip::Endpoint local);
[[nodiscard]] Descriptor tcp_listener(enip::Endpoint local);
/// Nagle's algorithm is off.
[[nodiscard]] Descriptor tcp_accept(const Descriptor& listener);
/// Nullopt-like: a descriptor below 0 when nobody listens.
[[nodiscard]] Descriptor tcp_connect(enip::Endpoint peer, std::uint32_t local_address = 0);
[[nodiscard]] enip::Endpoint local_endpoint(const Descriptor& socket);

void send_all(const Descriptor& socket, std::span<const std::uint8_t> octets);
/// False at the end of the stream.
[[nodiscard]] bool receive_all(const Descriptor& socket, std::span<std::uint8_t> octets);

/// Datagrams that the kernel has thrown away at this socket because nobody fetched them.
[[nodiscard]] std::size_t dropped(enip::Endpoint local);

/// Receives class 0 and 1 datagrams, with the time at which the kernel took each.
class Receiver {
public:
    explicit Receiver(enip::Endpoint local);

    /// Appends what has come; does not wait.
    void drain(std::vector<Arrival>& arrivals);
    [[nodiscard]] const Descriptor& socket() const { return socket_; }

private:
    Descriptor socket_;
};

}  // namespace servobus::bench
