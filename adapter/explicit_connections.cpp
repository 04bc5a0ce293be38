#include "adapter/explicit_connections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "adapter/forward_open_checks.hpp"
#include "cip/path.hpp"
#include "cip/services.hpp"
#include "enip/io_stream.hpp"

namespace servobus::adapter {
namespace {

using std::chrono::microseconds;

constexpr std::uint16_t sequence_octets = 2;
constexpr std::uint16_t smallest_size = 4;

std::uint16_t size_limit(const Limits& limits) {
    return static_cast<std::uint16_t>(std::min<std::size_t>(limits.message_bytes + sequence_octets, 0xFFFF));
}

}  // namespace

OpenResult<void> ExplicitConnections::check(const cip::ForwardOpen& open) const {
    if (auto sound = check_transport(open); !sound) return sound;
    if (auto sound = check_path(open.path); !sound) return sound;
    if (auto sound = check_rpi(open, 0); !sound) return sound;
    if (auto sound = check_sizes(open); !sound) return sound;
    if (connections_.size() < limits_.class3_connections) return {};
    return OpenRefusal{cip::ConnectionFailure::out_of_connections,
                       fmt::format("all {} class 3 connections are in use", limits_.class3_connections)};
}

// `[port 1 address 0] [key] 20 02 24 01` (R-CON-10, R-MR-2).
OpenResult<void> ExplicitConnections::check_path(cip::ByteView octets) const {
    const auto path = cip::Path::parse(octets);
    if (!path) return OpenRefusal{cip::ConnectionFailure::invalid_path_segment, "the connection path is malformed"};
    const auto segments = check_key(*path, node_);
    if (!segments) return segments.error();
    const auto is = [](const cip::Segment& segment, cip::LogicalType type, std::uint32_t value) {
        const auto* logical = std::get_if<cip::LogicalSegment>(&segment);
        return logical != nullptr && logical->type == type && logical->value == value;
    };
    const bool fits = segments->size() == 2 &&
                      is((*segments)[0], cip::LogicalType::class_id, cip::class_id::message_router) &&
                      is((*segments)[1], cip::LogicalType::instance, 1);
    if (fits) return {};
    return OpenRefusal{cip::ConnectionFailure::invalid_path_segment,
                       "a class 3 connection leads to the message router, 20 02 24 01"};
}

// R-CON-47: any size from 4 up to our own limit; the refusal tells the limit.
OpenResult<void> ExplicitConnections::check_sizes(const cip::ForwardOpen& open) const {
    const auto limit = size_limit(limits_);
    const auto fits = [&](std::uint16_t size) { return size >= smallest_size && size <= limit; };
    const auto refusal = [&](cip::ConnectionFailure failure, std::uint16_t size) {
        return OpenRefusal{{cip::GeneralStatus::connection_failure, {static_cast<std::uint16_t>(failure), limit}},
                           fmt::format("size {} asked; {} to {} are served", size, smallest_size, limit)};
    };
    if (!fits(open.o_to_t.size)) return refusal(cip::ConnectionFailure::invalid_o_to_t_size, open.o_to_t.size);
    if (!fits(open.t_to_o.size)) return refusal(cip::ConnectionFailure::invalid_t_to_o_size, open.t_to_o.size);
    return {};
}

OpenResult<const ExplicitConnection*> ExplicitConnections::open(const cip::ForwardOpen& open, const cip::Origin& origin,
                                                                std::uint16_t number) {
    if (const auto sound = check(open); !sound) return sound.error();
    ExplicitConnection connection;
    connection.number = number;
    connection.o_to_t_id = ids_.next();
    connection.t_to_o_id = open.t_to_o_id;
    connection.triad = open.triad;
    connection.session = origin.session;
    connection.address = origin.address;
    connection.reply_limit = static_cast<std::size_t>(open.t_to_o.size - sequence_octets);
    connection.multiplier_code = open.timeout_multiplier;
    connection.o_to_t_rpi = open.o_to_t_rpi;
    connection.t_to_o_rpi = open.t_to_o_rpi;
    connection.timeout = enip::connection_timeout(microseconds(open.o_to_t_rpi), open.timeout_multiplier);
    connection.deadline = origin.now + std::max<microseconds>(connection.timeout, enip::first_packet_patience);
    const auto id = connection.o_to_t_id;
    return &connections_.insert_or_assign(id, std::move(connection)).first->second;
}

void ExplicitConnections::on_session_closed(std::uint64_t session) {
    std::erase_if(connections_, [&](const auto& entry) { return entry.second.session == session; });
}

void ExplicitConnections::on_timer(cip::Time now, const std::function<void(const ExplicitConnection&)>& timed_out) {
    std::erase_if(connections_, [&](const auto& entry) {
        if (entry.second.deadline > now) return false;
        timed_out(entry.second);
        return true;
    });
}

std::optional<cip::Time> ExplicitConnections::next_deadline() const {
    const auto first =
        std::ranges::min_element(connections_, {}, [](const auto& entry) { return entry.second.deadline; });
    if (first == connections_.end()) return std::nullopt;
    return first->second.deadline;
}

std::optional<cip::Bytes> ExplicitConnections::on_message(const enip::ConnectedMessage& message,
                                                          const cip::Origin& origin, cip::MessageRouter& router) {
    const auto found = connections_.find(message.connection_id);
    if (found == connections_.end() || found->second.session != origin.session) return std::nullopt;  // R-ENC-23
    auto& connection = found->second;
    connection.deadline = origin.now + connection.timeout;
    if (connection.last_sequence != message.sequence) {
        auto bounded = origin;
        bounded.reply_limit = connection.reply_limit;
        const auto response = router.handle(message.message, bounded);
        if (!response) return std::nullopt;
        connection.last_sequence = message.sequence;
        connection.last_reply = response->encode();
    }
    return enip::connected_reply(connection.t_to_o_id, message.sequence, connection.last_reply);
}

void ExplicitConnections::amend(std::uint64_t session, const enip::ConnectedMessage& reply) {
    for (auto& [id, connection] : connections_) {
        const bool is_it = connection.session == session && connection.t_to_o_id == reply.connection_id &&
                           connection.last_sequence == reply.sequence;
        if (is_it) connection.last_reply.assign(reply.message.begin(), reply.message.end());
    }
}

const ExplicitConnection* ExplicitConnections::find(const cip::ConnectionTriad& triad) const {
    const auto found =
        std::ranges::find_if(connections_, [&](const auto& entry) { return entry.second.triad == triad; });
    return found != connections_.end() ? &found->second : nullptr;
}

const ExplicitConnection* ExplicitConnections::find(std::uint16_t number) const {
    const auto found =
        std::ranges::find_if(connections_, [&](const auto& entry) { return entry.second.number == number; });
    return found != connections_.end() ? &found->second : nullptr;
}

}  // namespace servobus::adapter
