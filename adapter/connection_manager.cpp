#include "adapter/connection_manager.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "adapter/forward_open_checks.hpp"
#include "adapter/wire_checks.hpp"
#include "cip/path.hpp"
#include "cip/services.hpp"
#include "cip/triad_wire.hpp"
#include "cip/wire.hpp"

namespace servobus::adapter {
namespace {

// Attributes beside the counters (R-CM-2).
enum Attribute : std::uint16_t { entries = 9, cpu = 11, buffer = 12, buffer_space = 13 };

bool is_counter(std::uint32_t id) { return id >= 1 && id <= connection_counters; }

// Where the triad stands in front of whatever is malformed, so that a refusal can name the connection (vector
// fo_short_rep).
constexpr std::size_t open_triad_offset = 10;
constexpr std::size_t close_triad_offset = 2;

cip::ConnectionTriad triad_at(cip::ByteView data, std::size_t offset) {
    cip::Reader reader(data);
    reader.take(offset);
    cip::ConnectionTriad triad;
    cip::describe_triad(reader, triad);
    return reader.ok() ? triad : cip::ConnectionTriad{};
}

cip::Response refused(std::uint8_t service, cip::Status status, const cip::ConnectionTriad& triad) {
    return {service, std::move(status), cip::ConnectionRefusal{triad, 0}.encode()};
}

cip::GeneralStatus length_status(cip::DecodeError error) {
    return error == cip::DecodeError::trailing ? cip::GeneralStatus::too_much_data
                                               : cip::GeneralStatus::not_enough_data;
}

cip::ForwardOpenReply reply_to(const cip::ForwardOpen& open, std::uint32_t o_to_t_id, std::uint32_t t_to_o_id) {
    // The interval that is granted is the one that was asked for, because it can be kept (R-CON-17).
    return {.o_to_t_id = o_to_t_id,
            .t_to_o_id = t_to_o_id,
            .triad = open.triad,
            .o_to_t_api = open.o_to_t_rpi,
            .t_to_o_api = open.t_to_o_rpi,
            .application_reply = {}};
}

cip::ConnectionData data_of(const IoConnection& connection) {
    const auto& open = connection.request;
    return {.number = connection.number,
            .originator_port = connection.originator.port,
            .target_port = connection.production->producer.settings().route.local.port,
            .triad = open.triad,
            .o_to_t_id_at_originator = connection.o_to_t_id,
            .o_to_t_id_at_target = connection.o_to_t_id,
            .o_to_t_multiplier = open.timeout_multiplier,
            .o_to_t_rpi = open.o_to_t_rpi,
            .o_to_t_api = open.o_to_t_rpi,
            .t_to_o_id_at_originator = connection.t_to_o_id,
            .t_to_o_id_at_target = connection.t_to_o_id,
            .t_to_o_multiplier = open.timeout_multiplier,
            .t_to_o_rpi = open.t_to_o_rpi,
            .t_to_o_api = open.t_to_o_rpi};
}

cip::ConnectionData data_of(const ExplicitConnection& connection) {
    return {.number = connection.number,
            .originator_port = enip::tcp_port,
            .target_port = enip::tcp_port,
            .triad = connection.triad,
            .o_to_t_id_at_originator = connection.o_to_t_id,
            .o_to_t_id_at_target = connection.o_to_t_id,
            .o_to_t_multiplier = connection.multiplier_code,
            .o_to_t_rpi = connection.o_to_t_rpi,
            .o_to_t_api = connection.o_to_t_rpi,
            .t_to_o_id_at_originator = connection.t_to_o_id,
            .t_to_o_id_at_target = connection.t_to_o_id,
            .t_to_o_multiplier = connection.multiplier_code,
            .t_to_o_rpi = connection.t_to_o_rpi,
            .t_to_o_api = connection.t_to_o_rpi};
}

// Not found: 0x05 (R-CM-7).
cip::Response connection_data(std::uint8_t service, const IoConnection* io, const ExplicitConnection* messages) {
    if (io != nullptr) return {service, {}, data_of(*io).encode()};
    if (messages != nullptr) return {service, {}, data_of(*messages).encode()};
    return {service, cip::GeneralStatus::path_destination_unknown, {}};
}

}  // namespace

ConnectionManager::ConnectionManager(cip::MessageRouter& router, cip::NodeIdentity node, DriveIo& drive,
                                     const Network& network, const Limits& limits, std::uint16_t incarnation, Log log)
    : router_(router),
      node_(node),
      limits_(limits),
      log_(std::move(log)),
      ids_(incarnation, [this](std::uint32_t id) { return io_.uses(id) || explicit_.uses(id); }),
      explicit_(ids_, node_, limits),
      io_(drive, network, ids_, limits, log_) {}

cip::ClassInfo ConnectionManager::info() const {
    return {.class_id = cip::class_id::connection_manager, .max_instance_attribute = buffer_space};
}

bool ConnectionManager::offers(std::uint8_t service) const {
    switch (service) {
        case cip::service::get_attribute_single:
        case cip::service::set_attribute_single:
        case cip::service::forward_open:
        case cip::service::large_forward_open:
        case cip::service::forward_close:
        case cip::service::unconnected_send:
        case cip::service::get_connection_data:
        case cip::service::search_connection_data:
        case cip::service::get_connection_owner:
            return true;
        default:
            return false;
    }
}

std::optional<cip::AttributeAccess> ConnectionManager::attribute(std::uint32_t, std::uint32_t id) const {
    if (is_counter(id)) return cip::AttributeAccess{true, true};
    return id == entries || (id >= cpu && id <= buffer_space) ? std::optional(cip::AttributeAccess{}) : std::nullopt;
}

cip::Status ConnectionManager::get(std::uint32_t, std::uint32_t id, cip::Writer& value) const {
    switch (id) {
        case entries:
            write_entries(value);
            break;
        case cpu:
            value.u16(resources_().cpu);
            break;
        case buffer:
            value.u32(resources_().buffer);
            break;
        case buffer_space:
            value.u32(resources_().buffer_space);
            break;
        default:
            value.u16(counters_[id - 1]);
    }
    return {};
}

// A bit for each connection that can be, by its number from 1 on: 1 where none is (R-CM-2).
void ConnectionManager::write_entries(cip::Writer& value) const {
    constexpr std::size_t owners = 1;
    const auto places = owners + limits_.listening_connections + limits_.class3_connections;
    value.u16(static_cast<std::uint16_t>(places));
    for (std::size_t first = 0; first < places; first += 8) {
        unsigned bits = 0;
        for (std::size_t i = 0; i < 8 && first + i < places; ++i) {
            if (is_free(static_cast<std::uint16_t>(first + i + 1))) bits |= 1U << i;
        }
        value.u8(static_cast<std::uint8_t>(bits));
    }
}

// An open that is not admitted names its connection like any other that is refused (R-CON-14).
cip::Response ConnectionManager::refuse(const cip::RequestView& request, cip::Status status) {
    if (request.service != cip::service::forward_open && request.service != cip::service::large_forward_open) {
        return {request.service, std::move(status), {}};
    }
    count(Counter::open_requests);
    count(Counter::open_other_rejects);
    return refused(request.service, std::move(status), triad_at(request.data, open_triad_offset));
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
    switch (request.service) {
        case cip::service::get_connection_data:
            return get_connection_data(request);
        case cip::service::search_connection_data:
            return search_connection_data(request);
        case cip::service::get_connection_owner:
            return get_connection_owner(request);
        default:
            break;
    }
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
        log_(LogLevel::warning,
             fmt::format("Forward_Open refused: its {} octets end {} its connection path does", request.data.size(),
                         open.error() == cip::DecodeError::trailing ? "after" : "before"));
        return refused(request.service, length_status(open.error()), triad_at(request.data, open_triad_offset));
    }
    auto reply = admit(*open, origin);
    if (reply) return {request.service, {}, reply->encode()};
    const auto refusal = reply.error();
    count_reject(refusal.status);
    log_(LogLevel::warning,
         fmt::format("Forward_Open of connection serial {} by vendor {} refused: {}{}{}", open->triad.serial_number,
                     open->triad.originator_vendor, cip::describe(refusal.status), refusal.words.empty() ? "" : ": ",
                     refusal.words));
    return refused(request.service, refusal.status, open->triad);
}

