// UDP for class 0 and 1: many datagrams in one system call, each with the time at which the kernel took it and, on the
// way out, its own source address, priority and reach.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/system/error_code.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "cip/bytes.hpp"
#include "enip/endpoint.hpp"
#include "enip/io_queue.hpp"
#include "enip/time.hpp"

namespace servobus::enip::asio {

/// Datagrams that one call of the system takes or gives.
inline constexpr std::size_t io_batch = 32;
/// The longest datagram that is received whole; a longer one comes cut, and so as a malformed one.
inline constexpr std::size_t max_io_datagram = 8192;
/// What the system is asked to keep of what has come and has not been received; it may grant less.
inline constexpr int io_receive_buffer = 4 * 1024 * 1024;

/// Never blocks, and allocates nothing once it has sent and received. The owner waits with socket().async_wait.
class IoSocket {
public:
    /// Where datagrams are received to. Sockets of one thread may share it.
    struct Room;
    [[nodiscard]] static std::shared_ptr<Room> make_room();

    explicit IoSocket(const boost::asio::any_io_executor& executor, std::shared_ptr<Room> room = make_room());
    IoSocket(const IoSocket&) = delete;
    IoSocket& operator=(const IoSocket&) = delete;
    ~IoSocket();

    /// `local` is one address of this machine, 0.0.0.0, or a multicast group; port 0 when the system may choose.
    /// `shared`: others may listen there too, as a group needs it. After an error it is closed and may be opened again.
    [[nodiscard]] boost::system::error_code open(Endpoint local, bool shared);
    void close();
    /// Received::ttl is told from now on, which costs something for each datagram.
    void tell_ttl();
    /// To wait with; not while it is quiet.
    [[nodiscard]] boost::asio::ip::udp::socket& socket() { return socket_; }
    /// While it is quiet what comes wakes nobody, and waits to be received. Whoever waits is told operation_aborted.
    void set_quiet(bool quiet);
    [[nodiscard]] bool is_quiet() const { return quiet_ >= 0; }
    [[nodiscard]] bool is_open() const { return is_quiet() || socket_.is_open(); }
    /// Where it listens, the port that the system has chosen included.
    [[nodiscard]] Endpoint local() const { return local_; }

    /// Only the groups joined here are heard, on the interface that the address belongs to (R-MC-3).
    [[nodiscard]] boost::system::error_code join(std::uint32_t group, std::uint32_t interface_address);
    [[nodiscard]] boost::system::error_code leave(std::uint32_t group, std::uint32_t interface_address);

    struct Received {
        Endpoint peer;
        Endpoint local;  ///< where it was sent to: our own address, or a group
        cip::ByteView octets;
        Time time;             ///< when the kernel took it; never later than now
        std::uint8_t ttl = 0;  ///< of the IP header; 0 when it is not told
    };
    /// Takes what waits, at most io_batch datagrams, and says how many: when that many, more may wait. `take` may close
    /// the socket, but not destroy it.
    std::size_t receive(const std::function<void(const Received&)>& take);

    struct Sent {
        std::size_t sent = 0;
        std::size_t failed = 0;  ///< lost, as datagrams are
    };
    /// Sends all at once, in their order. The queue is the caller's to clear.
    Sent send(const IoQueue& queue);

private:
    struct Outgoing;

    [[nodiscard]] boost::system::error_code membership(int option, std::uint32_t group, std::uint32_t address);
    [[nodiscard]] unsigned interface_index(std::uint32_t address);

    [[nodiscard]] int native() { return is_quiet() ? quiet_ : socket_.native_handle(); }

    boost::asio::ip::udp::socket socket_;
    int quiet_ = -1;  ///< the socket, while it is quiet
    Endpoint local_;
    std::shared_ptr<Room> room_;
    std::unique_ptr<Outgoing> outgoing_;
    std::vector<std::pair<std::uint32_t, unsigned>> interfaces_;  ///< that groups have been sent through
};

}  // namespace servobus::enip::asio
