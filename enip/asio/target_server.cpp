#include "enip/asio/target_server.hpp"

#include <fmt/format.h>

#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "enip/asio/datagram_socket.hpp"
#include "enip/asio/interfaces.hpp"
#include "enip/asio/line_server.hpp"
#include "enip/encapsulation.hpp"

namespace servobus::enip::asio {
namespace {

namespace net = boost::asio;
using boost::system::error_code;
using net::ip::tcp;
using namespace std::chrono_literals;

constexpr auto awaited = net::as_tuple(net::use_awaitable);

constexpr std::size_t read_buffer_octets = std::size_t{16} * 1024;
/// Datagrams taken in one go before other work has its turn.
constexpr int datagrams_at_once = 64;
/// What a peer may still send after its last reply, and how long it may take, before its connection is cut.
constexpr std::size_t farewell_octets = std::size_t{64} * 1024;
constexpr auto farewell_time = 500ms;
/// After accept() failed for want of a resource.
constexpr auto accept_pause = 100ms;
/// Port 0 is one that TCP has free; when UDP has not, another one is tried.
constexpr int port_tries = 16;

Endpoint to_endpoint(const tcp::endpoint& native) {
    if (!native.address().is_v4()) return {};
    return {native.address().to_v4().to_uint(), native.port()};
}

Time clock_now() { return std::chrono::steady_clock::now(); }

}  // namespace

class TargetServer::Impl {
public:
    Impl(Target& target, std::function<void(const std::string&)> problem)
        : target_(target),
          problem_(std::move(problem)),
          acceptor_(context_),
          unicast_(context_.get_executor()),
          directed_(context_.get_executor()),
          limited_(context_.get_executor()),
          timer_(context_),
          signals_(context_) {}

    std::optional<ListenError> listen(const std::string& address, std::uint16_t port);
    std::optional<ListenError> serve_lines(const LineService& service, const std::string& where);
    [[nodiscard]] Endpoint local() const { return local_; }
    [[nodiscard]] std::uint32_t subnet_mask() const { return interface_ ? interface_->mask : 0; }
    void catch_signals();
    void run(const std::function<void()>& stopping);
    void stop() {
        net::post(context_, [this] { shut_down(); });
    }

private:
    void open_broadcast(DatagramSocket& socket, std::uint32_t address);
    void report(const std::string& line) const {
        if (problem_) problem_(line);
    }

    net::awaitable<void> accept();
    net::awaitable<void> serve(tcp::socket socket);
    net::awaitable<void> exchange(tcp::socket& socket, Target::ConnectionId id);
    net::awaitable<void> farewell(tcp::socket& socket, Target::ConnectionId id);
    net::awaitable<void> datagrams(DatagramSocket& socket);
    net::awaitable<void> timer();
    net::awaitable<void> wait_for_signal();

    void after_event();
    void flush_datagrams();
    void close_expired();
    void cut(Target::ConnectionId id);
    void shut_down();