// The order of R-CON-15.
OpenResult<cip::ForwardOpenReply> ConnectionManager::admit(const cip::ForwardOpen& open, const cip::Origin& origin) {
    if (refuse_) {
        if (auto refusal = refuse_(open)) return *std::move(refusal);
    }
    if (is_null(open)) {
        return OpenRefusal{cip::ConnectionFailure::null_forward_open_not_supported,
                           "both directions are null, and there is nothing to reconfigure here"};  // R-CON-23
    }
    if (io_.find(open.triad) != nullptr || explicit_.find(open.triad) != nullptr) {
        return OpenRefusal{cip::ConnectionFailure::duplicate_forward_open,
                           "a connection with this serial number, vendor and originator serial is open"};  // R-CON-26
    }
    return open.transport.transport_class == explicit_class ? admit_explicit(open, origin) : admit_io(open, origin);
}

OpenResult<cip::ForwardOpenReply> ConnectionManager::admit_explicit(const cip::ForwardOpen& open,
                                                                    const cip::Origin& origin) {
    const auto opened = explicit_.open(open, origin, free_number());
    if (!opened) return opened.error();
    const auto& connection = **opened;
    log_(LogLevel::info, fmt::format("class 3 connection 0x{:08X} open, times out after {} ms without a request",
                                     connection.o_to_t_id, connection.timeout.count() / 1000));
    return reply_to(open, connection.o_to_t_id, connection.t_to_o_id);
}

