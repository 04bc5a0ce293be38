// One MessageUser and the program of this machine that it speaks with: datagrams of a Unix-domain socket, and a timer.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/datagram_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstddef>
#include <optional>
#include <string>

#include "enip/message_user.hpp"

namespace servobus::enip::asio {

/// A longer message is cut.
inline constexpr std::size_t max_local_message = 2048;

class LocalExchange {
public:
    /// The user outlives this.
    LocalExchange(boost::asio::io_context& context, MessageUser& user);

    /// `path` is that of the other program's socket, which need not be there yet. Returns why not.
    [[nodiscard]] std::optional<std::string> open(const std::string& path);
    /// Serves the user from now on, once the context runs.
    void start();
    void shut_down();

private:
    [[nodiscard]] boost::asio::awaitable<void> messages();
    [[nodiscard]] boost::asio::awaitable<void> timer();
    void receive();
    void settle();
    [[nodiscard]] Time now();

    boost::asio::io_context& context_;
    MessageUser& user_;
    boost::asio::local::datagram_protocol::socket socket_;
    boost::asio::local::datagram_protocol::endpoint peer_;
    boost::asio::steady_timer timer_;
    std::optional<Time> armed_;
    Time latest_{};
    bool stopped_ = false;
};

}  // namespace servobus::enip::asio
