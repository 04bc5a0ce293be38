#include "enip/asio/target_station.hpp"

#include <fmt/format.h>

#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <span>
#include <utility>

#include "cip/wire.hpp"
#include "enip/asio/mark.hpp"
#include "enip/encapsulation.hpp"

namespace servobus::enip::asio {
namespace {

namespace net = boost::asio;
using boost::system::error_code;
using net::ip::tcp;
using namespace std::chrono_literals;

constexpr auto awaited = net::as_tuple(net::use_awaitable);

constexpr std::size_t read_buffer_octets = std::size_t{16} * 1024;
/// Reads of one connection before other work has its turn.
constexpr int reads_at_once = 4;
/// Datagrams taken in one go before other work has its turn.
constexpr int datagrams_at_once = 64;
/// The same of class 0 and 1, in batches.
constexpr int io_batches_at_once = 4;
/// A timer that comes later than this looks first for what has come in time and waits in the kernel: a process that was
/// held up is no reason to end a connection.
constexpr auto late = 500us;
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

// How many octets the kernel takes at once. An error comes again, to whoever goes on writing.
std::size_t write_now(tcp::socket& socket, cip::ByteView octets) {
    error_code error;
    const auto written = socket.write_some(net::buffer(octets.data(), octets.size()), error);
    return error ? 0 : written;
}

// What is there at once; 0 when there is nothing, or an error, which comes again.
std::size_t read_now(tcp::socket& socket, std::span<std::uint8_t> room) {
    error_code error;
    const auto size = socket.read_some(net::buffer(room.data(), room.size()), error);
    return error ? 0 : size;
}

// More than one message: the peer does not wait for the replies, and the next ones are there already, or soon.
bool holds_many(cip::ByteView octets) {
    constexpr std::size_t length_at = 2;
    if (octets.size() < header_bytes) return false;
    cip::Reader reader(octets.subspan(length_at));
    return octets.size() > header_bytes + reader.u16();
}

ListenError cannot_listen(std::string_view protocol, Endpoint at, const error_code& error) {
    std::string_view hint;
    if (error == net::error::address_in_use)
        hint = "; another program listens there, stop it or choose --port or --bind";
    if (error == net::error::access_denied) hint = "; ports below 1024 need privileges";
    if (error.value() == EADDRNOTAVAIL) hint = "; this machine does not have that address";
    return {fmt::format("cannot listen at {} {}: {}{}", protocol, to_string(at), error.message(), hint)};
}

}  // namespace

TargetStation::TargetStation(Target& target, Shared& shared)
    : target_(target),
      shared_(shared),
      acceptor_(shared.context),
      unicast_(shared.context.get_executor()),
      directed_(shared.context.get_executor()),
      limited_(shared.context.get_executor()),
      io_(shared.context.get_executor(), shared.io_room) {}

boost::system::result<Listening, ListenError> TargetStation::listen(const ListenOptions& options) {
    leave();
    error_code error;
    const auto address = net::ip::make_address_v4(options.address, error);
    if (error) {
        return ListenError{
            fmt::format("'{}' is not an IPv4 address; give one of this machine, such as 127.0.0.1", options.address)};
    }
    auto failed = open_messages(options, address.to_uint());
    if (!failed) failed = open_io(options);
    if (failed) {
        close_sockets();
        return *std::move(failed);
    }
    mark_messages();
    interface_ = interface_of(local_.address);
    if (interface_) {
        open_broadcast(directed_, interface_->broadcast());
        open_broadcast(limited_, 0xFFFFFFFF);
    }
    if (started_) serve_place();
    if (!interface_) return Listening{local_, io_port()};
    return Listening{local_, io_port(), interface_->mask, interface_->name};
}

// TCP and UDP at the same port.
std::optional<ListenError> TargetStation::open_messages(const ListenOptions& options, std::uint32_t address) {
    error_code error;
    const tcp::endpoint endpoint(net::ip::address_v4(address), options.port);
    for (int tries = options.port == 0 ? port_tries : 1; tries > 0; --tries) {
        acceptor_.open(tcp::v4(), error);
        if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
        if (!error) acceptor_.bind(endpoint, error);
        if (!error) acceptor_.listen(tcp::acceptor::max_listen_connections, error);
        if (error) return cannot_listen("TCP", {address, options.port}, error);
        local_ = to_endpoint(acceptor_.local_endpoint());
        error = unicast_.open(local_, false);
        if (!error) return std::nullopt;
        unicast_.close();
        error_code ignored;
        acceptor_.close(ignored);
    }
    return cannot_listen("UDP", local_, error);
}

// Taken alone, so that no other drive's data comes here by accident; shared afterwards, so that a scanner on this
// machine may listen at all its addresses.
std::optional<ListenError> TargetStation::open_io(const ListenOptions& options) {
    const std::uint16_t wanted = options.io_port.value_or(options.port == 0 ? 0 : enip::io_port);
    auto error = io_.open({local_.address, wanted}, false);
    if (error == net::error::address_in_use && !options.io_port) {
        error = io_.open({local_.address, 0}, false);
        report(
            fmt::format("UDP {} is in use by another program: I/O data is received at port {} instead, which only "
                        "originators find that read the sockaddr item of the Forward_Open reply",
                        to_string({local_.address, wanted}), io_port()));
    }
    if (error) return cannot_listen("UDP", {local_.address, wanted}, error);
    error_code ignored;
    io_.socket().set_option(net::ip::udp::socket::reuse_address(true), ignored);
    return std::nullopt;
}

// A device that does not hear broadcasts still serves whoever knows its address.
void TargetStation::open_broadcast(DatagramSocket& socket, std::uint32_t address) {
    const Endpoint endpoint{address, local_.port};
    if (const auto error = socket.open(endpoint, true)) {
        report(fmt::format("broadcasts to {} are not heard: {}", to_string(endpoint), error.message()));
        socket.close();
    }
}

// The values of QoS are those of the last restart (R-QOS-4), of which these sockets hear nothing.
void TargetStation::mark_messages() {
    const auto dscp = target_.explicit_dscp();
    if (dscp_ == dscp) return;
    dscp_ = dscp;
    mark(acceptor_.native_handle(), dscp);
    mark(unicast_.socket().native_handle(), dscp);
}

void TargetStation::start() {
    started_ = true;
    if (acceptor_.is_open()) serve_place();
}

void TargetStation::serve_place() {
    net::co_spawn(shared_.context, accept(place_), net::detached);
    net::co_spawn(shared_.context, io(place_), net::detached);
    for (auto* socket : {&unicast_, &directed_, &limited_}) {
        if (socket->socket().is_open()) net::co_spawn(shared_.context, datagrams(*socket, place_), net::detached);
    }
}

net::awaitable<void> TargetStation::accept(unsigned place) {
    while (is_at(place)) {
        auto [error, socket] = co_await acceptor_.async_accept(awaited);
        if (!is_at(place) || error == net::error::operation_aborted) co_return;
        if (error) {
            report(fmt::format("a connection could not be accepted: {}", error.message()));
            net::steady_timer pause(shared_.context, accept_pause);
            co_await pause.async_wait(awaited);
            continue;
        }
        net::co_spawn(shared_.context, serve(std::move(socket)), net::detached);
    }
}

net::awaitable<void> TargetStation::serve(tcp::socket socket) {
    error_code error;
    socket.set_option(tcp::no_delay(true), error);
    socket.non_blocking(true, error);  // for write_now()
    mark(socket.native_handle(), target_.explicit_dscp());
    const auto peer = to_endpoint(socket.remote_endpoint(error));
    const auto local = to_endpoint(socket.local_endpoint(error));
    const auto id = target_.on_open(peer, local, now());
    if (!id) co_return;
    peers_[*id].socket = &socket;
    after_event();  // others may have made room for this one
    co_await exchange(socket, *id);
    peers_.erase(*id);
    target_.on_closed(*id, now());
}

// Replies to everything that one read brought leave in one write. While a peer does not take its replies, no more of
// its requests are read, so that it holds one read and one batch of replies and nothing else.
net::awaitable<void> TargetStation::exchange(tcp::socket& socket, Target::ConnectionId id) {
    std::array<std::uint8_t, read_buffer_octets> buffer;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    auto& peer = peers_[id];
    int more_reads = 0;  // that may follow without others having their turn
    while (!stopped_) {
        for (auto overdue = target_.take_replies(id); !overdue.empty(); overdue = target_.take_replies(id)) {
            const auto [failed, written] = co_await net::async_write(socket, net::buffer(overdue), awaited);
            if (failed) co_return;
        }
        if (target_.wants_close(id)) {
            if (!stopped_) co_await farewell(socket, id);
            co_return;
        }
        auto size = more_reads > 0 ? read_now(socket, buffer) : 0;
        if (size == 0) {
            peer.reads = true;
            const auto [error, octets_read] = co_await socket.async_read_some(net::buffer(buffer), awaited);
            peer.reads = false;
            if (error == net::error::operation_aborted && !target_.wants_close(id)) continue;  // there are late replies
            if (error) co_return;
            size = octets_read;
            more_reads = reads_at_once;
        }
        more_reads = holds_many(cip::ByteView(buffer).first(size)) ? more_reads - 1 : 0;
        cip::ByteView octets(buffer.data(), size);
        while (!octets.empty()) {
            // What has come before and what was due before come before; the latter also leaves before, since after the reply
            // to a Forward_Close nothing of the connection does (R-CON-37).
            if (catch_up()) {
                flush();
            } else if (io_.is_quiet()) {
                receive_io();
            }
            octets = octets.subspan(target_.on_octets(id, octets, now()));
            const auto replies = target_.take_replies(id);
            // In this order: no datagram of a connection leaves before the reply that opens it (R-CON-50), and none waits
            // for a peer who takes his time with the replies.
            const auto rest = cip::ByteView(replies).subspan(write_now(socket, replies));
            after_event();
            if (!rest.empty()) {
                const auto [failed, written] =
                    co_await net::async_write(socket, net::buffer(rest.data(), rest.size()), awaited);
                if (failed) co_return;
            } else if (!octets.empty()) {
                co_await net::post(shared_.context, awaited);  // others have their turn too
            }
            if (target_.wants_close(id)) {
                if (!stopped_) co_await farewell(socket, id);
                co_return;
            }
        }
    }
}

// Closing with octets unread would reset the connection and could take the last reply with it.
net::awaitable<void> TargetStation::farewell(tcp::socket& socket, Target::ConnectionId id) {
    error_code error;
    socket.shutdown(tcp::socket::shutdown_send, error);
    net::steady_timer limit(shared_.context, farewell_time);
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

net::awaitable<void> TargetStation::datagrams(DatagramSocket& socket, unsigned place) {
    while (is_at(place)) {
        const auto [error] = co_await socket.socket().async_wait(net::ip::udp::socket::wait_read, awaited);
        if (!is_at(place) || error == net::error::operation_aborted) co_return;
        for (int i = 0; i < datagrams_at_once; ++i) {
            const auto datagram = socket.receive(shared_.datagram);
            if (!datagram) break;
            // 255.255.255.255 is heard from all interfaces; only the one that has our address is ours.
            if (&socket == &limited_ && datagram->interface_index != interface_->index) continue;
            auto local = datagram->local;
            if (local_.address != 0) local.address = local_.address;
            target_.on_datagram(datagram->peer, local, datagram->broadcast || &socket != &unicast_, datagram->octets,
                                now());
        }
        after_event();
    }
}

net::awaitable<void> TargetStation::io(unsigned place) {
    while (is_at(place) && !io_.is_quiet()) {
        const auto [error] = co_await io_.socket().async_wait(net::ip::udp::socket::wait_read, awaited);
        if (!is_at(place) || error == net::error::operation_aborted) co_return;
        receive_io();
        after_event();
    }
}

// Each with the time at which the kernel took it, however late it is looked at.
void TargetStation::receive_io() {
    std::size_t received = 0;
    std::size_t batch = io_batch;
    for (int i = 0; i < io_batches_at_once && batch == io_batch; ++i) received += batch = io_.receive(take_io_);
    io_seen_ = clock_now();
    shared_.rhythm.count(received, io_seen_);
}

// A busy server takes datagrams when something is due, and not when each comes.
void TargetStation::follow_rhythm() {
    const bool quiet = started_ && io_.is_open() && shared_.rhythm.is_busy() && target_.io_may_wait();
    if (quiet == io_.is_quiet()) return;
    io_.set_quiet(quiet);
    if (!io_.is_quiet() && io_.is_open()) net::co_spawn(shared_.context, io(place_), net::detached);
}

void TargetStation::on_time() {
    if (stopped_) return;
    if (!deadline_) {  // it has never had any time
        target_.on_timer(now());
        after_event();
    } else {
        if (!catch_up() && io_.is_quiet()) receive_io();
        flush();
        if (shared_.after_event) shared_.after_event();
    }
    follow_rhythm();
    // One that moved later is noticed here; after_event() looks for an earlier one alone.
    deadline_ = target_.next_deadline().value_or(Time::max());
    if (io_.is_quiet()) deadline_ = std::min(*deadline_, io_seen_ + longest_io_wait);
}

// Not now() before the datagrams are taken: they have come earlier, and time does not go back for the target.
bool TargetStation::catch_up(std::optional<Time> next) {
    const auto passed = next ? clock_now() - *next : Time::duration(-1);
    if (passed < Time::duration(0)) return false;
    if (passed > late || io_.is_quiet()) receive_io();
    target_.on_timer(now());
    mark_messages();  // it may have been a restart
    return true;
}

// Most events come long before anything is due, which deadline_ tells without asking the target.
bool TargetStation::catch_up() {
    if (deadline_ && clock_now() < *deadline_) return false;
    return catch_up(target_.next_deadline());
}

Time TargetStation::now() {
    latest_ = std::max(latest_, clock_now());
    target_.on_day_clock(day_.ahead(latest_));
    return latest_;
}

void TargetStation::after_line() {
    static_cast<void>(now());  // the line was answered with the time of now
    after_event();
}

void TargetStation::after_event() {
    // What is due by now does not wait for the timer's turn, which may come late when there are many requests.
    auto next = target_.next_deadline();
    if (catch_up(next)) next = target_.next_deadline();
    mark_messages();
    flush();
    if (next && (!deadline_ || *next < *deadline_)) {
        deadline_ = next;
        shared_.wants_time(*next);
    }
    if (shared_.after_event) shared_.after_event();
}

void TargetStation::flush() {
    if (!target_.io_queue().empty()) shared_.io_is_due(*this);
    for (const auto& datagram : target_.take_datagrams()) unicast_.send(datagram);
    close_expired();
}

void TargetStation::close_expired() {
    for (const auto id : target_.take_ready()) wake(id);
    for (const auto id : target_.take_expired()) cut(id);
}

// Whatever its coroutine waits for ends, and so does everything that it would wait for later.
void TargetStation::cut(Target::ConnectionId id) {
    const auto found = peers_.find(id);
    if (found == peers_.end()) return;
    error_code ignored;
    found->second.socket->shutdown(tcp::socket::shutdown_both, ignored);
    found->second.socket->cancel(ignored);
}

// Its read ends, so that it writes what is ready.
void TargetStation::wake(Target::ConnectionId id) {
    const auto found = peers_.find(id);
    if (found == peers_.end() || !found->second.reads) return;
    error_code ignored;
    found->second.socket->cancel(ignored);
}

void TargetStation::leave() {
    ++place_;
    close_sockets();
}

void TargetStation::shut_down() {
    stopped_ = true;
    close_sockets();
}

void TargetStation::close_sockets() {
    error_code ignored;
    acceptor_.close(ignored);
    for (auto* socket : {&unicast_, &directed_, &limited_}) socket->close();
    io_.close();
    interface_.reset();
    dscp_.reset();
    close_expired();
    for (auto& [id, peer] : peers_) {
        peer.socket->shutdown(tcp::socket::shutdown_both, ignored);
        peer.socket->cancel(ignored);
    }
}

}  // namespace servobus::enip::asio
