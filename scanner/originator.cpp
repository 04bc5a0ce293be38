#include "scanner/originator.hpp"

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "enip/asio/io_socket.hpp"
#include "enip/io_packet.hpp"
#include "scanner/client.hpp"
#include "scanner/io_numbers.hpp"
#include "scanner/io_session.hpp"

namespace servobus::scanner {
namespace {

using enip::Endpoint;
using enip::Time;
using enip::asio::IoSocket;

static_assert(max_io_connection_size + enip::io_packet_overhead <= enip::asio::max_io_datagram);

/// Sessions are kept alive this often (R-SCN-1); devices give up after 120 s, if nothing else is set (R-ENC-24).
constexpr std::chrono::seconds keep_alive_interval{30};
/// Batches of datagrams taken in one go before timers have their turn.
constexpr int batches_at_once = 8;

Time clock_now() { return std::chrono::steady_clock::now(); }

std::uint64_t random_seed() {
    std::random_device device;
    return std::uint64_t{device()} << 32 | device();
}

/// A socket and what is to leave through it.
struct Port {
    explicit Port(const net::any_io_executor& executor) : socket(executor) {}
    IoSocket socket;
    enip::IoQueue queue;
    unsigned users = 0;
};

/// A socket that hears one group on one interface.
struct Group {
    Group(const net::any_io_executor& executor, Endpoint group, std::uint32_t local)
        : socket(executor), endpoint(group), local_address(local) {}
    IoSocket socket;
    Endpoint endpoint;
    std::uint32_t local_address;
    unsigned users = 0;
};

}  // namespace

/// Shared, so that whatever runs keeps it alive; all handlers hold it weakly.
class Originator::Impl : public std::enable_shared_from_this<Impl> {
public:
    class Connection;
    Impl(net::any_io_executor executor, OriginatorOptions options)
        : executor_(std::move(executor)),
          options_(options),
          numbers_(options.vendor, options.seed ? *options.seed : random_seed()),
          timer_(executor_),
          keep_alive_timer_(executor_) {}

    IoConnection& add(IoOptions options, IoEvents events);
    void shut_down();
    [[nodiscard]] const StrayCounters& strays() const { return strays_; }
    [[nodiscard]] std::uint64_t unsent() const { return unsent_; }

    // What a connection asks for
    void connect(Connection& connection, std::uint64_t ticket);
    void request(Connection& connection, std::uint64_t ticket, const cip::Request& request,
                 std::vector<enip::Item> items);
    [[nodiscard]] boost::system::result<std::shared_ptr<Port>> port_at(std::uint32_t address);
    void release(const std::shared_ptr<Port>& port);
    [[nodiscard]] boost::system::result<std::shared_ptr<Group>> group_at(Endpoint endpoint, std::uint32_t local);
    void release(const std::shared_ptr<Group>& group);
    void expect(std::uint32_t id, Connection& connection) { expected_[id].push_back(&connection); }
    void forget(std::uint32_t id, Connection& connection);
    [[nodiscard]] bool is_taken(std::uint32_t id, const Connection& by) const;
    void changed(Connection& connection);

private:
    struct Link;
    using Schedule = std::set<std::pair<Time, Connection*>>;

    [[nodiscard]] Link& link_to(const IoOptions& options);
    void start(Link& link);
    void on_connected(Link& link, error_code error);
    void replace(Link& link, std::uint64_t life);
    void finish_idle_links();
    void finish(Link& link);
    void keep_alive();
    void stop_keeping_alive();

    template <class Source>
    void hear(const std::shared_ptr<Source>& source);
    void drain(IoSocket& socket);
    void drain_all();
    void on_datagram(const IoSocket::Received& received);

    void schedule(Connection& connection, std::optional<Time> when);
    void arm();
    /// Whoever runs the executor until nothing is left to do need not wait for a timer that means nothing any more.
    void disarm();
    void run_due(Time now);
    void flush();

    const net::any_io_executor executor_;
    const OriginatorOptions options_;
    IoNumbers numbers_;
    net::steady_timer timer_;
    net::steady_timer keep_alive_timer_;
    bool stopped_ = false;
    bool keeps_alive_ = false;
    bool release_posted_ = false;

