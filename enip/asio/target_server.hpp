// Puts an enip::Target on the network: TCP and UDP sockets, one thread, one timer.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "enip/asio/line_service.hpp"
#include "enip/target.hpp"

namespace servobus::enip::asio {

/// Why the server does not listen: one sentence for the person who started it.
struct ListenError {
    std::string reason;
};

class TargetServer {
public:
    /// `problem` receives a line when something goes wrong that the server can live with. The target must outlive the
    /// server.
    explicit TargetServer(Target& target, std::function<void(const std::string&)> problem = {});
    ~TargetServer();
    TargetServer(const TargetServer&) = delete;
    TargetServer& operator=(const TargetServer&) = delete;

    /// Opens TCP and UDP at an IPv4 address ("127.0.0.1", "0.0.0.0"). Port 0 takes a free one, the same for both.
    [[nodiscard]] std::optional<ListenError> listen(const std::string& address, std::uint16_t port);
    /// Where it listens, after listen().
    [[nodiscard]] Endpoint local() const;
    /// The mask of the subnet that local() is in; 0 when it listens at all addresses.
    [[nodiscard]] std::uint32_t subnet_mask() const;

    /// Answers lines of text too, on the thread of run() and with the same clock as the target: "-" means standard input
    /// and output, anything else is the path of a Unix-domain socket. Any number of these, before run().
    [[nodiscard]] std::optional<ListenError> serve_lines(const LineService& service, const std::string& where);

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
