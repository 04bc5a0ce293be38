#include "tests/sim/node_site.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "enip/io_packet.hpp"
#include "tests/sim/explicit_requests.hpp"

namespace servobus::sim {
namespace {

using namespace std::chrono_literals;
using scanner::Error;
using scanner::error_code;
using scanner::IoState;

constexpr auto patience = 5s;
/// As scanner::Originator.
constexpr auto keep_alive_interval = 30s;
/// A client whose TCP connection has ended tries again after this.
constexpr auto client_pause = 1s;

scanner::IoOptions options_of(const ConnectionSpec& spec) {
    scanner::IoOptions options;
    options.timeout = patience;
    options.plan = scanner::plan_of(*assemblies::find_connection(spec.o_to_t_point, spec.t_to_o_point));
    auto& plan = options.plan;
    plan.o_to_t.rpi = spec.o_to_t_rpi;
    plan.t_to_o.rpi = spec.t_to_o_rpi;
    if (spec.multicast) plan.t_to_o.type = cip::ConnectionType::multicast;
    plan.multiplier_code = static_cast<std::uint8_t>(spec.multiplier);
    plan.trigger = static_cast<enip::Trigger>(spec.trigger);
    plan.inhibit = spec.inhibit;
    plan.large = spec.large;
    plan.redundant_owner = spec.redundant;
    return options;
}

/// The TCP connection to a drive that all I/O connections of a node share.
struct Link {
    std::unique_ptr<SessionClient> client;
    bool connecting = false;
    std::vector<std::pair<unsigned, std::uint64_t>> waiting;  ///< connections and their tickets
};

}  // namespace

/// An I/O session and what it has of its node.
class NodeSite::Connection final : private scanner::IoSession::Surroundings {
public:
    Connection(unsigned number, NodeSite& node, scanner::IoNumbers& numbers)
        : number_(number),
          node_(node),
          spec_(node.scenario_.connections[number]),
          watch(number, node.judge_),
          program(*assemblies::find_connection(spec_.o_to_t_point, spec_.t_to_o_point),
                  node.scenario_.drives[spec_.drive].jog, node.random_.next()),
          session(options_of(spec_), events(), numbers, *this) {}

    [[nodiscard]] unsigned number() const { return number_; }
    [[nodiscard]] unsigned drive() const { return spec_.drive; }
    [[nodiscard]] bool needs_link() const {
        return session.state() != IoState::idle && session.state() != IoState::closed;
    }
    [[nodiscard]] bool listens() const { return listens_; }

private:
    unsigned number_;
    NodeSite& node_;
    const ConnectionSpec& spec_;
    bool listens_ = false;
    std::optional<std::uint32_t> group_{};

public:
    OriginatorWatch watch;
    MotionProgram program;
    scanner::IoSession session;  ///< last: it uses all of the above
    enip::IoQueue queue;

private:
    scanner::IoEvents events();
    void connect(std::uint64_t ticket) override;
    [[nodiscard]] bool connected() const override;
    void request(std::uint64_t ticket, const cip::Request& request, std::vector<enip::Item> items) override;
    [[nodiscard]] boost::system::result<enip::Endpoint> listen(std::uint32_t local_address) override {
        listens_ = true;
        return enip::Endpoint{local_address, enip::io_port};
    }
    [[nodiscard]] error_code join(enip::Endpoint group, std::uint32_t local_address) override;
    void stop_listening() override;
    void expect(std::uint32_t id) override;
    void forget(std::uint32_t id) override;
    [[nodiscard]] bool is_taken(std::uint32_t id) const override;
    void changed() override {}  // the node looks after each event
};

/// Somebody with explicit requests.
class NodeSite::Client {
public:
    Client(unsigned number, NodeSite& node)
        : node_(node),
          spec_(node.scenario_.clients[number]),
          random_(node.random_.next()),
          session(node.number_, spec_.drive, static_cast<std::uint32_t>(random_.next()), node.surroundings()) {
        connect();
    }

private:
    void connect();
    void begin();
    void ask();
    void ask_one(unsigned burst);
    void later(Time::duration pause, void (Client::*what)());

