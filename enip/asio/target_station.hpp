// One target at one address: its sockets, its TCP connections, its timer. A TargetServer has one or many.
#pragma once

#include <algorithm>
#include <array>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/system/result.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "enip/asio/datagram_socket.hpp"
#include "enip/asio/day_clock.hpp"
#include "enip/asio/interfaces.hpp"
#include "enip/asio/io_rhythm.hpp"
#include "enip/asio/io_socket.hpp"
#include "enip/asio/target_server.hpp"
#include "enip/encapsulation.hpp"
#include "enip/target.hpp"

namespace servobus::enip::asio {

class TargetStation {
public:
    /// What a station and the others on its thread share.
    struct Shared {
        boost::asio::io_context& context;
        std::function<void(const std::string&)> problem;
        /// The station's io_queue() has something to send.
        std::function<void(TargetStation&)> io_is_due;
        /// Something has happened to the station's target, and what it had to say has left.
        std::function<void()> after_event;
        /// on_time() is to be called at this time, which is earlier than it was.
        std::function<void(Time)> wants_time;
        IoRhythm rhythm{};
        std::shared_ptr<IoSocket::Room> io_room = IoSocket::make_room();
        std::array<std::uint8_t, header_bytes + max_data_bytes> datagram{};  ///< the message that is being looked at
    };

    /// Both outlive the station.
    TargetStation(Target& target, Shared& shared);

    /// Before start() or after it. One that listens already leaves first.
    [[nodiscard]] boost::system::result<Listening, ListenError> listen(const ListenOptions& options);
    /// Serves from now on, once the context runs.
    void start();
    /// Listens nowhere any more, and its connections end; the target's time goes on.
    void leave();
    /// Closes everything; its coroutines end.
    void shut_down();
    /// To be called when serving starts, and at or after deadline(): the target has its time.
    void on_time();
    [[nodiscard]] std::optional<Time> deadline() const { return deadline_; }
    /// Something has happened to the target outside of the station, at the time of now: what it has to say leaves.
    void after_line();

    [[nodiscard]] Target& target() { return target_; }
    [[nodiscard]] IoSocket& io_socket() { return io_; }
    [[nodiscard]] std::uint16_t io_port() const { return io_.local().port; }

private:
    [[nodiscard]] std::optional<ListenError> open_messages(const ListenOptions& options, std::uint32_t address);
    [[nodiscard]] std::optional<ListenError> open_io(const ListenOptions& options);
    void open_broadcast(DatagramSocket& socket, std::uint32_t address);
    void report(const std::string& line) const {
        if (shared_.problem) shared_.problem(line);
    }

    /// What serves one place ends when the station leaves it.
    [[nodiscard]] bool is_at(unsigned place) const { return !stopped_ && place == place_; }
    void serve_place();
    void close_sockets();
    boost::asio::awaitable<void> accept(unsigned place);
    boost::asio::awaitable<void> serve(boost::asio::ip::tcp::socket socket);
    boost::asio::awaitable<void> exchange(boost::asio::ip::tcp::socket& socket, Target::ConnectionId id);
    boost::asio::awaitable<void> farewell(boost::asio::ip::tcp::socket& socket, Target::ConnectionId id);
    boost::asio::awaitable<void> datagrams(DatagramSocket& socket, unsigned place);
    boost::asio::awaitable<void> io(unsigned place);

    /// The same after everything that the station itself brings to the target; the deadline is looked at again.
    void after_event();
    /// Calls on_timer() if it is time. `next`: the target's deadline.
    [[nodiscard]] bool catch_up();
    [[nodiscard]] bool catch_up(std::optional<Time> next);
    /// The time for the target, which never goes back. The target hears how far the clock of the day is ahead of it.
    [[nodiscard]] Time now();
    void mark_messages();
    void receive_io();
    void follow_rhythm();
    void flush();
    void close_expired();
    void cut(Target::ConnectionId id);
    void wake(Target::ConnectionId id);

    Target& target_;
    Shared& shared_;
    const std::function<void(const IoSocket::Received&)> take_io_ = [this](const IoSocket::Received& received) {
        latest_ = std::max(latest_, received.time);
        target_.on_io(received.peer, received.local, received.octets, latest_);
    };
    boost::asio::ip::tcp::acceptor acceptor_;
    DatagramSocket unicast_;
    DatagramSocket directed_;  ///< the subnet's broadcast, which a socket bound to one address does not hear
    DatagramSocket limited_;   ///< 255.255.255.255
    IoSocket io_;
    Endpoint local_;
    std::optional<Interface> interface_;
    /// One that reads may be woken; one that writes looks for more when it is done.
    struct Peer {
        boost::asio::ip::tcp::socket* socket = nullptr;
        bool reads = false;
    };
    std::map<Target::ConnectionId, Peer> peers_;
    std::optional<Time> deadline_;      ///< of the target, or earlier
    Time io_seen_{};                    ///< when datagrams were last looked for
    std::optional<std::uint8_t> dscp_;  ///< that messages leave with
    Time latest_{};                     ///< that the target has been told
    DayClock day_;
    unsigned place_ = 0;  ///< counts the places that it has been at
    bool started_ = false;
    bool stopped_ = false;
};

}  // namespace servobus::enip::asio
