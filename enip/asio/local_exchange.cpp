#include "enip/asio/local_exchange.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cerrno>
#include <chrono>
#include <utility>

namespace servobus::enip::asio {
namespace {

namespace net = boost::asio;
using boost::system::error_code;
using net::local::datagram_protocol;

constexpr auto awaited = net::as_tuple(net::use_awaitable);

/// Messages taken in one go before other work has its turn.
constexpr int messages_at_once = 16;

// The other program has to have somewhere to answer to: Linux gives the socket a name of its own, which is no file.
error_code bind_somewhere(int socket) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const auto* any = reinterpret_cast<const sockaddr*>(&address);
    if (::bind(socket, any, sizeof(address.sun_family)) == 0) return {};
    return {errno, boost::system::system_category()};
}

}  // namespace

LocalExchange::LocalExchange(net::io_context& context, MessageUser& user)
    : context_(context), user_(user), socket_(context), timer_(context) {}

std::optional<std::string> LocalExchange::open(const std::string& path) {
    if (path.empty() || path.size() >= sizeof(sockaddr_un::sun_path)) {
        return fmt::format("'{}' is no path of a socket; it has 1 to {} characters", path,
                           sizeof(sockaddr_un::sun_path) - 1);
    }
    peer_ = datagram_protocol::endpoint(path);
    error_code error;
    socket_.open(datagram_protocol(), error);
    if (!error) socket_.non_blocking(true, error);
    if (!error) error = bind_somewhere(socket_.native_handle());
    if (error) return fmt::format("nothing can be asked at {}: {}", path, error.message());
    return std::nullopt;
}

void LocalExchange::start() {
    net::co_spawn(context_, messages(), net::detached);
    net::co_spawn(context_, timer(), net::detached);
}

// gcc 12 inlines one of the two functions of Asio that allocate and free a coroutine's frame, and not the other.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"

net::awaitable<void> LocalExchange::messages() {
    while (!stopped_) {
        const auto [error] = co_await socket_.async_wait(datagram_protocol::socket::wait_read, awaited);
        if (stopped_ || error) co_return;
        receive();
        settle();
    }
}

net::awaitable<void> LocalExchange::timer() {
    if (stopped_) co_return;
    user_.on_timer(now());
    settle();
    while (!stopped_) {
        timer_.expires_at(armed_.value_or(Time::max()));
        static_cast<void>(co_await timer_.async_wait(awaited));
        if (stopped_) co_return;
        const auto next = user_.next_deadline();
        if (next && *next <= now()) user_.on_timer(latest_);
        settle();
        armed_ = user_.next_deadline();
    }
}

#pragma GCC diagnostic pop

// Anybody on this machine may send something here; the other program alone is heard.
void LocalExchange::receive() {
    std::array<std::uint8_t, max_local_message> buffer;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    for (int i = 0; i < messages_at_once; ++i) {
        error_code error;
        datagram_protocol::endpoint from;
        const auto size = socket_.receive_from(net::buffer(buffer), from, 0, error);
        if (error) return;
        if (from == peer_) user_.on_message({buffer.data(), size}, now());
    }
}

// What cannot be sent is lost, as it may be on any way: whoever asks knows how long he waits for an answer.
void LocalExchange::settle() {
    if (stopped_) return;
    for (const auto& message : user_.take_messages()) {
        error_code ignored;
        socket_.send_to(net::buffer(message), peer_, 0, ignored);
    }
    const auto next = user_.next_deadline();
    if (!next || (armed_ && *armed_ <= *next)) return;
    armed_ = next;
    timer_.cancel();
}

Time LocalExchange::now() { return latest_ = std::max(latest_, std::chrono::steady_clock::now()); }

void LocalExchange::shut_down() {
    if (std::exchange(stopped_, true)) return;
    error_code ignored;
    socket_.close(ignored);
    timer_.cancel();
}

}  // namespace servobus::enip::asio