    NodeSite& node_;
    const ClientSpec& spec_;
    Random random_;
    std::shared_ptr<char> alive_ = std::make_shared<char>();
    unsigned open_ = 0;  ///< answers that are missing

public:
    SessionClient session;
};

/// Everything that goes with the program.
struct NodeSite::Process {
    Process(unsigned node, std::uint64_t seed) : numbers(static_cast<std::uint16_t>(0x0100 + node), seed) {}
    scanner::IoNumbers numbers;
    std::map<unsigned, Link> links;  ///< by drive
    std::map<std::uint32_t, std::vector<Connection*>> expected;
    std::map<unsigned, std::unique_ptr<Connection>> connections;
    std::map<unsigned, std::unique_ptr<Client>> clients;
};

// --------------------------------------------------------------------------------------------------- connections

scanner::IoEvents NodeSite::Connection::events() {
    scanner::IoEvents events;
    events.opened = [this](const scanner::IoOpened& opened) {
        watch.opened(opened, session.options().plan, node_.queue_.now());
    };
    events.input = [this](const scanner::IoInput& input) {
        watch.input(input, node_.queue_.now());
        program.input(input.data);
    };
    events.output = [this](std::span<std::uint8_t> data) { return program.output(data); };
    events.closed = [this](const scanner::IoClosed& closed) { watch.closed(closed, node_.queue_.now()); };
    return events;
}

void NodeSite::Connection::connect(std::uint64_t ticket) {
    auto& link = node_.process_->links[spec_.drive];
    if (!link.client) {
        link.client = std::make_unique<SessionClient>(
            node_.number_, spec_.drive, static_cast<std::uint32_t>(node_.random_.next()), node_.surroundings());
    }
    link.waiting.emplace_back(number_, ticket);
    if (link.connecting) return;
    const auto tell = [node = &node_, drive = spec_.drive](error_code error) {
        auto& to = node->process_->links[drive];
        to.connecting = false;
        const auto ends = to.client->ends();
        for (const auto& [number, waiting] : std::exchange(to.waiting, {})) {
            auto* connection = node->connection(number);
            if (connection == nullptr) continue;
            connection->session.on_connected(waiting,
                                             error  ? error
                                             : ends ? error_code{}
                                                    : scanner::make_error_code(Error::not_connected),
                                             ends.value_or(scanner::TcpEnds{}), node->queue_.now());
        }
    };
    link.connecting = true;
    if (link.client->is_ready()) {
        node_.post([tell] { tell({}); });
    } else {
        // Later, since whoever asks may be in the middle of hearing that the last one has ended.
        node_.post([node = &node_, drive = spec_.drive, tell] {
            node->process_->links[drive].client->connect(patience, tell);
        });
    }
}

bool NodeSite::Connection::connected() const {
    const auto& links = node_.process_->links;
    const auto found = links.find(spec_.drive);
    return found != links.end() && found->second.client && found->second.client->is_ready();
}

void NodeSite::Connection::request(std::uint64_t ticket, const cip::Request& request, std::vector<enip::Item> items) {
    auto& client = *node_.process_->links[spec_.drive].client;
    auto done = [node = &node_, number = number_, ticket, &client](error_code error,
                                                                   const scanner::Exchange& exchange) {
        // A device that does not answer may have forgotten the TCP connection.
        if (error == Error::timeout && client.is_ready()) client.abandon(false);
        if (auto* connection = node->connection(number)) {
            connection->session.on_reply(ticket, error, exchange, node->queue_.now());
        }
    };
    if (client.is_ready()) {
        client.exchange(request, std::move(items), patience, std::move(done));
    } else {
        node_.post([done = std::move(done)] { done(scanner::make_error_code(Error::not_connected), {}); });
    }
}

error_code NodeSite::Connection::join(enip::Endpoint group, std::uint32_t) {
    group_ = group.address;
    node_.neighbourhood_.join(group.address, node_.number_);
    return {};
}

void NodeSite::Connection::stop_listening() {
    listens_ = false;
    const auto group = std::exchange(group_, std::nullopt);
    if (!group) return;
    const auto uses = [&](const auto& entry) { return entry.second->group_ == group; };
    if (std::ranges::none_of(node_.process_->connections, uses)) node_.neighbourhood_.leave(*group, node_.number_);
}

void NodeSite::Connection::expect(std::uint32_t id) { node_.process_->expected[id].push_back(this); }

void NodeSite::Connection::forget(std::uint32_t id) {
    auto& expected = node_.process_->expected;
    const auto found = expected.find(id);
    if (found == expected.end()) return;
    std::erase(found->second, this);
    if (found->second.empty()) expected.erase(found);
}

bool NodeSite::Connection::is_taken(std::uint32_t id) const {
    const auto& expected = node_.process_->expected;
    const auto found = expected.find(id);
    if (found == expected.end()) return false;
    return std::ranges::any_of(found->second, [&](const Connection* other) {
        if (other == this || other->drive() != drive()) return false;
        return !session.is_multicast() || !other->session.is_multicast();
    });
}

// ------------------------------------------------------------------------------------------------------- clients

void NodeSite::Client::later(Time::duration pause, void (Client::*what)()) {
    node_.queue_.after(pause, [this, node = &node_, alive = std::weak_ptr(alive_), what] {
        if (alive.expired()) return;
        node->whenever_it_runs([this, alive, what] {
            if (!alive.expired()) (this->*what)();
        });
    });
}

void NodeSite::Client::connect() {
    session.connect(patience, [this](error_code error) {
        if (error) {
            later(client_pause, &Client::connect);
        } else {
            begin();
        }
    });
}

void NodeSite::Client::begin() {
    if (!spec_.class3) {
        ask();
        return;
    }
    session.open_class3(patience, [this](error_code error, const scanner::Exchange&) {
        later(error ? Time::duration(client_pause) : Time::duration(spec_.pause),
              error ? &Client::connect : &Client::ask);
    });
}

void NodeSite::Client::ask() {
    open_ = session.has_class3() ? 1 : spec_.burst;
    const auto count = open_;
    for (unsigned i = 0; i < count; ++i) ask_one(i);
}

void NodeSite::Client::ask_one(unsigned) {
    const auto& request = random_.of(explicit_requests());
    const auto done = [this, &request](error_code error, const scanner::Exchange& exchange) {
        if (!error && !fits(request, exchange.response)) {
            node_.judge_.report(
                Invariant::reply_is_asked_for, node_.queue_.now(),
                fmt::format("\"{}\" is answered with status 0x{:02X} and {} octets", request.what,
                            static_cast<unsigned>(exchange.response.status.general), exchange.response.data.size()));
        }
        if (--open_ > 0) return;
        // Of a class 3 connection nobody knows after a timeout whether it is still there.
        const bool again = !session.is_ready() || (error && session.has_class3());
        later(again ? Time::duration(client_pause) : Time::duration(spec_.pause),
              again ? &Client::connect : &Client::ask);
    };
    if (session.has_class3()) {
        session.exchange_connected(request_of(request), patience, done);
    } else {
        session.exchange(request_of(request), {}, patience, done);
    }
}

// ---------------------------------------------------------------------------------------------------------- node

NodeSite::NodeSite(unsigned number, const Scenario& scenario, EventQueue& queue, Wire& wire,
                   Neighbourhood& neighbourhood, Judge& judge)
    : number_(number),
      scenario_(scenario),
      random_(scenario.seed, 200 + number),
      queue_(queue),
      wire_(wire),
      neighbourhood_(neighbourhood),
      judge_(judge) {
    start();
}

NodeSite::~NodeSite() { process_.reset(); }

void NodeSite::start() {
    powered_ = true;
    process_ = std::make_unique<Process>(number_, random_.next());
    for (unsigned i = 0; i < scenario_.connections.size(); ++i) {
        if (scenario_.connections[i].node != number_) continue;
        auto& made = *process_->connections.emplace(i, nullptr).first;
        made.second = std::make_unique<Connection>(i, *this, process_->numbers);
        made.second->program.run(wanted_runs_.contains(i) ? wanted_runs_[i] : true);
        if (wanted_goals_.contains(i)) made.second->program.want(wanted_goals_[i]);
        if (wanted_connections_[i]) made.second->session.open(queue_.now());
    }
    for (const auto& [client, wanted] : wanted_clients_) {
        if (wanted) process_->clients[client] = std::make_unique<Client>(client, *this);
    }
    after_event();
    keep_alive();
}

void NodeSite::keep_alive() {
    queue_.after(keep_alive_interval, [this, life = life_] {
        if (life != life_ || !process_) return;
        whenever_it_runs([this] {
            for (auto& [drive, link] : process_->links) {
                if (link.client) link.client->keep_alive();
            }
        });
        keep_alive();
    });
}

SessionClient::Surroundings NodeSite::surroundings() {
    return {queue_, wire_, judge_,
            [this](StreamId id, SessionClient* client) {
                if (client != nullptr) {
                    streams_[id] = client;
                } else {
                    streams_.erase(id);
                }
            },
            [this](std::function<void()> what) {
                whenever_it_runs([this, what = std::move(what)] {
                    what();
                    after_event();
                });
            }};
}

NodeSite::Connection* NodeSite::connection(unsigned number) {
    if (!process_) return nullptr;
    const auto found = process_->connections.find(number);
    return found != process_->connections.end() ? found->second.get() : nullptr;
}

void NodeSite::open(unsigned number) {
    wanted_connections_[number] = true;
    whenever_it_runs([this, number] {
        connection(number)->session.open(queue_.now());
        after_event();
    });
}

void NodeSite::close(unsigned number) {
    wanted_connections_[number] = false;
    whenever_it_runs([this, number] {
        auto& closing = *connection(number);
        if (closing.session.state() == IoState::open) closing.watch.left();
        closing.session.close(queue_.now());
        after_event();
    });
}

void NodeSite::run(unsigned number, bool run) {
    wanted_runs_[number] = run;
    if (auto* found = connection(number)) found->program.run(run);
}

void NodeSite::want(unsigned number, MotionProgram::Goal goal) {
    wanted_goals_[number] = goal;
    if (auto* found = connection(number)) found->program.want(goal);
}

void NodeSite::start_client(unsigned number) {
    wanted_clients_[number] = true;
    whenever_it_runs([this, number] {
        auto& client = process_->clients[number];
        if (!client) client = std::make_unique<Client>(number, *this);
    });
}

void NodeSite::stop_client(unsigned number, bool silent) {
    wanted_clients_[number] = false;
    whenever_it_runs([this, number, silent] {
        const auto found = process_->clients.find(number);
        if (found == process_->clients.end()) return;
        auto client = std::move(found->second);
        process_->clients.erase(found);
        if (silent) {
            client->session.abandon(true);
        } else {
            client->session.close();
        }
        SessionClient::add(past_.requests, client->session.counters());
    });
}

/// R-ENC-14: everybody answers within half a second, which is the shortest that can be asked for.
void NodeSite::discover() {
    whenever_it_runs([this] {
        const enip::Frame request{.command = enip::Command::list_identity, .context = {0x01, 0x00}};
        const auto octets = request.encode();
        for (unsigned drive = 0; drive < scenario_.drives.size(); ++drive) {
            wire_.send(number_, drive, End::drive, {Neighbourhood::node_address(number_), 40'000},
                       {0xFFFFFFFF, enip::tcp_port}, octets);
        }
    });
}

void NodeSite::crash(microseconds duration, bool silent) {
    if (!process_) return;
    const auto life = ++life_;  // what it wanted to do later does not happen
    for (auto& [number, client] : process_->clients) client->session.abandon(silent);
    for (auto& [drive, link] : process_->links) {
        if (link.client) link.client->abandon(silent);
    }
    past_ = counters();
    streams_.clear();
    neighbourhood_.leave_all(number_);
    process_.reset();
    kernel_io_.clear();
    kernel_rest_.clear();
    held_up_ = false;
    armed_.reset();
    powered_ = !silent;
    queue_.after(duration, [this, life] {
        if (life == life_) start();
    });
}

void NodeSite::hold_up(microseconds duration) {
    if (!process_) return;
    held_until_ = std::max(held_until_, queue_.now() + duration);
    held_up_ = true;
    queue_.at(held_until_, [this, life = life_] {
        if (life == life_ && held_up_ && held_until_ <= queue_.now()) wake();
    });
}

// ------------------------------------------------------------------------------------------------ what arrives

void NodeSite::post(std::function<void()> what) {
    queue_.after({}, [this, life = life_, what = std::move(what)] {
        if (life != life_) return;
        whenever_it_runs([this, what] {
            what();
            after_event();
        });
    });
}

void NodeSite::whenever_it_runs(std::function<void()> what) {
    if (!process_) return;
    if (held_up_) {
        kernel_rest_.push_back(std::move(what));
    } else {
        what();
    }
}

/// Sockets and timers in whichever order: the reactor promises none.
void NodeSite::wake() {
    held_up_ = false;
    for (const auto& [number, each] : process_->connections) each->watch.was_held_up(queue_.now());
    if (random_.chance(0.5)) take_kernel_io();
    after_event();
    take_kernel_io();
    after_event();
    const auto life = life_;
    while (!kernel_rest_.empty() && life == life_ && !held_up_) {
        const auto next = std::move(kernel_rest_.front());
        kernel_rest_.pop_front();
        next();
    }
}

void NodeSite::on_packet(const Packet& packet) {
    if (!process_) return;
    if (packet.destination.port != enip::io_port) {
        ++past_.discovered;
        return;
    }
    if (held_up_) {
        kernel_io_.emplace_back(queue_.now(), packet);
        return;
    }
    take_io(packet, queue_.now());
    after_event();
}

void NodeSite::take_kernel_io() {
    while (!kernel_io_.empty()) {
        const auto [came, packet] = std::move(kernel_io_.front());
        kernel_io_.pop_front();
        take_io(packet, came);
    }
}

/// As scanner::Originator finds whom a datagram is for.
void NodeSite::take_io(const Packet& received, Time came) {
    const auto packet = enip::IoPacket::parse(received.octets);
    if (!packet) return;
    const auto found = process_->expected.find(packet->connection_id);
    if (found == process_->expected.end()) return;
    const scanner::IoArrival arrival{received.source, received.destination, received.octets, *packet, came};
    const auto& sessions = found->second;
    for (std::size_t i = 0; i < sessions.size(); ++i) {
        auto& connection = *sessions[i];
        connection.watch.before(arrival);
        static_cast<void>(connection.session.on_datagram(arrival));
        connection.watch.after(queue_.now());
        connection.session.trigger(queue_.now());
    }
}

void NodeSite::on_connected(StreamId id, bool stands) {
    whenever_it_runs([this, id, stands] {
        if (const auto found = streams_.find(id); found != streams_.end()) found->second->on_connected(stands);
        after_event();
    });
}

void NodeSite::on_octets(StreamId id, cip::ByteView octets) {
    if (!process_) return;
    whenever_it_runs([this, id, kept = cip::Bytes(octets.begin(), octets.end())] {
        if (const auto found = streams_.find(id); found != streams_.end()) found->second->on_octets(kept);
        after_event();
    });
}

void NodeSite::on_end(StreamId id) {
    whenever_it_runs([this, id] {
        if (const auto found = streams_.find(id); found != streams_.end()) found->second->on_end();
        after_event();
    });
}

// ------------------------------------------------------------------------------------------------ what is due

void NodeSite::run_due() {
    const auto now = queue_.now();
    bool drained = false;
    while (true) {
        Connection* first = nullptr;
        Time when = Time::max();
        for (const auto& [number, each] : process_->connections) {
            const auto next = each->session.next_deadline();
            if (next && *next <= now && *next < when) {
                first = each.get();
                when = *next;
            }
        }
        if (first == nullptr) return;
        if (!drained && first->session.is_starving(now)) {
            drained = true;  // what has come in time and waits in the kernel counts
            take_kernel_io();
            continue;
        }
        first->session.on_timer(now, first->queue);
        for (const auto& entry : first->queue.entries()) {
            const auto octets = std::as_const(first->queue).octets(entry);
            first->watch.sends(octets, now);
            wire_.send(number_, first->drive(), End::drive, {entry.route.local.address, entry.route.local.port},
                       entry.route.peer, octets);
        }
        first->queue.clear();
        if (first->session.next_deadline() == when && first->session.state() == IoState::open) {
            judge_.report(Invariant::time_goes_on, now,
                          fmt::format("connection {}: a deadline stays", first->number()));
        }
    }
}

void NodeSite::after_event() {
    if (!process_) return;
    run_due();
    for (const auto& [number, each] : process_->connections) each->watch.settle(queue_.now());
    // A TCP connection that no session needs any more is closed.
    for (auto& [drive, link] : process_->links) {
        const auto needs = [drive = drive](const auto& entry) {
            return entry.second->drive() == drive && entry.second->needs_link();
        };
        if (link.client && link.client->is_ready() && !link.connecting &&
            std::ranges::none_of(process_->connections, needs)) {
            link.client->close();
        }
    }
    arm();
}

void NodeSite::arm() {
    std::optional<Time> next;
    for (const auto& [number, each] : process_->connections) {
        const auto its = each->session.next_deadline();
        if (its && (!next || *its < *next)) next = its;
    }
    if (!next || (armed_ && *armed_ <= *next && *armed_ > queue_.now())) return;
    armed_ = next;
    queue_.at(*next, [this, when = *next, life = life_] {
        if (life != life_ || !process_ || armed_ != when) return;
        armed_.reset();
        if (!held_up_) after_event();
    });
}

// --------------------------------------------------------------------------------------------------- the end

NodeSite::Counters NodeSite::counters() const {
    auto sum = past_;
    if (!process_) return sum;
    for (const auto& [number, each] : process_->connections) {
        const auto& more = each->watch.counters();
        sum.io.opened += more.opened;
        sum.io.timed_out += more.timed_out;
        sum.io.inputs += more.inputs;
        sum.io.dropped += more.dropped;
    }
    for (const auto& [number, each] : process_->clients) SessionClient::add(sum.requests, each->session.counters());
    for (const auto& [drive, link] : process_->links) {
        if (link.client) SessionClient::add(sum.requests, link.client->counters());
    }
    return sum;
}

void NodeSite::expect_nothing() {
    if (!process_) return;
    const auto none = [&](std::size_t count, const char* what) {
        if (count == 0) return;
        judge_.report(Invariant::nothing_left_behind, queue_.now(),
                      fmt::format("node {}: {} {}", number_, count, what));
    };
    none(process_->expected.size(), "expected ids");
    none(streams_.size(), "TCP connections");
    none(process_->clients.size(), "clients");
    for (const auto& [number, each] : process_->connections) {
        if (each->needs_link() || each->session.next_deadline()) none(1, "connections that are not closed");
        if (each->listens()) none(1, "ports that somebody listens at");
    }
    for (const auto& [drive, link] : process_->links) {
        if (!link.client) continue;
        none(link.client->outstanding() + link.waiting.size(), "requests");
        if (link.client->is_ready()) none(1, "sessions");
    }
}

}  // namespace servobus::sim
