#include "scanner/capture.hpp"

#include <algorithm>

#include "cip/unconnected_send.hpp"
#include "cip/wire.hpp"

namespace servobus::scanner {
namespace {

constexpr std::uint32_t identity_class = 0x01;
constexpr std::uint32_t connection_manager_class = 0x06;
constexpr std::uint8_t get_attributes_all = 0x01;
constexpr std::uint8_t forward_close = 0x4E;
constexpr std::uint8_t unconnected_send = 0x52;
constexpr std::uint8_t forward_open = 0x54;
constexpr std::uint8_t large_forward_open = 0x5B;

/// Bits of a run/idle header that mean something: run, COO, ROO (R-IO-1).
constexpr std::uint32_t header_bits = 0x0F;

std::optional<std::uint32_t> class_of(const cip::Path& path) {
    for (const auto& segment : path.segments) {
        const auto* logical = std::get_if<cip::LogicalSegment>(&segment);
        if (logical != nullptr && logical->type == cip::LogicalType::class_id) return logical->value;
    }
    return std::nullopt;
}

std::optional<enip::SocketAddress> socket_address(const enip::CommonPacket& packet, enip::ItemType type) {
    const auto* item = packet.find(type);
    if (item == nullptr) return std::nullopt;
    const auto address = enip::SocketAddress::parse(item->data);
    if (!address) return std::nullopt;
    return *address;
}

/// An item with address 0.0.0.0 names the port alone (R-CPF-8).
enip::Endpoint endpoint_of(const std::optional<enip::SocketAddress>& item, std::uint32_t address) {
    enip::Endpoint endpoint{address, enip::io_port};
    if (!item) return endpoint;
    if (item->address != 0) endpoint.address = item->address;
    if (item->port != 0) endpoint.port = item->port;
    return endpoint;
}

}  // namespace

void CapturedFlow::take(const enip::IoPacket& packet, enip::Endpoint destination, CaptureTime time, bool counted) {
    if (packets == 0) first = time;
    last = std::max(last, time);
    ++packets;
    statistics.take(packet.sequence, enip::Time(time.time_since_epoch()));

    if (sizes.size() < max_sizes || sizes.contains(packet.data.size())) {
        ++sizes[packet.data.size()];
    } else {
        ++sizes.rbegin()->second;
    }
    if (destinations.size() < max_destinations || destinations.contains(destination)) ++destinations[destination];

    cip::Reader reader(packet.data);
    if (counted) {
        const auto count = reader.u16();
        if (reader.ok() && count_ == count) ++repeated;
        if (reader.ok()) count_ = count;
    }
    const auto header = reader.u32();
    if (!reader.ok()) return;
    auto& kind = (header & ~header_bits) != 0 ? header_odd : (header & 1) != 0 ? header_run : header_idle;
    ++kind;
}

enip::Endpoint CapturedOpen::expected_receiver() const {
    if (given_receiver && enip::is_multicast(given_receiver->address)) return endpoint_of(given_receiver, 0);
    return endpoint_of(wanted_receiver, originator.address);
}

void Conversation::take(const CapturedPacket& packet) {
    if (packet.transport == CapturedPacket::Transport::tcp) {
        take_tcp(packet);
    } else {
        take_udp(packet);
    }
}

void Conversation::finish() {
    for (auto& [ends, connection] : connections_) {
        auto& known = connection;
        known.requests.finish(
            [&](const enip::Frame& frame, CaptureTime time) { read_frame(known, true, frame, time); });
        known.replies.finish(
            [&](const enip::Frame& frame, CaptureTime time) { read_frame(known, false, frame, time); });
    }
}

const Identity* Conversation::identity(std::uint32_t address) const {
    const auto found = identities_.find(address);
    return found != identities_.end() ? &found->second : nullptr;
}

TcpStream::Counters Conversation::tcp() const {
    TcpStream::Counters sum;
    const auto add = [&](const TcpStream::Counters& counters) {
        sum.repeated += counters.repeated;
        sum.reordered += counters.reordered;
        sum.gaps += counters.gaps;
        sum.skipped += counters.skipped;
    };
    for (const auto& [ends, connection] : connections_) {
        add(connection.requests.counters());
        add(connection.replies.counters());
    }
    return sum;
}

void Conversation::take_tcp(const CapturedPacket& packet) {
    auto* connection = connection_of(packet);
    if (connection == nullptr) return;
    const bool request = packet.source == connection->client;
    auto& stream = request ? connection->requests : connection->replies;
    if (packet.syn && request) connection->pending.clear();
    stream.take(packet,
                [&](const enip::Frame& frame, CaptureTime time) { read_frame(*connection, request, frame, time); });
}

Conversation::Connection* Conversation::connection_of(const CapturedPacket& packet) {
    const bool to_server = packet.destination.port == enip::tcp_port;
    if (!to_server && packet.source.port != enip::tcp_port) return nullptr;
    const auto client = to_server ? packet.source : packet.destination;
    const auto server = to_server ? packet.destination : packet.source;
    if (const auto found = connections_.find({client, server}); found != connections_.end()) return &found->second;
    if (connections_.size() >= max_streams) {
        ++counters_.streams_left_out;
        return nullptr;
    }
    auto& connection = connections_[{client, server}];
    connection.client = client;
    connection.server = server;
    return &connection;
}

void Conversation::take_udp(const CapturedPacket& packet) {
    if (packet.source.port == enip::tcp_port || packet.destination.port == enip::tcp_port) {
        if (const auto frame = enip::Frame::parse(packet.payload)) read_identities(*frame, packet.source.address);
        return;
    }
    const auto io = enip::IoPacket::parse(packet.payload);
    const bool usual_port = packet.destination.port == enip::io_port;
    if (!io) {
        if (usual_port) ++counters_.io_malformed;
        return;
    }
    if (!read_io(packet, *io) && usual_port) ++counters_.io_without_open;
}

void Conversation::read_frame(Connection& connection, bool request, const enip::Frame& frame, CaptureTime time) {
    if (!request) read_identities(frame, connection.server.address);
    const bool connected = frame.command == enip::Command::send_unit_data;
    if (!connected && frame.command != enip::Command::send_rr_data) return;
    const auto data = enip::SendData::parse(frame.data);
    if (!data) {
        if (request || connected) return;
        // A refusal of the encapsulation layer has no data.
        const enip::SendData none;
        const Envelope envelope{frame, none, false, 0, time};
        if (frame.status != enip::EncapsulationStatus::success) read_reply(connection, envelope, {});
        return;
    }
    if (connected) {
        const auto message = enip::connected_message(*data);
        if (!message) return;
        const Envelope envelope{frame, *data, true, message->sequence, time};
        request ? read_request(connection, envelope, message->message, {})
                : read_reply(connection, envelope, message->message);
        return;
    }
    const auto message = enip::unconnected_message(*data);
    if (!message) return;
    const Envelope envelope{frame, *data, false, 0, time};
    request ? read_request(connection, envelope, *message, {}) : read_reply(connection, envelope, *message);
}

void Conversation::read_request(Connection& connection, const Envelope& envelope, cip::ByteView message,
                                cip::ByteView route) {
    const auto request = cip::Request::parse(message);
    if (!request) return;
    const auto class_id = class_of(request->path);
    if (class_id == identity_class && request->service == get_attributes_all && route.empty()) {
        expect(connection, Asked::identity, envelope, 0);
    }
    if (class_id != connection_manager_class) return;
    if (request->service == forward_open || request->service == large_forward_open) {
        asked_open(connection, envelope, *request, route);
    } else if (request->service == forward_close) {
        asked_close(connection, envelope, *request);
    } else if (request->service == unconnected_send && route.empty()) {
        // One inside another would be a route that nobody writes.
        const auto inner = cip::UnconnectedSend::parse(request->data);
        if (inner && !inner->route_path.empty()) read_request(connection, envelope, inner->message, inner->route_path);
    }
}

void Conversation::asked_open(Connection& connection, const Envelope& envelope, const cip::Request& request,
                              cip::ByteView route) {
    if (opens_.size() >= max_opens) {
        ++counters_.opens_left_out;
        return;
    }
    CapturedOpen open;
    open.originator = connection.client;
    open.target = connection.server;
    open.asked = envelope.time;
    open.route.assign(route.begin(), route.end());
    open.large = request.service == large_forward_open;
    if (const auto parsed = cip::ForwardOpen::parse(request.data, open.large)) open.request = *parsed;
    open.wanted_receiver = socket_address(envelope.data.packet, enip::ItemType::sockaddr_t_to_o);
    opens_.push_back(std::move(open));
    expect(connection, Asked::open, envelope, opens_.size() - 1);
}

void Conversation::asked_close(Connection& connection, const Envelope& envelope, const cip::Request& request) {
    const auto close = cip::ForwardClose::parse(request.data);
    if (!close) return;
    for (auto index = opens_.size(); index-- > 0;) {
        auto& open = opens_[index];
        if (!open.granted() || open.closing || open.target.address != connection.server.address) continue;
        if (open.request->triad != close->triad) continue;
        open.closing = envelope.time;
        expect(connection, Asked::close, envelope, index);
        return;
    }
}

void Conversation::expect(Connection& connection, Asked what, const Envelope& envelope, std::size_t open) {
    if (connection.pending.size() >= max_pending) connection.pending.pop_front();
    connection.pending.push_back(
        {what, envelope.connected, envelope.frame.session, envelope.frame.context, envelope.sequence, open});
}

std::optional<Conversation::Pending> Conversation::expected(Connection& connection, const Envelope& envelope) {
    // Requests with the same context are answered in their order.
    const auto found = std::ranges::find_if(connection.pending, [&](const Pending& each) {
        if (each.connected != envelope.connected) return false;
        if (each.connected) return each.sequence == envelope.sequence;
        return each.session == envelope.frame.session && each.context == envelope.frame.context;
    });
    if (found == connection.pending.end()) return std::nullopt;
    const auto pending = *found;
    connection.pending.erase(found);
    return pending;
}

void Conversation::read_reply(Connection& connection, const Envelope& envelope, cip::ByteView message) {
    const auto response = cip::Response::parse(message);
    const bool refused = envelope.frame.status != enip::EncapsulationStatus::success;
    if (!response && !refused) return;
    using Services = std::vector<std::uint8_t>;
    // A router answers an Unconnected_Send itself when it cannot pass it on.
    const auto fits = [&](const Services& services) {
        return refused || std::ranges::find(services, response->service) != services.end();
    };
    if (!fits({get_attributes_all, forward_close, unconnected_send, forward_open, large_forward_open})) return;
    const auto pending = expected(connection, envelope);
    if (!pending) return;
    if (pending->what == Asked::identity) {
        if (refused || !response->status.ok()) return;
        if (const auto known = read_identity(response->data)) keep_identity(connection.server.address, *known);
        return;
    }
    auto& open = opens_[pending->open];
    if (pending->what == Asked::close) {
        if (!refused) open.close_status = response->status;
        return;
    }
    open.answered = envelope.time;
    if (refused) {
        open.encapsulation_status = envelope.frame.status;
    } else {
        answered_open(pending->open, envelope, *response);
    }
}

void Conversation::answered_open(std::size_t index, const Envelope& envelope, const cip::Response& response) {
    auto& open = opens_[index];
    open.status = response.status;
    if (!response.status.ok() || !open.request) return;
    const auto reply = cip::ForwardOpenReply::parse(response.data);
    if (!reply) return;
    open.reply = *reply;
    open.o_to_t.statistics = IntervalStatistics(std::chrono::microseconds(reply->o_to_t_api));
    open.t_to_o.statistics = IntervalStatistics(std::chrono::microseconds(reply->t_to_o_api));
    open.target_receiver = socket_address(envelope.data.packet, enip::ItemType::sockaddr_o_to_t);
    open.given_receiver = socket_address(envelope.data.packet, enip::ItemType::sockaddr_t_to_o);
    for (const auto id : {reply->o_to_t_id, reply->t_to_o_id}) {
        auto& known = by_id_[id];
        for (const auto earlier : known) {
            auto& other = opens_[earlier];
            const bool same_ends =
                other.originator.address == open.originator.address && other.target.address == open.target.address;
            // Consumers of one multicast share the T->O id; their O->T ids differ.
            const bool alone = open.request->t_to_o.type != cip::ConnectionType::multicast;
            const bool same_id =
                other.reply->o_to_t_id == reply->o_to_t_id || (alone && other.reply->t_to_o_id == reply->t_to_o_id);
            if (same_ends && same_id && !other.replaced && earlier != index) {
                other.replaced = envelope.time;
            }
        }
        if (std::ranges::find(known, index) == known.end()) known.push_back(index);
    }
}

bool Conversation::read_io(const CapturedPacket& packet, const enip::IoPacket& io) {
    const auto found = by_id_.find(io.connection_id);
    if (found == by_id_.end()) return false;
    bool any = false;
    for (const auto index : found->second) {
        auto& open = opens_[index];
        if (open.replaced) continue;
        const bool counted = open.request->transport.transport_class == 1;
        const auto target = endpoint_of(open.target_receiver, open.target.address);
        const bool from_target =
            packet.source.address == open.target.address || packet.source.address == target.address;
        if (io.connection_id == open.reply->t_to_o_id && from_target) {
            // What is on its way while the connection is closed still belongs to it (R-CON-37).
            open.t_to_o.take(io, packet.destination, packet.time, counted);
            any = true;
        } else if (io.connection_id == open.reply->o_to_t_id && packet.source.address == open.originator.address) {
            open.o_to_t.take(io, packet.destination, packet.time, counted);
            any = true;
        }
    }
    return any;
}

void Conversation::read_identities(const enip::Frame& frame, std::uint32_t address) {
    if (frame.command != enip::Command::list_identity || frame.data.empty()) return;
    const auto packet = enip::CommonPacket::parse(frame.data);
    if (!packet) return;
    const auto* item = packet->find(enip::ItemType::identity);
    if (item == nullptr) return;
    if (const auto known = enip::IdentityItem::parse(item->data)) keep_identity(address, identity_of(*known));
}

void Conversation::keep_identity(std::uint32_t address, const Identity& identity) {
    if (identities_.size() < max_identities || identities_.contains(address)) identities_[address] = identity;
}

}  // namespace servobus::scanner