    std::map<std::pair<std::string, std::uint16_t>, std::unique_ptr<Link>> links_;
    std::map<std::uint32_t, std::shared_ptr<Port>> ports_;
    std::vector<std::shared_ptr<Group>> groups_;
    std::unordered_map<std::uint32_t, std::vector<Connection*>> expected_;  ///< by T->O id
    std::vector<std::unique_ptr<Connection>> connections_;
    Schedule schedule_;  ///< each connection once, at its deadline or before it
    std::optional<Time> armed_;
    bool running_ = false;  ///< what is due is being done; the timer is armed afterwards
    StrayCounters strays_;
    std::uint64_t unsent_ = 0;
    const std::function<void(const IoSocket::Received&)> take_ = [this](const auto& received) {
        on_datagram(received);
    };
};

/// The TCP connection and session to one device, which all connections to it share.
struct Originator::Impl::Link {
    enum class State : std::uint8_t { idle, connecting, ready, closing };
    Link(const net::any_io_executor& executor, std::string host_name, std::uint16_t tcp_port,
         ClientOptions client_options)
        : host(std::move(host_name)), port(tcp_port), options(std::move(client_options)), client(executor, options) {}

    std::string host;
    std::uint16_t port;
    ClientOptions options;
    Client client;
    State state = State::idle;
    std::uint64_t life = 0;                                      ///< one more with each client
    std::vector<std::pair<Connection*, std::uint64_t>> waiting;  ///< connections and their tickets

    [[nodiscard]] bool stands() const { return state == State::ready && client.ends().has_value(); }
};

/// A session, and what it has of the originator.
class Originator::Impl::Connection final : public IoConnection, private IoSession::Surroundings {
public:
    Connection(Impl& owner, IoOptions options, IoEvents events)
        : session(std::move(options), std::move(events), owner.numbers_, *this), owner_(owner) {}

    void open() override { session.open(clock_now()); }
    void close() override { session.close(clock_now()); }
    void trigger() override { session.trigger(clock_now()); }
    [[nodiscard]] IoState state() const override { return session.state(); }
    [[nodiscard]] const enip::IoConsumer::Counters& received() const override { return session.received(); }
    [[nodiscard]] const enip::IoProducer::Counters& sent() const override { return session.sent(); }

    [[nodiscard]] bool needs_link() const { return state() != IoState::idle && state() != IoState::closed; }
    /// Where its datagrams wait to be sent.
    [[nodiscard]] enip::IoQueue& queue() { return port_ ? port_->queue : nowhere_; }

    IoSession session;
    Link* link = nullptr;
    std::optional<Schedule::iterator> scheduled{};

private:
    void connect(std::uint64_t ticket) override { owner_.connect(*this, ticket); }
    [[nodiscard]] bool connected() const override { return link->stands(); }
    void request(std::uint64_t ticket, const cip::Request& request, std::vector<enip::Item> items) override {
        owner_.request(*this, ticket, request, std::move(items));
    }
    [[nodiscard]] boost::system::result<Endpoint> listen(std::uint32_t local_address) override {
        auto port = owner_.port_at(local_address);
        if (!port) return port.error();
        port_ = std::move(*port);
        return port_->socket.local();
    }
    [[nodiscard]] error_code join(Endpoint group, std::uint32_t local_address) override {
        auto joined = owner_.group_at(group, local_address);
        if (!joined) return joined.error();
        group_ = std::move(*joined);
        return {};
    }
    void stop_listening() override {
        if (const auto port = std::exchange(port_, nullptr)) owner_.release(port);
        if (const auto group = std::exchange(group_, nullptr)) owner_.release(group);
    }
    void expect(std::uint32_t id) override { owner_.expect(id, *this); }
    void forget(std::uint32_t id) override { owner_.forget(id, *this); }
    [[nodiscard]] bool is_taken(std::uint32_t id) const override { return owner_.is_taken(id, *this); }
    void changed() override { owner_.changed(*this); }