OpenResult<cip::ForwardOpenReply> ConnectionManager::admit_io(const cip::ForwardOpen& open, const cip::Origin& origin) {
    const auto wanted = check_io_open(open, node_);
    if (!wanted) return wanted.error();
    const auto opened = io_.open(open, *wanted, origin, free_number());
    if (!opened) return opened.error();
    const auto& connection = **opened;
    log_(LogLevel::info, fmt::format("{} open: O->T every {} us, T->O every {} us to {}, times out after {} ms",
                                     describe(connection), open.o_to_t_rpi, open.t_to_o_rpi,
                                     enip::to_string(connection.production->producer.settings().route.peer),
                                     connection.consumer.settings().timeout.count() / 1000));
    return reply_to(open, connection.o_to_t_id, connection.t_to_o_id);
}

// The lowest that no connection has.
std::uint16_t ConnectionManager::free_number() const {
    std::uint16_t number = 1;
    while (!is_free(number)) ++number;
    return number;
}

bool ConnectionManager::is_free(std::uint16_t number) const {
    return io_.find(number) == nullptr && explicit_.find(number) == nullptr;
}

cip::Response ConnectionManager::forward_close(const cip::RequestView& request, const cip::Origin& origin) {
    count(Counter::close_requests);
    const auto close = cip::ForwardClose::parse(request.data);
    if (!close) {
        count(Counter::close_format_rejects);
        return refused(request.service, length_status(close.error()), triad_at(request.data, close_triad_offset));
    }
    const auto* io = io_.find(close->triad);
    const auto* messages = explicit_.find(close->triad);
    if (io == nullptr && messages == nullptr) {
        count(Counter::close_other_rejects);
        return refused(request.service, cip::ConnectionFailure::connection_not_found, close->triad);
    }
    if ((io != nullptr ? io->originator.address : messages->address) != origin.address) {
        count(Counter::close_other_rejects);
        return refused(request.service, cip::GeneralStatus::privilege_violation, close->triad);
    }
    if (io != nullptr) {
        io_.close(*io);
    } else {
        log_(LogLevel::info, fmt::format("class 3 connection 0x{:08X} closed", messages->o_to_t_id));
        explicit_.close(messages->o_to_t_id);
    }
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
    inner.is_routed = true;
    auto response = router_.handle(send->message, inner);
    if (!response) return fail(cip::ConnectionFailure::unconnected_parameter_error, send->route_path);
    return *std::move(response);
}

cip::Response ConnectionManager::get_connection_data(const cip::RequestView& request) const {
    const auto number = whole_value<std::uint16_t>(request.data);
    if (!number) return {request.service, number.error(), {}};
    return connection_data(request.service, io_.find(*number), explicit_.find(*number));
}

