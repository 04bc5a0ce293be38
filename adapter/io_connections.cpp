#include "adapter/io_connections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "adapter/multicast_groups.hpp"
#include "enip/common_packet.hpp"

namespace servobus::adapter {
namespace {

using assemblies::Connection;
using cip::ConnectionFailure;
using cip::ConnectionType;
using std::chrono::microseconds;

bool is_multicast(const cip::ForwardOpen& request) { return request.t_to_o.type == ConnectionType::multicast; }

// Attribute 4 to 7 of QoS, by the priority of the direction that we send (R-QOS-5).
std::uint8_t dscp_of(const QualityOfService& qos, cip::Priority priority) {
    switch (priority) {
        case cip::Priority::urgent:
            return qos.dscp[0];
        case cip::Priority::scheduled:
            return qos.dscp[1];
        case cip::Priority::high:
            return qos.dscp[2];
        case cip::Priority::low:
            return qos.dscp[3];
    }
    return 0;
}

// The place of a point among those that are produced: that of its group (R-MC-1).
std::size_t place_of(const assemblies::Layout& layout) {
    std::size_t place = 0;
    for (const auto& each : assemblies::layouts()) {
        if (each.direction != assemblies::Direction::t_to_o) continue;
        if (each.instance == layout.instance) break;
        ++place;
    }
    return place;
}

bool is_socket_item(const cip::SideItem& item) {
    return item.type == static_cast<std::uint16_t>(enip::ItemType::sockaddr_o_to_t) ||
           item.type == static_cast<std::uint16_t>(enip::ItemType::sockaddr_t_to_o);
}

cip::SideItem socket_item(enip::ItemType type, enip::Endpoint endpoint) {
    return {static_cast<std::uint16_t>(type),
            enip::SocketAddress{.port = endpoint.port, .address = endpoint.address}.encode()};
}

}  // namespace

std::string describe(const IoConnection& connection) {
    return fmt::format("{} {}/{} of {}", assemblies::name(connection.kind->kind), connection.kind->o_to_t_point,
                       connection.kind->t_to_o_point, enip::address_text(connection.originator.address));
}

IoConnections::IoConnections(DriveIo& drive, const Network& network, ConnectionIds& ids, const Limits& limits,
                             const Log& log)
    : drive_(drive), network_(network), ids_(ids), limits_(limits), log_(log), qos_(network.settings.qos) {}

// ---------------------------------------------------------------------------------------------------------- opening

OpenResult<const IoConnection*> IoConnections::open(const cip::ForwardOpen& request, const IoOpen& wanted,
                                                    const cip::Origin& origin, std::uint16_t number) {
    const auto sockets = check_sockets(origin);
    if (!sockets) return sockets.error();
    if (const auto fine = check_owner(wanted); !fine) return fine.error();
    if (const auto fine = check_listener(request, wanted); !fine) return fine.error();
    if (const auto fine = check_joining(request, wanted); !fine) return fine.error();
    if (const auto fine = check_subnet(request, origin); !fine) return fine.error();
    if (const auto fine = check_room(wanted); !fine) return fine.error();

    auto connection = std::make_unique<IoConnection>();
    connection->number = number;
    connection->kind = wanted.connection;
    connection->request = request;
    connection->o_to_t_id = ids_.next();
    connection->originator = {origin.address, sockets->receive_port};
    const auto interval = microseconds(request.o_to_t_rpi);
    connection->consumer = enip::IoConsumer({.format = wanted.connection->o_to_t_format(),
                                             .size = wanted.connection->o_to_t_size(),
                                             .timeout = enip::connection_timeout(interval, request.timeout_multiplier)},
                                            origin.now);
    connections_.push_back(std::move(connection));
    auto& open = *connections_.back();
    // After the connection has its id, so that the two differ.
    open.production = &produce(request, wanted, origin, *sockets);
    open.t_to_o_id = open.production->producer.settings().connection_id;
    if (open.is_owner()) owner_ = &open;
    faulted_ = false;
    reply_with_sockets(open, *sockets, origin);
    return &open;
}

// R-CPF-9. The addresses in the items do not count: data goes to whoever has the session.
OpenResult<IoConnections::Sockets> IoConnections::check_sockets(const cip::Origin& origin) const {
    Sockets sockets;
    if (origin.items == nullptr) return sockets;
    std::vector<std::uint16_t> seen;
    for (const auto& item : *origin.items) {
        if (!is_socket_item(item)) continue;
        const auto address = enip::SocketAddress::parse(item.data);
        if (!address || address->family != enip::SocketAddress{}.family || address->port == 0 ||
            std::ranges::count(seen, item.type) > 0) {
            return OpenRefusal{ConnectionFailure::unconnected_parameter_error,
                               fmt::format("the sockaddr item 0x{:04X} is not 16 octets with family 2 and a port, or "
                                           "stands twice",
                                           item.type)};
        }
        seen.push_back(item.type);
        sockets.present = true;
        if (item.type == static_cast<std::uint16_t>(enip::ItemType::sockaddr_t_to_o)) {
            sockets.receive_port = address->port;
        }
    }
    return sockets;
}

OpenResult<void> IoConnections::check_owner(const IoOpen& wanted) const {
    if (wanted.connection->kind != Connection::Kind::exclusive_owner || owner_ == nullptr) return {};
    return OpenRefusal{ConnectionFailure::ownership_conflict,
                       fmt::format("{} is open (connection serial {} of vendor {}); who wants to look on asks for O->T "
                                   "{} instead",
                                   describe(*owner_), owner_->request.triad.serial_number,
                                   owner_->request.triad.originator_vendor, assemblies::input_only_point)};
}

OpenResult<void> IoConnections::check_listener(const cip::ForwardOpen& request, const IoOpen& wanted) const {
    if (wanted.connection->kind != Connection::Kind::listen_only) return {};
    const auto refusal = [](std::string words) {
        return OpenRefusal{ConnectionFailure::no_non_listen_only_connection, std::move(words)};
    };
    if (!is_multicast(request))
        return refusal("a listener asks for multicast T->O: it listens to what another has opened");
    const bool heard = std::ranges::any_of(connections_, [&](const auto& each) {
        return !each->is_listener() && each->production->multicast &&
               each->production->layout == wanted.connection->inputs();
    });
    if (heard) return {};
    return refusal(fmt::format("nobody has opened T->O {} by multicast, so there is nothing to listen to",
                               wanted.connection->t_to_o_point));
}

// R-MC-4.
OpenResult<void> IoConnections::check_subnet(const cip::ForwardOpen& request, const cip::Origin& origin) const {
    const auto& own = network_.state.place();
    const bool near = own.mask == 0 || ((origin.address ^ own.address) & own.mask) == 0;
    if (!is_multicast(request) || near || network_.settings.ttl > 1) return {};
    return OpenRefusal{ConnectionFailure::not_configured_for_off_subnet_multicast,
                       fmt::format("{} is in another subnet, where multicast with TTL 1 does not arrive",
                                   enip::address_text(origin.address))};
}

// R-CON-33: who joins takes what is there.
OpenResult<void> IoConnections::check_joining(const cip::ForwardOpen& request, const IoOpen& wanted) const {
    const auto* running = is_multicast(request) ? multicast_of(*wanted.connection->inputs()) : nullptr;
    if (running == nullptr) return {};
    const auto refusal = [](cip::Status status, std::string words) {
        return OpenRefusal{std::move(status), std::move(words)};
    };
    const auto& settings = running->producer.settings();
    const auto interval = static_cast<std::uint32_t>(settings.interval.count());
    if (request.t_to_o_rpi != interval) {
        return refusal(
            cip::RpiRefusal{cip::RpiKind::acceptable, cip::RpiKind::required, request.o_to_t_rpi, interval}.status(),
            fmt::format("T->O {} is already sent by multicast every {} us; {} us asked", running->layout->instance,
                        interval, request.t_to_o_rpi));
    }
    if (request.t_to_o.variable != running->parameters.variable) {
        return refusal(ConnectionFailure::producer_has_other_fixed_variable,
                       "the running multicast has the other fixed or variable flag");
    }
    if (request.t_to_o.priority != running->parameters.priority) {
        return refusal(ConnectionFailure::producer_has_other_priority, "the running multicast has another priority");
    }
    if (request.transport.trigger != running->transport.trigger) {
        return refusal(ConnectionFailure::producer_has_other_trigger, "the running multicast has another trigger");
    }
    if (wanted.inhibit != settings.inhibit) {
        return refusal(
            ConnectionFailure::producer_has_other_inhibit_time,
            fmt::format("the running multicast has a production inhibit time of {} us", settings.inhibit.count()));
    }
    return {};
}

// There is one owner at most, so the others need a limit (R-CON-48).
OpenResult<void> IoConnections::check_room(const IoOpen& wanted) const {
    if (wanted.connection->kind == Connection::Kind::exclusive_owner) return {};
    const auto others = static_cast<std::size_t>(
        std::ranges::count_if(connections_, [](const auto& each) { return !each->is_owner(); }));
    if (others < limits_.listening_connections) return {};
    return OpenRefusal{
        ConnectionFailure::out_of_connections,
        fmt::format("all {} connections of those who look on are in use", limits_.listening_connections)};
}

Production* IoConnections::multicast_of(const assemblies::Layout& layout) const {
    const auto found = std::ranges::find_if(
        productions_, [&](const auto& each) { return each->multicast && each->layout == &layout; });
    return found != productions_.end() ? found->get() : nullptr;
}

namespace {

// The productions of a drive are due together, and those of its neighbours; of a long row of drives some are due a little
// later, so that requests are answered in between.
microseconds phase_of(std::uint32_t address) {
    constexpr std::uint32_t neighbours = 32;
    constexpr auto phases = static_cast<std::uint32_t>(enip::shared_grid / enip::production_grid);
    return (address / neighbours % phases) * enip::production_grid;
}

}  // namespace

Production& IoConnections::produce(const cip::ForwardOpen& request, const IoOpen& wanted, const cip::Origin& origin,
                                   const Sockets& sockets) {
    const auto& layout = *wanted.connection->inputs();
    const bool multicast = is_multicast(request);
    if (multicast) {
        if (auto* running = multicast_of(layout)) return *running;
    }
    const enip::Endpoint peer =
        multicast ? group_of(layout, origin.local_address) : enip::Endpoint{origin.address, sockets.receive_port};
    const auto interval = microseconds(request.t_to_o_rpi);
    enip::IoProducer::Settings settings{.connection_id = multicast ? ids_.next() : request.t_to_o_id,
                                        .format = wanted.connection->t_to_o_format(),
                                        .data_octets = layout.size(),
                                        .interval = interval,
                                        .trigger = wanted.trigger,
                                        .inhibit = wanted.inhibit,
                                        .route = {.local = {origin.local_address, network_.state.io_port},
                                                  .peer = peer,
                                                  .dscp = dscp_of(qos_, request.t_to_o.priority),
                                                  .ttl = multicast ? network_.settings.ttl : std::uint8_t{0}}};
    auto production = std::make_unique<Production>();
    production->layout = &layout;
    production->multicast = multicast;
    production->parameters = request.t_to_o;
    production->transport = request.transport;
    // Not at once, though within an interval (R-CON-50), so that the originator has read the reply when the first comes.
    constexpr microseconds reading_time{1000};
    const bool whole = interval % enip::shared_grid == microseconds(0);
    const auto grid = std::min(interval, whole ? enip::shared_grid : enip::production_grid);
    const auto wait = std::min(reading_time, interval - grid);
    production->producer = enip::IoProducer(
        settings, enip::first_shared_deadline(origin.now + wait, interval, phase_of(origin.local_address)));
    productions_.push_back(std::move(production));
    return *productions_.back();
}

// R-CPF-8: the group is told always; our own port to whoever speaks of ports, and when it is not the usual one.
void IoConnections::reply_with_sockets(const IoConnection& connection, const Sockets& sockets,
                                       const cip::Origin& origin) const {
    if (origin.reply_items == nullptr) return;
    if (sockets.present || network_.state.io_port != enip::io_port) {
        origin.reply_items->push_back(socket_item(enip::ItemType::sockaddr_o_to_t, {0, network_.state.io_port}));
    }
    if (connection.production->multicast) {
        origin.reply_items->push_back(
            socket_item(enip::ItemType::sockaddr_t_to_o, connection.production->producer.settings().route.peer));
    }
}

enip::Endpoint IoConnections::group_of(const assemblies::Layout& layout, std::uint32_t local) const {
    const auto own = network_.state.place().address;
    return {multicast_groups(network_, own != 0 ? own : local).of(place_of(layout)), enip::io_port};
}

std::size_t IoConnections::groups_in_use() const {
    std::size_t groups = 0;
    for (const auto& each : productions_) {
        if (each->multicast) groups = std::max(groups, place_of(*each->layout) + 1);
    }
    return groups;
}

bool IoConnections::uses(std::uint32_t id) const {
    return std::ranges::any_of(connections_, [&](const auto& each) { return each->o_to_t_id == id; }) ||
           std::ranges::any_of(productions_, [&](const auto& each) {
               return each->multicast && each->producer.settings().connection_id == id;
           });
}

// ---------------------------------------------------------------------------------------------------------- closing

void IoConnections::close(const IoConnection& connection) {
    const bool owned = connection.is_owner();
    log_(LogLevel::info, fmt::format("{} closed by its originator", describe(connection)));
    remove(connection);
    if (owned) drive_.lose_controller();
    remove_orphans();
}

void IoConnections::abandon() {
    for (const auto& connection : connections_) {
        log_(LogLevel::warning, fmt::format("{} ends: the device gives its address up", describe(*connection)));
    }
    const bool owned = owner_ != nullptr;
    owner_ = nullptr;
    connections_.clear();
    productions_.clear();
    if (owned) drive_.lose_controller();
}

// The production goes with the last connection that it is for: nothing leaves after this (R-CON-37).
void IoConnections::remove(const IoConnection& connection) {
    if (owner_ == &connection) owner_ = nullptr;
    const auto* production = connection.production;
    std::erase_if(connections_, [&](const auto& each) { return each.get() == &connection; });
    const bool wanted =
        std::ranges::any_of(connections_, [&](const auto& each) { return each->production == production; });
    if (!wanted) std::erase_if(productions_, [&](const auto& each) { return each.get() == production; });
}

// R-CON-32: a listener lives as long as somebody else has the same production.
void IoConnections::remove_orphans() {
    const auto orphan = [&](const std::unique_ptr<IoConnection>& listener) {
        return listener->is_listener() && std::ranges::none_of(connections_, [&](const auto& each) {
                   return !each->is_listener() && each->production == listener->production;
               });
    };
    for (auto found = std::ranges::find_if(connections_, orphan); found != connections_.end();
         found = std::ranges::find_if(connections_, orphan)) {
        log_(LogLevel::info, fmt::format("{} ends: what it listened to has been closed", describe(**found)));
        remove(**found);
    }
}

// ------------------------------------------------------------------------------------------------------------- data

void IoConnections::on_datagram(enip::Endpoint peer, cip::ByteView octets, enip::Time now) {
    const auto packet = enip::IoPacket::parse(octets);
    if (!packet) {
        ++strays_.malformed;
        return;
    }
    const auto found =
        std::ranges::find_if(connections_, [&](const auto& each) { return each->o_to_t_id == packet->connection_id; });
    if (found == connections_.end()) {
        ++strays_.unknown_id;
        return;
    }
    if ((*found)->originator.address != peer.address) {
        ++strays_.wrong_source;
        return;
    }
    take(**found, *packet, now);
}

void IoConnections::take(IoConnection& connection, const enip::IoPacket& packet, enip::Time now) {
    // A datagram does not revive a connection whose time is over; the timer ends it.
    if (connection.consumer.deadline() <= now) {
        ++strays_.too_late;
        return;
    }
    const auto arrival = connection.consumer.take(packet, now);
    using Verdict = enip::IoConsumer::Verdict;
    if (arrival.verdict == Verdict::stale || arrival.verdict == Verdict::wrong_size || !connection.is_owner()) return;
    if (arrival.run_ended) {
        log_(LogLevel::info, fmt::format("{} goes to idle", describe(connection)));
        drive_.lose_controller();
    }
    if (arrival.run_began) log_(LogLevel::info, fmt::format("{} runs", describe(connection)));
    const bool counts = arrival.verdict == Verdict::fresh || arrival.run_began;  // R-IO-6
    if (arrival.run && counts) drive_.apply(*connection.kind->outputs(), arrival.data);
}

void IoConnections::on_timer(enip::Time now, enip::IoQueue& queue, std::uint16_t& timed_out) {
    for (const auto& production : productions_) {
        while (production->producer.deadline() <= now) {
            production->producer.produce(drive_.inputs(*production->layout, now), true, now, queue);
        }
    }
    const auto over = [&](const std::unique_ptr<IoConnection>& each) { return each->consumer.deadline() <= now; };
    for (auto found = std::ranges::find_if(connections_, over); found != connections_.end();
         found = std::ranges::find_if(connections_, over)) {
        const auto& connection = **found;
        log_(LogLevel::warning,
             fmt::format("{} timed out: no datagram for {} ms{}", describe(connection),
                         (connection.consumer.alive() ? connection.consumer.settings().timeout
                                                      : std::max<microseconds>(connection.consumer.settings().timeout,
                                                                               enip::first_packet_patience))
                                 .count() /
                             1000,
                         connection.consumer.alive() ? "" : "; none has ever come"));
        ++timed_out;
        faulted_ = true;
        const bool owned = connection.is_owner();
        remove(connection);
        if (owned) drive_.lose_controller();
        remove_orphans();
    }
}

void IoConnections::note_changes(enip::Time now) {
    for (const auto& production : productions_) {
        if (production->producer.settings().trigger == enip::Trigger::cyclic) continue;
        production->producer.note(drive_.inputs(*production->layout, now), now);
    }
}

bool IoConnections::tells_at_deadlines() const {
    return !productions_.empty() && std::ranges::all_of(productions_, [](const auto& each) {
        return each->producer.settings().trigger == enip::Trigger::cyclic;
    });
}

std::optional<enip::Time> IoConnections::next_deadline() const {
    std::optional<enip::Time> next;
    const auto take_earlier = [&](enip::Time time) {
        if (!next || time < *next) next = time;
    };
    for (const auto& production : productions_) take_earlier(production->producer.deadline());
    for (const auto& connection : connections_) take_earlier(connection->consumer.deadline());
    return next;
}

const IoConnection* IoConnections::find(const cip::ConnectionTriad& triad) const {
    const auto found =
        std::ranges::find_if(connections_, [&](const auto& each) { return each->request.triad == triad; });
    return found != connections_.end() ? found->get() : nullptr;
}

const IoConnection* IoConnections::find(std::uint16_t number) const {
    const auto found = std::ranges::find_if(connections_, [&](const auto& each) { return each->number == number; });
    return found != connections_.end() ? found->get() : nullptr;
}

// By priority: one that runs, one that is lost, all idle, none.
IoCondition IoConnections::condition() const {
    if (owner_ != nullptr && owner_->consumer.run()) return IoCondition::running;
    if (faulted_) return IoCondition::timed_out;
    return connections_.empty() ? IoCondition::none : IoCondition::idle;
}

}  // namespace servobus::adapter