    Impl& owner_;
    std::shared_ptr<Port> port_;
    std::shared_ptr<Group> group_;
    enip::IoQueue nowhere_;
};

// ------------------------------------------------------------------------------------------------- connections

IoConnection& Originator::Impl::add(IoOptions options, IoEvents events) {
    auto& link = link_to(options);
    connections_.push_back(std::make_unique<Connection>(*this, std::move(options), std::move(events)));
    connections_.back()->link = &link;
    return *connections_.back();
}

/// The last word of the originator: nothing is called any more.
void Originator::Impl::shut_down() {
    stopped_ = true;
    timer_.cancel();
    keep_alive_timer_.cancel();
    for (const auto& [address, port] : ports_) port->socket.close();
    for (const auto& group : groups_) group->socket.close();
    links_.clear();
}

void Originator::Impl::changed(Connection& connection) {
    const auto next = connection.session.next_deadline();
    if (next && (!connection.scheduled || *next < (*connection.scheduled)->first)) {
        schedule(connection, *next);
        arm();
    } else if (!next && connection.scheduled) {
        schedule(connection, std::nullopt);
        if (schedule_.empty()) disarm();
    }
    if (connection.needs_link() || std::exchange(release_posted_, true)) return;
    net::post(executor_, [weak = weak_from_this()] {
        const auto self = weak.lock();
        if (self && !self->stopped_) self->finish_idle_links();
    });
}

void Originator::Impl::forget(std::uint32_t id, Connection& connection) {
    const auto found = expected_.find(id);
    if (found == expected_.end()) return;
    std::erase(found->second, &connection);
    if (found->second.empty()) expected_.erase(found);
}

bool Originator::Impl::is_taken(std::uint32_t id, const Connection& by) const {
    const auto found = expected_.find(id);
    if (found == expected_.end()) return false;
    const auto& own = by.session;
    return std::ranges::any_of(found->second, [&](const Connection* other) {
        if (other == &by || other->session.ends().remote.address != own.ends().remote.address) return false;
        return !own.is_multicast() || !other->session.is_multicast();
    });
}

// ---------------------------------------------------------------------------------------------------- sessions

Originator::Impl::Link& Originator::Impl::link_to(const IoOptions& options) {
    auto& link = links_[{options.host, options.port}];
    if (!link) {
        ClientOptions client_options;
        client_options.timeout = options.timeout;
        link = std::make_unique<Link>(executor_, options.host, options.port, client_options);
    }
    return *link;
}

void Originator::Impl::connect(Connection& connection, std::uint64_t ticket) {
    auto& link = *connection.link;
    link.waiting.emplace_back(&connection, ticket);
    if (link.state == Link::State::connecting || link.state == Link::State::closing) return;
    if (!link.stands()) {
        start(link);
        return;
    }
    net::post(executor_, [weak = weak_from_this(), &link] {
        const auto self = weak.lock();
        if (!self || self->stopped_ || link.state != Link::State::ready) return;
        self->on_connected(link, link.stands() ? error_code{} : make_error_code(Error::not_connected));
    });
}

void Originator::Impl::start(Link& link) {
    link.state = Link::State::connecting;
    link.client.async_connect(link.host, link.port, [weak = weak_from_this(), &link](error_code error) {
        const auto self = weak.lock();
        if (self && !self->stopped_) self->on_connected(link, error);
    });
}

void Originator::Impl::on_connected(Link& link, error_code error) {
    const auto ends = link.client.ends();
    if (!error && !ends) error = make_error_code(Error::closed);
    link.state = error ? Link::State::idle : Link::State::ready;
    if (!error) keep_alive();
    const auto now = clock_now();
    for (const auto& [connection, ticket] : std::exchange(link.waiting, {})) {
        connection->session.on_connected(ticket, error, ends.value_or(TcpEnds{}), now);
        if (stopped_) return;
    }
}

void Originator::Impl::request(Connection& connection, std::uint64_t ticket, const cip::Request& request,
                               std::vector<enip::Item> items) {
    auto& link = *connection.link;
    link.client.async_exchange(
        request, std::move(items), {.timeout = connection.session.options().timeout},
        [weak = weak_from_this(), &connection, ticket, life = link.life](error_code error, const Exchange& exchange) {
            const auto self = weak.lock();
            if (!self || self->stopped_) return;
            if (error == Error::timeout) self->replace(*connection.link, life);
            connection.session.on_reply(ticket, error, exchange, clock_now());
        });
}

/// A device that does not answer may have forgotten the TCP connection, which would take minutes to notice.
void Originator::Impl::replace(Link& link, std::uint64_t life) {
    if (link.life != life || link.state != Link::State::ready) return;
    ++link.life;
    link.state = Link::State::idle;
    link.client = Client(executor_, link.options);
    if (!link.waiting.empty()) start(link);
    stop_keeping_alive();
}

void Originator::Impl::finish_idle_links() {
    release_posted_ = false;
    for (const auto& [where, link] : links_) {
        const auto needs = [own = link.get()](const auto& connection) {
            return connection->link == own && connection->needs_link();
        };
        if (link->state != Link::State::ready || std::ranges::any_of(connections_, needs)) continue;
        finish(*link);
    }
    stop_keeping_alive();
}

void Originator::Impl::finish(Link& link) {
    link.state = Link::State::closing;
    link.client.async_close([weak = weak_from_this(), &link](error_code) {
        const auto self = weak.lock();
        if (!self || self->stopped_) return;
        link.state = Link::State::idle;
        if (!link.waiting.empty()) self->start(link);
        self->stop_keeping_alive();
    });
}

void Originator::Impl::stop_keeping_alive() {
    const auto stands = [](const auto& entry) { return entry.second->state == Link::State::ready; };
    if (std::ranges::any_of(links_, stands)) return;
    keep_alive_timer_.cancel();
    keeps_alive_ = false;
}

void Originator::Impl::keep_alive() {
    if (std::exchange(keeps_alive_, true)) return;
    keep_alive_timer_.expires_after(keep_alive_interval);
    keep_alive_timer_.async_wait([weak = weak_from_this()](error_code error) {
        const auto self = weak.lock();
        if (error || !self || self->stopped_) return;
        self->keeps_alive_ = false;
        bool any = false;
        for (const auto& [where, link] : self->links_) {
            if (link->state != Link::State::ready) continue;
            link->client.keep_alive();
            any = true;
        }
        if (any) self->keep_alive();
    });
}

// ----------------------------------------------------------------------------------------------------- sockets

/// The wanted port if nobody has it, and any other one then. Not a shared one: the datagrams of two programs would mix.
boost::system::result<std::shared_ptr<Port>> Originator::Impl::port_at(std::uint32_t address) {
    auto& port = ports_[address];
    if (!port) {
        auto fresh = std::make_shared<Port>(executor_);
        auto error = fresh->socket.open({address, options_.io_port}, false);
        if (error == net::error::address_in_use) error = fresh->socket.open({address, 0}, false);
        if (error) {
            ports_.erase(address);
            return error;
        }
        port = std::move(fresh);
        hear(port);
    }
    ++port->users;
    return port;
}

void Originator::Impl::release(const std::shared_ptr<Port>& port) {
    if (--port->users > 0) return;
    port->socket.close();
    port->queue.clear();
    ports_.erase(port->socket.local().address);
}

boost::system::result<std::shared_ptr<Group>> Originator::Impl::group_at(Endpoint endpoint, std::uint32_t local) {
    const auto found = std::ranges::find_if(
        groups_, [&](const auto& group) { return group->endpoint == endpoint && group->local_address == local; });
    if (found != groups_.end()) {
        ++(*found)->users;
        return *found;
    }
    auto group = std::make_shared<Group>(executor_, endpoint, local);
    if (const auto error = group->socket.open(endpoint, true)) return error;
    if (const auto error = group->socket.join(endpoint.address, local)) return error;
    group->users = 1;
    groups_.push_back(group);
    hear(group);
    return group;
}

void Originator::Impl::release(const std::shared_ptr<Group>& group) {
    if (--group->users > 0) return;
    group->socket.close();  // and so leaves the group
    std::erase(groups_, group);
}

template <class Source>
void Originator::Impl::hear(const std::shared_ptr<Source>& source) {
    source->socket.socket().async_wait(net::ip::udp::socket::wait_read,
                                       [weak = weak_from_this(), source](error_code error) {
                                           const auto self = weak.lock();
                                           if (error || !self || self->stopped_) return;
                                           self->drain(source->socket);
                                           if (source->socket.socket().is_open()) self->hear(source);
                                       });
}

void Originator::Impl::drain(IoSocket& socket) {
    for (int i = 0; i < batches_at_once && socket.socket().is_open(); ++i) {
        if (socket.receive(take_) < enip::asio::io_batch) return;
    }
}

void Originator::Impl::drain_all() {
    // By value: what is received may close a connection, and with it a socket.
    std::vector<std::shared_ptr<Port>> ports;
    for (const auto& [address, port] : ports_) ports.push_back(port);
    for (const auto& port : ports) drain(port->socket);
    const auto groups = groups_;
    for (const auto& group : groups) drain(group->socket);
}

void Originator::Impl::on_datagram(const IoSocket::Received& received) {
    if (stopped_) return;
    const auto packet = enip::IoPacket::parse(received.octets);
    if (!packet) {
        ++strays_.malformed;
        return;
    }
    const auto found = expected_.find(packet->connection_id);
    if (found == expected_.end()) {
        ++strays_.unknown_id;
        return;
    }
    const IoArrival arrival{received.peer, received.local, received.octets, *packet, received.time};
    bool taken = false;
    // A session is neither added nor forgotten in here: that waits for an answer from the device.
    const auto& sessions = found->second;
    for (std::size_t i = 0; i < sessions.size() && !stopped_; ++i) {
        taken = sessions[i]->session.on_datagram(arrival) == IoSession::Reception::taken || taken;
    }
    if (!taken) ++strays_.wrong_source;
}

// -------------------------------------------------------------------------------------------------------- time

void Originator::Impl::schedule(Connection& connection, std::optional<Time> when) {
    auto& place = connection.scheduled;
    if (place && when) {  // the node is used again: nothing is allocated
        auto node = schedule_.extract(*place);
        node.value().first = *when;
        place = schedule_.insert(std::move(node)).position;
    } else if (when) {
        place = schedule_.emplace(*when, &connection).first;
    } else if (place) {
        schedule_.erase(*place);
        place.reset();
    }
}

/// A deadline that moved later is noticed when the timer fires; only an earlier one needs a new start.
void Originator::Impl::arm() {
    if (running_ || schedule_.empty()) return;
    const auto next = schedule_.begin()->first;
    if (armed_ && *armed_ <= next) return;
    armed_ = next;
    timer_.expires_at(next);
    timer_.async_wait([weak = weak_from_this()](error_code error) {
        const auto self = weak.lock();
        if (error || !self || self->stopped_) return;
        self->armed_.reset();
        self->running_ = true;
        self->run_due(clock_now());
        self->running_ = false;
        if (self->stopped_) return;
        self->flush();
        self->arm();
    });
}

void Originator::Impl::disarm() {
    timer_.cancel();
    armed_.reset();
}

void Originator::Impl::run_due(Time now) {
    bool drained = false;
    while (!stopped_ && !schedule_.empty() && schedule_.begin()->first <= now) {
        auto& connection = *schedule_.begin()->second;
        if (!drained && connection.session.is_starving(now)) {
            drained = true;  // what has come in time and waits in the kernel counts
            drain_all();
            continue;
        }
        connection.session.on_timer(now, connection.queue());
        if (!stopped_) schedule(connection, connection.session.next_deadline());
    }
}

void Originator::Impl::flush() {
    for (const auto& [address, port] : ports_) {
        if (port->queue.empty()) continue;
        unsent_ += port->socket.send(port->queue).failed;
        port->queue.clear();
    }
}

// ------------------------------------------------------------------------------------------------ the thin edge

Originator::Originator(net::any_io_executor executor, OriginatorOptions options)
    : impl_(std::make_shared<Impl>(std::move(executor), options)) {}

Originator::~Originator() { impl_->shut_down(); }

IoConnection& Originator::add(IoOptions options, IoEvents events) {
    return impl_->add(std::move(options), std::move(events));
}

const StrayCounters& Originator::strays() const { return impl_->strays(); }

std::uint64_t Originator::unsent() const { return impl_->unsent(); }

}  // namespace servobus::scanner