cip::Response ConnectionManager::search_connection_data(const cip::RequestView& request) const {
    constexpr std::size_t triad_octets = 8;
    const auto wrong = length_status(request.data, triad_octets);
    if (wrong != cip::GeneralStatus::success) return {request.service, wrong, {}};
    const auto triad = triad_at(request.data, 0);
    return connection_data(request.service, io_.find(triad), explicit_.find(triad));
}

// The path leads to an O->T point; the drive has one owner, whichever point it took (R-CON-30).
cip::Response ConnectionManager::get_connection_owner(const cip::RequestView& request) const {
    cip::Reader reader(request.data);
    reader.reserved(1);
    const auto octets = reader.u8() * std::size_t{2};
    const auto path = cip::Path::parse(reader.take(octets));
    const auto wrong = length_status(reader);
    if (wrong != cip::GeneralStatus::success) return {request.service, wrong, {}};
    if (!path || path->segments.empty()) return {request.service, cip::GeneralStatus::path_segment_error, {}};
    const auto* point = std::get_if<cip::LogicalSegment>(&path->segments.back());
    const auto* kind = point != nullptr ? assemblies::find_by_output(point->value) : nullptr;
    if (kind == nullptr) return {request.service, cip::GeneralStatus::path_destination_unknown, {}};
    cip::ConnectionOwner owner;
    owner.connections = static_cast<std::uint8_t>(std::ranges::count_if(
        io_.all(), [&](const auto& each) { return each->kind->o_to_t_point == kind->o_to_t_point; }));
    if (owner.connections > 0 && io_.owner() != nullptr && io_.owner()->kind->o_to_t_point == kind->o_to_t_point) {
        owner.triad = io_.owner()->request.triad;
    }
    return {request.service, {}, owner.encode()};
}

std::optional<cip::Bytes> ConnectionManager::on_connected(const enip::ConnectedMessage& message,
                                                          const cip::Origin& origin) {
    // A request does not revive a connection whose time is over.
    explicit_.on_timer(origin.now, [this](const auto&) { count(Counter::connection_timeouts); });
    return explicit_.on_message(message, origin, router_);
}

void ConnectionManager::amend(std::uint64_t session, const enip::Frame& reply) {
    const auto data = enip::SendDataView::parse(reply.data);
    if (!data) return;
    if (const auto connected = enip::connected_message(*data)) explicit_.amend(session, *connected);
}

void ConnectionManager::on_timer(cip::Time now, enip::IoQueue& queue) {
    io_.on_timer(now, queue, counters_[static_cast<std::size_t>(Counter::connection_timeouts) - 1]);
    explicit_.on_timer(now, [this](const ExplicitConnection& connection) {
        count(Counter::connection_timeouts);
        log_(LogLevel::warning, fmt::format("class 3 connection 0x{:08X} timed out", connection.o_to_t_id));
    });
}

std::optional<cip::Time> ConnectionManager::next_deadline() const {
    const auto first = io_.next_deadline();
    const auto second = explicit_.next_deadline();
    if (!first || !second) return first ? first : second;
    return std::min(*first, *second);
}

void ConnectionManager::count(Counter counter) { ++counters_[static_cast<std::size_t>(counter) - 1]; }

// R-CM-3.
void ConnectionManager::count_reject(const cip::Status& status) {
    using cip::ConnectionFailure;
    const auto failure = static_cast<ConnectionFailure>(status.extended.empty() ? 0 : status.extended.front());
    switch (failure) {
        case ConnectionFailure::out_of_connections:
        case ConnectionFailure::target_out_of_connections:
            count(Counter::open_resource_rejects);
            break;
        case ConnectionFailure::duplicate_forward_open:
        case ConnectionFailure::null_forward_open_not_supported:
        case ConnectionFailure::ownership_conflict:
        case ConnectionFailure::no_non_listen_only_connection:
        case ConnectionFailure::not_configured_for_off_subnet_multicast:
            count(Counter::open_other_rejects);
            break;
        default:
            count(Counter::open_format_rejects);
            break;
    }
}

}  // namespace servobus::adapter
