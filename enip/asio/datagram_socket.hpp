// UDP with both addresses of every datagram: who sent it, and which of our addresses it was sent to.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/system/error_code.hpp>
#include <cstdint>
#include <optional>
#include <span>

#include "cip/bytes.hpp"
#include "enip/target.hpp"

namespace servobus::enip::asio {

class DatagramSocket {
public:
    explicit DatagramSocket(const boost::asio::any_io_executor& executor) : socket_(executor) {}

    /// `shared`: others may listen at the same address too, as broadcasts need it.
    [[nodiscard]] boost::system::error_code open(Endpoint local, bool shared);
    [[nodiscard]] boost::asio::ip::udp::socket& socket() { return socket_; }
    void close();

    struct Received {
        Endpoint peer;
        Endpoint local;  ///< our own address on the interface that it came through
        bool broadcast = false;
        unsigned interface_index = 0;
        cip::ByteView octets;  ///< in the buffer given
    };
    /// The next datagram, or nullopt when none waits. One that is longer than the buffer comes cut.
    [[nodiscard]] std::optional<Received> receive(std::span<std::uint8_t> buffer);

    /// Sends at once or not at all: a datagram that the system cannot take is lost, as datagrams are.
    void send(const Datagram& datagram);

private:
    boost::asio::ip::udp::socket socket_;
};

}  // namespace servobus::enip::asio
