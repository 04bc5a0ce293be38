#include "adapter/connection_manager.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "adapter/wire_checks.hpp"
#include "cip/path.hpp"
#include "cip/services.hpp"
#include "cip/wire.hpp"

namespace servobus::adapter {
namespace {

using std::chrono::microseconds;

constexpr std::uint32_t smallest_rpi = 1000;  // µs, 000 §2.4
constexpr std::uint8_t last_multiplier_code = 7;
constexpr std::uint8_t explicit_class = 3;
constexpr std::uint8_t last_trigger = 2;
constexpr std::uint16_t sequence_octets = 2;
constexpr std::uint16_t smallest_size = 4;
constexpr auto first_message_patience = std::chrono::seconds(10);  // R-CON-19

constexpr std::uint16_t backplane_port = 1;
constexpr std::uint16_t network_port = 2;  // the Ethernet side, as the Port object numbers it (R-PRT-1)

std::uint16_t size_limit(const Limits& limits) {
    return static_cast<std::uint16_t>(std::min<std::size_t>(limits.message_bytes + sequence_octets, 0xFFFF));
}

microseconds watchdog(std::uint32_t rpi, std::uint8_t multiplier) {
    return microseconds{std::uint64_t{rpi} * (4ULL << multiplier)};
}

// R-CON-17: 0 is 0x0111; below the minimum, the acceptable values are told.
cip::Status check_rpi(std::uint32_t o_to_t, std::uint32_t t_to_o) {
    if (o_to_t == 0 || t_to_o == 0) return cip::ConnectionFailure::rpi_not_supported;
    if (o_to_t >= smallest_rpi && t_to_o >= smallest_rpi) return {};
    const auto kind = [](std::uint32_t rpi) {
        return rpi < smallest_rpi ? cip::RpiKind::minimum : cip::RpiKind::acceptable;
    };
    return cip::RpiRefusal{kind(o_to_t), kind(t_to_o), std::max(o_to_t, smallest_rpi), std::max(t_to_o, smallest_rpi)}
        .status();
}

cip::Status check_types(const cip::ForwardOpen& open) {
    using cip::ConnectionFailure;
    using cip::ConnectionType;
    const bool both_null = open.o_to_t.type == ConnectionType::null && open.t_to_o.type == ConnectionType::null;
    if (both_null) return ConnectionFailure::null_forward_open_not_supported;  // R-CON-23
    if (open.transport.transport_class != explicit_class || open.transport.trigger > last_trigger) {
        return ConnectionFailure::class_trigger_not_supported;
    }
    if (open.timeout_multiplier > last_multiplier_code) return ConnectionFailure::timeout_multiplier_not_acceptable;
    if (open.o_to_t.type != ConnectionType::point_to_point) return ConnectionFailure::invalid_o_to_t_type;
    if (open.t_to_o.type != ConnectionType::point_to_point) return ConnectionFailure::invalid_t_to_o_type;
    if (open.o_to_t.redundant_owner) return ConnectionFailure::redundant_owner_not_supported;
    return {};
}

// The triad stands in front of whatever is malformed, so a refusal can name the connection (vector fo_short_rep).
cip::ConnectionTriad triad_at(cip::ByteView data, std::size_t offset) {
    cip::Reader reader(data);
    reader.take(offset);
    cip::ConnectionTriad triad;
    reader.field(triad.serial_number);
    reader.field(triad.originator_vendor);
    reader.field(triad.originator_serial);
    return reader.ok() ? triad : cip::ConnectionTriad{};
}

cip::Response refuse(std::uint8_t service, cip::Status status, const cip::ConnectionTriad& triad) {
    return {service, std::move(status), cip::ConnectionRefusal{triad, 0}.encode()};
}

cip::GeneralStatus length_status(cip::DecodeError error) {
    return error == cip::DecodeError::trailing ? cip::GeneralStatus::too_much_data
                                               : cip::GeneralStatus::not_enough_data;
}

// A hop that ends at this node: port 1 address 0, as originators write for "the device itself" (R-CM-9).
bool is_self(const cip::PortSegment& hop) { return hop.port == backplane_port && hop.link_address == cip::Bytes{0}; }

// This device routes nowhere: the port does not exist, or nobody is at that address behind it.
cip::ConnectionFailure no_route(const cip::PortSegment& hop) {
    if (hop.port != backplane_port && hop.port != network_port) return cip::ConnectionFailure::port_not_available;
    return cip::ConnectionFailure::link_address_not_valid;
}

// Where a route leads: success for this node.
cip::Status check_route(cip::ByteView route) {
    const auto path = cip::Path::parse(route);
    if (!path) return cip::GeneralStatus::path_segment_error;
    if (path->segments.empty()) return {};
    const auto* hop = std::get_if<cip::PortSegment>(&path->segments.front());
    if (hop == nullptr) return cip::GeneralStatus::path_segment_error;
    if (path->segments.size() == 1 && is_self(*hop)) return {};
    return no_route(*hop);
}

}  // namespace

ConnectionManager::ConnectionManager(cip::MessageRouter& router, cip::NodeIdentity node, const Limits& limits,
                                     std::uint16_t incarnation, Log log)
    : router_(router), node_(node), limits_(limits), incarnation_(incarnation), log_(std::move(log)) {}

cip::ClassInfo ConnectionManager::info() const {
    return {.class_id = cip::class_id::connection_manager,
            .max_instance_attribute = static_cast<std::uint16_t>(Counter::connection_timeouts)};
}

bool ConnectionManager::offers(std::uint8_t service) const {
    switch (service) {
        case cip::service::get_attribute_single:
        case cip::service::set_attribute_single:
        case cip::service::forward_open:
        case cip::service::large_forward_open:
        case cip::service::forward_close:
        case cip::service::unconnected_send:
            return true;
        default:
            return false;
    }
}

std::optional<cip::AttributeAccess> ConnectionManager::attribute(std::uint32_t, std::uint32_t id) const {
    if (id < 1 || id > counters_.size()) return std::nullopt;
    return cip::AttributeAccess{true, true};
}

cip::Status ConnectionManager::get(std::uint32_t, std::uint32_t id, cip::Writer& value) const {
    value.u16(counters_[id - 1]);
    return {};
}

// Counters can only be cleared (R-CM-2).
cip::Status ConnectionManager::set(std::uint32_t, std::uint32_t id, cip::ByteView value) {
    const auto wanted = whole_value<std::uint16_t>(value);
    if (!wanted) return wanted.error();
    if (*wanted != 0) return cip::GeneralStatus::invalid_attribute_value;
    counters_[id - 1] = 0;
    return {};
}

std::optional<std::size_t> ConnectionManager::value_size(std::uint32_t, std::uint32_t, cip::ByteView) const {
    return sizeof(std::uint16_t);
}

cip::Response ConnectionManager::call(const cip::RequestView& request, const cip::RequestPath&,
                                      const cip::Origin& origin) {
    // Opening a connection through a connection is legal by the letter, but not served (R-CM-1).
    if (origin.via == cip::Origin::Via::connected) {
        return {request.service, cip::GeneralStatus::service_not_supported, {}};
    }
    switch (request.service) {
        case cip::service::forward_open:
        case cip::service::large_forward_open:
            return forward_open(request, origin);
        case cip::service::forward_close:
            return forward_close(request, origin);
        case cip::service::unconnected_send:
            return unconnected_send(request, origin);
        default:
            return {request.service, cip::GeneralStatus::service_not_supported, {}};
    }
}

cip::Response ConnectionManager::forward_open(const cip::RequestView& request, const cip::Origin& origin) {
    count(Counter::open_requests);
    const auto open = cip::ForwardOpen::parse(request.data, request.service == cip::service::large_forward_open);
    if (!open) {
        count(Counter::open_format_rejects);
        constexpr std::size_t triad_offset = 10;
        return refuse(request.service, length_status(open.error()), triad_at(request.data, triad_offset));
    }
    auto status = check(*open);
    if (!status.ok()) {
        count_reject(status);
        log_(LogLevel::warning,
             fmt::format("Forward_Open of connection serial {} by vendor {} refused: {}", open->triad.serial_number,
                         open->triad.originator_vendor, cip::describe(status)));
        return refuse(request.service, std::move(status), open->triad);
    }
    const auto& connection = admit(*open, origin);
    log_(LogLevel::info, fmt::format("class 3 connection 0x{:08X} open, times out after {} ms without a request",
                                     connection.o_to_t_id, connection.timeout.count() / 1000));
    const cip::ForwardOpenReply reply{.o_to_t_id = connection.o_to_t_id,
                                      .t_to_o_id = connection.t_to_o_id,
                                      .triad = open->triad,
                                      .o_to_t_api = open->o_to_t_rpi,
                                      .t_to_o_api = open->t_to_o_rpi,
                                      .application_reply = {}};
    return {request.service, {}, reply.encode()};
}

// The order of R-CON-15.
cip::Status ConnectionManager::check(const cip::ForwardOpen& open) const {
    const bool open_already =
        std::ranges::any_of(connections_, [&](const auto& entry) { return entry.second.triad == open.triad; });
    const bool null_open =
        open.o_to_t.type == cip::ConnectionType::null && open.t_to_o.type == cip::ConnectionType::null;
    if (open_already && !null_open) return cip::ConnectionFailure::duplicate_forward_open;
    if (auto status = check_types(open); !status.ok()) return status;
    if (auto status = check_path(open.path); !status.ok()) return status;
    if (auto status = check_rpi(open.o_to_t_rpi, open.t_to_o_rpi); !status.ok()) return status;
    if (auto status = check_sizes(open); !status.ok()) return status;
    if (connections_.size() >= limits_.class3_connections) return cip::ConnectionFailure::out_of_connections;
    return {};
}

// `[port 1 address 0] [key] 20 02 24 01` (R-CON-10, R-MR-2).
cip::Status ConnectionManager::check_path(cip::ByteView octets) const {
    const auto path = cip::Path::parse(octets);
    if (!path) return cip::ConnectionFailure::invalid_path_segment;
    std::span<const cip::Segment> segments = path->segments;
    if (!segments.empty()) {
        if (const auto* hop = std::get_if<cip::PortSegment>(&segments.front())) {
            if (!is_self(*hop)) return no_route(*hop);
            segments = segments.subspan(1);
        }
    }
    if (!segments.empty()) {
        if (const auto* key = std::get_if<cip::ElectronicKey>(&segments.front())) {
            if (const auto failure = cip::mismatch(*key, node_)) return *failure;
            segments = segments.subspan(1);
        }
    }
    const auto is = [](const cip::Segment& segment, cip::LogicalType type, std::uint32_t value) {
        const auto* known = std::get_if<cip::LogicalSegment>(&segment);
        return known != nullptr && known->type == type && known->value == value;
    };
    const bool fits = segments.size() == 2 &&
                      is(segments[0], cip::LogicalType::class_id, cip::class_id::message_router) &&
                      is(segments[1], cip::LogicalType::instance, 1);
    if (!fits) return cip::ConnectionFailure::invalid_path_segment;
    return {};
}

// R-CON-47: any size from 4 up to our own limit; the refusal tells the limit.
cip::Status ConnectionManager::check_sizes(const cip::ForwardOpen& open) const {
    const auto limit = size_limit(limits_);
    const auto fits = [&](std::uint16_t size) { return size >= smallest_size && size <= limit; };
    const auto refusal = [&](cip::ConnectionFailure failure) {
        return cip::Status(cip::GeneralStatus::connection_failure, {static_cast<std::uint16_t>(failure), limit});
    };
    if (!fits(open.o_to_t.size)) return refusal(cip::ConnectionFailure::invalid_o_to_t_size);
    if (!fits(open.t_to_o.size)) return refusal(cip::ConnectionFailure::invalid_t_to_o_size);
    return {};
}

ExplicitConnection& ConnectionManager::admit(const cip::ForwardOpen& open, const cip::Origin& origin) {
    ExplicitConnection connection;
    connection.o_to_t_id = choose_id();
    connection.t_to_o_id = open.t_to_o_id;
    connection.triad = open.triad;
    connection.session = origin.session;
    connection.address = origin.address;
    connection.reply_limit = static_cast<std::size_t>(open.t_to_o.size - sequence_octets);
    connection.timeout = watchdog(open.o_to_t_rpi, open.timeout_multiplier);
    connection.deadline = origin.now + std::max<microseconds>(connection.timeout, first_message_patience);
    const auto id = connection.o_to_t_id;
    return connections_.insert_or_assign(id, std::move(connection)).first->second;
}

std::uint32_t ConnectionManager::choose_id() {
    std::uint32_t id = 0;
    do {
        id = std::uint32_t{incarnation_} << 16 | ++last_number_;
    } while (connections_.contains(id));
    return id;
}

ExplicitConnection* ConnectionManager::find(const cip::ConnectionTriad& triad) {
    const auto found =
        std::ranges::find_if(connections_, [&](const auto& entry) { return entry.second.triad == triad; });
    return found != connections_.end() ? &found->second : nullptr;
}

cip::Response ConnectionManager::forward_close(const cip::RequestView& request, const cip::Origin& origin) {
    count(Counter::close_requests);
    const auto close = cip::ForwardClose::parse(request.data);
    if (!close) {
        count(Counter::close_format_rejects);
        constexpr std::size_t triad_offset = 2;
        return refuse(request.service, length_status(close.error()), triad_at(request.data, triad_offset));
    }
    const auto* connection = find(close->triad);
    if (connection == nullptr) {
        count(Counter::close_other_rejects);
        return refuse(request.service, cip::ConnectionFailure::connection_not_found, close->triad);
    }
    if (connection->address != origin.address) {
        count(Counter::close_other_rejects);
        return refuse(request.service, cip::GeneralStatus::privilege_violation, close->triad);
    }
    log_(LogLevel::info, fmt::format("class 3 connection 0x{:08X} closed", connection->o_to_t_id));
    connections_.erase(connection->o_to_t_id);
    return {request.service, {}, cip::ForwardCloseReply{close->triad, {}}.encode()};
}

cip::Response ConnectionManager::unconnected_send(const cip::RequestView& request, const cip::Origin& origin) {
    const auto fail = [&](cip::Status status, cip::ByteView route) {
        // R-CM-10: the words of the route that were not travelled, and a reserved octet.
        return cip::Response{request.service, std::move(status), {static_cast<std::uint8_t>(route.size() / 2), 0}};
    };
    if (origin.depth > 0) return {request.service, cip::GeneralStatus::service_not_supported, {}};
    const auto send = cip::UnconnectedSend::parse(request.data);
    if (!send) return fail(cip::ConnectionFailure::unconnected_parameter_error, {});
    if (auto status = check_route(send->route_path); !status.ok()) return fail(std::move(status), send->route_path);
    auto inner = origin;
    ++inner.depth;
    auto response = router_.handle(send->message, inner);
    if (!response) return fail(cip::ConnectionFailure::unconnected_parameter_error, send->route_path);
    return *std::move(response);
}

std::optional<enip::SendData> ConnectionManager::on_connected(const enip::ConnectedMessage& message,
                                                              std::uint64_t session, std::uint32_t address,
                                                              cip::Time now) {
    on_timer(now);  // a request does not revive a connection whose time is over
    const auto found = connections_.find(message.connection_id);
    if (found == connections_.end() || found->second.session != session) return std::nullopt;  // R-ENC-23
    auto& connection = found->second;
    connection.deadline = now + connection.timeout;
    if (connection.last_sequence != message.sequence) {
        const cip::Origin origin{.via = cip::Origin::Via::connected,
                                 .session = session,
                                 .address = address,
                                 .reply_limit = connection.reply_limit,
                                 .now = now};
        const auto response = router_.handle(message.message, origin);
        if (!response) return std::nullopt;
        connection.last_sequence = message.sequence;
        connection.last_reply = response->encode();
    }
    return enip::SendData::connected(connection.t_to_o_id, message.sequence, connection.last_reply);
}

void ConnectionManager::on_session_closed(std::uint64_t session) {
    std::erase_if(connections_, [&](const auto& entry) { return entry.second.session == session; });
}

void ConnectionManager::on_timer(cip::Time now) {
    std::erase_if(connections_, [&](const auto& entry) {
        if (entry.second.deadline > now) return false;
        count(Counter::connection_timeouts);
        log_(LogLevel::warning, fmt::format("class 3 connection 0x{:08X} timed out", entry.first));
        return true;
    });
}

std::optional<cip::Time> ConnectionManager::next_deadline() const {
    const auto first =
        std::ranges::min_element(connections_, {}, [](const auto& entry) { return entry.second.deadline; });
    if (first == connections_.end()) return std::nullopt;
    return first->second.deadline;
}

void ConnectionManager::count(Counter counter) { ++counters_[static_cast<std::size_t>(counter) - 1]; }

// R-CM-3.
void ConnectionManager::count_reject(const cip::Status& status) {
    using cip::ConnectionFailure;
    const auto failure = static_cast<ConnectionFailure>(status.extended.empty() ? 0 : status.extended.front());
    switch (failure) {
        case ConnectionFailure::out_of_connections:
            count(Counter::open_resource_rejects);
            break;
        case ConnectionFailure::duplicate_forward_open:
        case ConnectionFailure::null_forward_open_not_supported:
            count(Counter::open_other_rejects);
            break;
        default:
            count(Counter::open_format_rejects);
            break;
    }
}

}  // namespace servobus::adapter