    Target& target_;
    std::function<void(const std::string&)> problem_;
    net::io_context context_{1};
    tcp::acceptor acceptor_;
    DatagramSocket unicast_;
    DatagramSocket directed_;  ///< the subnet's broadcast, which a socket bound to one address does not hear
    DatagramSocket limited_;   ///< 255.255.255.255
    net::steady_timer timer_;
    net::signal_set signals_;
    Endpoint local_;
    std::optional<Interface> interface_;
    std::map<Target::ConnectionId, tcp::socket*> sockets_;
    std::vector<std::unique_ptr<LineServer>> lines_;
    std::optional<Time> armed_;
    std::function<void()> stopping_;
    bool stopped_ = false;
};

std::optional<ListenError> TargetServer::Impl::listen(const std::string& address, std::uint16_t port) {
    error_code error;
    const auto parsed = net::ip::make_address_v4(address, error);
    if (error)
        return ListenError{
            fmt::format("'{}' is not an IPv4 address; give one of this machine, such as 127.0.0.1", address)};
    const tcp::endpoint endpoint(parsed, port);
    const auto fail = [&](std::string_view protocol, std::uint16_t at) {
        std::string_view hint;
        if (error == net::error::address_in_use)
            hint = "; another program listens there, stop it or choose --port or --bind";
        if (error == net::error::access_denied) hint = "; ports below 1024 need privileges";
        if (error.value() == EADDRNOTAVAIL) hint = "; this machine does not have that address";
        return ListenError{
            fmt::format("cannot listen at {} {}:{}: {}{}", protocol, address, at, error.message(), hint)};
    };
    for (int tries = port == 0 ? port_tries : 1; tries > 0; --tries) {
        acceptor_.open(tcp::v4(), error);
        if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
        if (!error) acceptor_.bind(endpoint, error);
        if (!error) acceptor_.listen(tcp::acceptor::max_listen_connections, error);
        if (error) return fail("TCP", port);
        local_ = to_endpoint(acceptor_.local_endpoint());
        error = unicast_.open(local_, false);
        if (!error) break;
        unicast_.close();
        error_code ignored;
        acceptor_.close(ignored);
    }
    if (error) return fail("UDP", local_.port);
    interface_ = interface_of(local_.address);
    if (interface_) {
        open_broadcast(directed_, interface_->broadcast());
        open_broadcast(limited_, 0xFFFFFFFF);
    }
    return std::nullopt;
}

// A device that does not hear broadcasts still serves whoever knows its address.
void TargetServer::Impl::open_broadcast(DatagramSocket& socket, std::uint32_t address) {
    const Endpoint endpoint{address, local_.port};
    if (const auto error = socket.open(endpoint, true)) {
        report(fmt::format("broadcasts to {} are not heard: {}", to_string(endpoint), error.message()));
        socket.close();
    }
}

std::optional<ListenError> TargetServer::Impl::serve_lines(const LineService& service, const std::string& where) {
    auto server = std::make_unique<LineServer>(
        context_.get_executor(), service, [this] { after_event(); }, [this](const std::string& line) { report(line); });
    auto reason = where == "-" ? server->use_standard_streams() : server->listen(where);
    if (reason) return ListenError{*std::move(reason)};
    lines_.push_back(std::move(server));
    return std::nullopt;
}

void TargetServer::Impl::catch_signals() {
    error_code error;
    signals_.add(SIGINT, error);
    if (!error) signals_.add(SIGTERM, error);
    if (error) {
        report(fmt::format("signals are not caught: {}", error.message()));
        return;
    }
    net::co_spawn(context_, wait_for_signal(), net::detached);
}

void TargetServer::Impl::run(const std::function<void()>& stopping) {
    stopping_ = stopping;
    net::co_spawn(context_, accept(), net::detached);
    net::co_spawn(context_, datagrams(unicast_), net::detached);
    if (directed_.socket().is_open()) net::co_spawn(context_, datagrams(directed_), net::detached);
    if (limited_.socket().is_open()) net::co_spawn(context_, datagrams(limited_), net::detached);
    net::co_spawn(context_, timer(), net::detached);
    for (const auto& lines : lines_) lines->start();
    context_.run();
}

net::awaitable<void> TargetServer::Impl::wait_for_signal() {
    if (stopped_) co_return;
    const auto [failed, number] = co_await signals_.async_wait(awaited);
    if (!failed) shut_down();
}

net::awaitable<void> TargetServer::Impl::accept() {
    while (acceptor_.is_open()) {
        auto [error, socket] = co_await acceptor_.async_accept(awaited);
        if (error == net::error::operation_aborted) co_return;
        if (error) {
            report(fmt::format("a connection could not be accepted: {}", error.message()));
            net::steady_timer pause(context_, accept_pause);
            co_await pause.async_wait(awaited);
            continue;
        }
        net::co_spawn(context_, serve(std::move(socket)), net::detached);
    }
}

net::awaitable<void> TargetServer::Impl::serve(tcp::socket socket) {
    error_code error;
    socket.set_option(tcp::no_delay(true), error);
    const auto peer = to_endpoint(socket.remote_endpoint(error));
    const auto local = to_endpoint(socket.local_endpoint(error));
    const auto id = target_.on_open(peer, local, clock_now());
    if (!id) co_return;
    sockets_[*id] = &socket;
    after_event();  // others may have made room for this one
    co_await exchange(socket, *id);
    sockets_.erase(*id);
    target_.on_closed(*id, clock_now());
}

// Replies to everything that one read brought leave in one write. While a peer does not take its replies, no more of
// its requests are read, so that it holds one read and one batch of replies and nothing else.
net::awaitable<void> TargetServer::Impl::exchange(tcp::socket& socket, Target::ConnectionId id) {
    std::array<std::uint8_t, read_buffer_octets> buffer;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    while (!stopped_) {
        const auto [error, size] = co_await socket.async_read_some(net::buffer(buffer), awaited);
        if (error) co_return;
        cip::ByteView octets(buffer.data(), size);
        while (!octets.empty()) {
            octets = octets.subspan(target_.on_octets(id, octets, clock_now()));
            const auto replies = target_.take_replies(id);
            after_event();  // not later: the peer may take its time with the replies
            if (!replies.empty()) {
                const auto [failed, written] = co_await net::async_write(socket, net::buffer(replies), awaited);
                if (failed) co_return;
            } else if (!octets.empty()) {
                co_await net::post(context_, awaited);  // there was nothing to write, and others have their turn too
            }
            if (target_.wants_close(id)) {
                if (!stopped_) co_await farewell(socket, id);
                co_return;
            }
        }
    }
}

// Closing with octets unread would reset the connection and could take the last reply with it.
net::awaitable<void> TargetServer::Impl::farewell(tcp::socket& socket, Target::ConnectionId id) {
    error_code error;
    socket.shutdown(tcp::socket::shutdown_send, error);
    net::steady_timer limit(context_, farewell_time);
    // By its id, because the socket may be gone when the timer has fired already and could not be cancelled any more.
    limit.async_wait([this, id](error_code cancelled) {
        if (!cancelled) cut(id);
    });
    std::array<std::uint8_t, 4096> buffer;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    for (std::size_t total = 0; total < farewell_octets;) {
        const auto [failed, size] = co_await socket.async_read_some(net::buffer(buffer), awaited);
        if (failed) break;
        total += size;
    }
    limit.cancel();
}

net::awaitable<void> TargetServer::Impl::datagrams(DatagramSocket& socket) {
    std::array<std::uint8_t, header_bytes + max_data_bytes> buffer;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    while (!stopped_) {
        const auto [error] = co_await socket.socket().async_wait(net::ip::udp::socket::wait_read, awaited);
        if (error == net::error::operation_aborted) co_return;
        for (int i = 0; i < datagrams_at_once; ++i) {
            const auto datagram = socket.receive(buffer);
            if (!datagram) break;
            // 255.255.255.255 is heard from all interfaces; only the one that has our address is ours.
            if (&socket == &limited_ && datagram->interface_index != interface_->index) continue;
            auto local = datagram->local;
            if (local_.address != 0) local.address = local_.address;
            target_.on_datagram(datagram->peer, local, datagram->broadcast || &socket != &unicast_, datagram->octets,
                                clock_now());
        }
        after_event();
    }
}

net::awaitable<void> TargetServer::Impl::timer() {
    if (stopped_) co_return;
    target_.on_timer(clock_now());
    after_event();
    while (!stopped_) {
        timer_.expires_at(armed_.value_or(Time::max()));
        static_cast<void>(co_await timer_.async_wait(awaited));
        if (stopped_) co_return;
        const auto now = clock_now();
        const auto next = target_.next_deadline();
        if (next && *next <= now) {
            target_.on_timer(now);
            flush_datagrams();
            close_expired();
        }
        armed_ = target_.next_deadline();
    }
}

void TargetServer::Impl::after_event() {
    flush_datagrams();
    close_expired();
    // A deadline that moved later is noticed when the timer fires; only an earlier one needs a new start.
    const auto next = target_.next_deadline();
    if (next && (!armed_ || *next < *armed_)) {
        armed_ = next;
        timer_.cancel();
    }
}

void TargetServer::Impl::flush_datagrams() {
    for (const auto& datagram : target_.take_datagrams()) unicast_.send(datagram);
}

void TargetServer::Impl::close_expired() {
    for (const auto id : target_.take_expired()) cut(id);
}

// Whatever its coroutine waits for ends, and so does everything that it would wait for later.
void TargetServer::Impl::cut(Target::ConnectionId id) {
    const auto found = sockets_.find(id);
    if (found == sockets_.end()) return;
    error_code ignored;
    found->second->shutdown(tcp::socket::shutdown_both, ignored);
    found->second->cancel(ignored);
}

void TargetServer::Impl::shut_down() {
    if (std::exchange(stopped_, true)) return;
    if (stopping_) stopping_();
    error_code ignored;
    acceptor_.close(ignored);
    for (auto* socket : {&unicast_, &directed_, &limited_}) socket->close();
    timer_.cancel();
    signals_.cancel(ignored);
    for (const auto& lines : lines_) lines->stop();
    close_expired();
    for (auto& [id, socket] : sockets_) {
        socket->shutdown(tcp::socket::shutdown_both, ignored);
        socket->cancel(ignored);
    }
}

TargetServer::TargetServer(Target& target, std::function<void(const std::string&)> problem)
    : impl_(std::make_unique<Impl>(target, std::move(problem))) {}

TargetServer::~TargetServer() = default;

std::optional<ListenError> TargetServer::listen(const std::string& address, std::uint16_t port) {
    return impl_->listen(address, port);
}

std::optional<ListenError> TargetServer::serve_lines(const LineService& service, const std::string& where) {
    return impl_->serve_lines(service, where);
}

Endpoint TargetServer::local() const { return impl_->local(); }

std::uint32_t TargetServer::subnet_mask() const { return impl_->subnet_mask(); }

void TargetServer::catch_signals() { impl_->catch_signals(); }

void TargetServer::run(const std::function<void()>& stopping) { impl_->run(stopping); }

void TargetServer::stop() { impl_->stop(); }

}  // namespace servobus::enip::asio
