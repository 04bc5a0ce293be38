// Puts enip::Targets on the network: TCP and UDP sockets, one thread, one clock. Each target has an address of its own.
#pragma once

#include <array>
#include <boost/system/result.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enip/asio/line_service.hpp"
#include "enip/encapsulation.hpp"
#include "enip/link_user.hpp"
#include "enip/message_user.hpp"
#include "enip/target.hpp"
#include "enip/time.hpp"

namespace servobus::enip::asio {

/// Why the server does not listen: one sentence for the person who started it.
struct ListenError {
    std::string reason;
};

/// Where a target is to be found.
struct ListenOptions {
    std::string address = "127.0.0.1";  ///< IPv4, "0.0.0.0" for all of this machine
    std::uint16_t port = tcp_port;      ///< TCP and UDP; 0 takes one that is free for both
    /// UDP of class 0 and 1. Without a wish it is 2222, or one that is free when that is taken or `port` is 0: the reply to
    /// a Forward_Open tells it (R-CPF-8).
    std::optional<std::uint16_t> io_port{};
};

/// Where it is found now.
struct Listening {
    Endpoint local;
    std::uint16_t io_port = 0;
    std::uint32_t subnet_mask = 0;  ///< of the subnet that the address is in; 0 at all addresses
    std::string interface {};       ///< that the address belongs to, by name; empty at all addresses
};

/// An interface that a target has for itself. What must be so is said in docs/adapter.md.
struct ManageOptions {
    std::string interface {};
    std::uint16_t port = tcp_port;           ///< see ListenOptions
    std::optional<std::uint16_t> io_port{};  ///< see ListenOptions
    /// Called with each place at which the target listens from then on.
    std::function<void(const Listening&)> listens = [](const Listening&) {};
};

class TargetServer {
public:
    /// `problem` receives a line when something goes wrong that the server can live with.
    explicit TargetServer(std::function<void(const std::string&)> problem = {});
    ~TargetServer();
    TargetServer(const TargetServer&) = delete;
    TargetServer& operator=(const TargetServer&) = delete;

    /// Opens the sockets of a target, which must outlive the server. Any number of these, before run().
    [[nodiscard]] boost::system::result<Listening, ListenError> listen(Target& target, const ListenOptions& options);

    /// The target has the address that `user` wants to have on an interface, and listens there; while there is none, it
    /// lives on. Both outlive the server. Once, before run(). Returns the MAC address of the interface.
    [[nodiscard]] boost::system::result<std::array<std::uint8_t, 6>, ListenError> manage(Target& target,
                                                                                         AddressUser& user,
                                                                                         ManageOptions options);

    /// `user` hears and sends the frames of Device Level Ring on these interfaces, its first port first. It outlives the
    /// server. Before run().
    [[nodiscard]] std::optional<ListenError> join_ring(LinkUser& user, const std::vector<std::string>& interfaces);

    /// `user` speaks with the program whose Unix-domain socket is at `path`, whenever it is there. It outlives the server.
    /// Before run().
    [[nodiscard]] std::optional<ListenError> converse(MessageUser& user, const std::string& path);

    /// Answers lines of text too, on the thread of run() and with the same clock as the targets: "-" means standard input
    /// and output, anything else is the path of a Unix-domain socket. Any number of these, before run().
    [[nodiscard]] std::optional<ListenError> serve_lines(const LineService& service, const std::string& where);

    /// Calls `look` on the thread of run(), first when it starts and then at each interval, for whoever shows how the targets
    /// are. It must change nothing about them. Any number of these, before run().
    void every(std::chrono::milliseconds interval, std::function<void(Time)> look);

    /// Does a job on a thread beside that of run(), one after the other, and then `done` on that of run(), with the time
    /// there; afterwards the target is asked what it has to send. While run() goes on. It returns when all jobs are done.
    void in_background(Target& target, std::function<void()> job, std::function<void(Time)> done);

    /// From now on SIGINT and SIGTERM do what stop() does; one that comes before run() ends it at once.
    void catch_signals();
    /// Serves until stop(). Before returning it calls `stopping`, closes every connection and frees the sockets.
    void run(const std::function<void()>& stopping = {});
    /// Ends run(); from any thread.
    void stop();

private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace servobus::enip::asio
