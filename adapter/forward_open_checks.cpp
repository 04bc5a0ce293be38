#include "adapter/forward_open_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "adapter/assembly_object.hpp"
#include "cip/services.hpp"

namespace servobus::adapter {
namespace {

using assemblies::Connection;
using cip::ConnectionFailure;
using cip::ConnectionType;
using std::chrono::microseconds;

constexpr std::uint8_t last_multiplier_code = 7;
constexpr std::uint8_t last_trigger = 2;
constexpr std::uint16_t backplane_port = 1;
constexpr std::uint16_t network_port = 2;  // the Ethernet side, as the Port object numbers it (R-PRT-1)

OpenRefusal refusal(cip::Status status, std::string words = {}) { return {std::move(status), std::move(words)}; }

cip::Status with_word(ConnectionFailure failure, std::size_t word) {
    return {cip::GeneralStatus::connection_failure,
            {static_cast<std::uint16_t>(failure), static_cast<std::uint16_t>(word)}};
}

// A hop that ends at this node: port 1 address 0, as originators write for "the device itself" (R-CM-9).
bool is_self(const cip::PortSegment& hop) { return hop.port == backplane_port && hop.link_address == cip::Bytes{0}; }

// This device routes nowhere: the port does not exist, or nobody is at that address behind it.
ConnectionFailure no_route(const cip::PortSegment& hop) {
    if (hop.port != backplane_port && hop.port != network_port) return ConnectionFailure::port_not_available;
    return ConnectionFailure::link_address_not_valid;
}

OpenRefusal key_refusal(ConnectionFailure failure, const cip::ElectronicKey& key, const cip::NodeIdentity& node) {
    return refusal(failure, fmt::format("the electronic key asks for vendor {}, device type {}, product code 0x{:04X}, "
                                        "revision {}.{}; this is vendor {}, device type {}, product code 0x{:04X}, "
                                        "revision {}.{}",
                                        key.vendor, key.device_type, key.product_code, key.major_revision & 0x7F,
                                        key.minor_revision, node.vendor, node.device_type, node.product_code,
                                        node.major_revision, node.minor_revision));
}

// The application paths behind the key, in the order in which they stand.
struct ApplicationPaths {
    std::vector<std::uint32_t> points;  ///< configuration (when there are three), consumed, produced
    std::size_t configuration_octets = 0;
};

OpenResult<ApplicationPaths> application_paths(std::span<const cip::Segment> segments) {
    const auto malformed = [](std::string words) {
        return refusal(ConnectionFailure::invalid_path_segment, std::move(words));
    };
    ApplicationPaths paths;
    bool in_assembly = false;
    for (const auto& segment : segments) {
        if (std::holds_alternative<cip::NetworkSegment>(segment)) continue;
        if (const auto* data = std::get_if<cip::DataSegment>(&segment)) {
            paths.configuration_octets += data->data.size();
            continue;
        }
        const auto* logical = std::get_if<cip::LogicalSegment>(&segment);
        if (logical == nullptr) return malformed("the path has a segment that no I/O connection has");
        if (logical->type == cip::LogicalType::class_id) {
            if (logical->value != cip::class_id::assembly) {
                return malformed(
                    fmt::format("the path leads to class 0x{:02X}; I/O connections lead to class 0x04, "
                                "Assembly",
                                logical->value));
            }
            in_assembly = true;
            continue;
        }
        // A connection point is an instance of the assembly (R-CON-10).
        const bool is_point =
            logical->type == cip::LogicalType::instance || logical->type == cip::LogicalType::connection_point;
        if (!is_point || !in_assembly) return malformed("the path is not class 0x04 and then its connection points");
        paths.points.push_back(logical->value);
    }
    constexpr std::size_t most_points = 3;
    if (paths.points.empty() || paths.points.size() > most_points) {
        return malformed(
            fmt::format("the path has {} connection points; it needs the configuration's (or none), the "
                        "O->T point and the T->O point",
                        paths.points.size()));
    }
    return paths;
}

std::string known_pairs() {
    std::string text;
    for (const auto& each : assemblies::connections()) {
        text += fmt::format("{}{}/{}", text.empty() ? "" : ", ", each.o_to_t_point, each.t_to_o_point);
    }
    return text;
}

// R-CON-9, R-CON-12, and the finer codes of R-CON-40 for points that do not exist.
OpenResult<const Connection*> check_points(const ApplicationPaths& paths) {
    const auto& points = paths.points;
    if (points.size() == 1) {
        return refusal(
            ConnectionFailure::inconsistent_path_combination,
            fmt::format("the path has one connection point, {}; it needs one for O->T and one for T->O", points[0]));
    }
    const auto o_to_t = points[points.size() - 2];
    const auto t_to_o = points[points.size() - 1];
    if (const auto* found = assemblies::find_connection(o_to_t, t_to_o)) return found;
    const bool consumed = is_assembly_instance(o_to_t);
    const bool produced = is_assembly_instance(t_to_o);
    const auto failure = consumed && produced ? ConnectionFailure::inconsistent_path_combination
                         : consumed           ? ConnectionFailure::invalid_producing_path
                         : produced           ? ConnectionFailure::invalid_consuming_path
                                              : ConnectionFailure::invalid_application_path;
    return refusal(failure, fmt::format("O->T {} with T->O {} is no connection of this device; these are: {}", o_to_t,
                                        t_to_o, known_pairs()));
}

std::string direction_text(std::string_view direction, cip::RealTimeFormat format, std::size_t data,
                           std::size_t expected, std::size_t came, std::uint32_t point) {
    const auto header = format == cip::RealTimeFormat::header32 ? " + 4 run/idle header" : "";
    return fmt::format("{} size {} asked, {} expected: {} of assembly {} + 2 sequence count{}", direction, came,
                       expected, data, point, header);
}

OpenResult<void> check_sizes(const cip::ForwardOpen& open, const Connection& connection,
                             std::size_t configuration_octets) {
    if (configuration_octets > 0) {
        return refusal(
            with_word(ConnectionFailure::invalid_configuration_size, 0),
            fmt::format("{} octets of configuration data came; this device takes none", configuration_octets));
    }
    const auto data_of = [](const assemblies::Layout* layout) { return layout != nullptr ? layout->size() : 0; };
    if (open.o_to_t.size != connection.o_to_t_size()) {
        return refusal(with_word(ConnectionFailure::invalid_o_to_t_size, connection.o_to_t_size()),
                       direction_text("O->T", connection.o_to_t_format(), data_of(connection.outputs()),
                                      connection.o_to_t_size(), open.o_to_t.size, connection.o_to_t_point));
    }
    if (open.t_to_o.size != connection.t_to_o_size()) {
        return refusal(with_word(ConnectionFailure::invalid_t_to_o_size, connection.t_to_o_size()),
                       direction_text("T->O", connection.t_to_o_format(), data_of(connection.inputs()),
                                      connection.t_to_o_size(), open.t_to_o.size, connection.t_to_o_point));
    }
    return {};
}

OpenResult<microseconds> check_inhibit(const cip::ForwardOpen& open, const cip::Path& path) {
    if (open.transport.trigger == static_cast<std::uint8_t>(enip::Trigger::cyclic)) return microseconds{0};
    constexpr std::uint32_t default_share = 4;
    const auto asked = cip::production_inhibit_time(path);
    if (asked && *asked > open.t_to_o_rpi) {
        return refusal(
            ConnectionFailure::rpi_below_inhibit_time,
            fmt::format("the production inhibit time is {} us and the T->O interval {} us", *asked, open.t_to_o_rpi));
    }
    return microseconds{asked.value_or(open.t_to_o_rpi / default_share)};
}

}  // namespace

bool is_null(const cip::ForwardOpen& open) {
    return open.o_to_t.type == ConnectionType::null && open.t_to_o.type == ConnectionType::null;
}

OpenResult<void> check_transport(const cip::ForwardOpen& open) {
    const auto transport_class = open.transport.transport_class;
    if ((transport_class != io_class && transport_class != explicit_class) || open.transport.trigger > last_trigger) {
        return refusal(
            ConnectionFailure::class_trigger_not_supported,
            fmt::format("transport class {} with trigger {} asked; there are class 1 (I/O) and 3 (explicit), "
                        "and triggers 0 (cyclic), 1 (change of state) and 2 (application)",
                        transport_class, open.transport.trigger));
    }
    if (open.timeout_multiplier > last_multiplier_code) {
        return refusal(
            ConnectionFailure::timeout_multiplier_not_acceptable,
            fmt::format("timeout multiplier code {} asked; 0 to 7 (4 to 512) exist", open.timeout_multiplier));
    }
    if (open.o_to_t.type != ConnectionType::point_to_point) {
        return refusal(ConnectionFailure::invalid_o_to_t_type, "O->T is point-to-point, and nothing else");
    }
    const bool multicast_is_fine = transport_class == io_class && open.t_to_o.type == ConnectionType::multicast;
    if (open.t_to_o.type != ConnectionType::point_to_point && !multicast_is_fine) {
        return refusal(ConnectionFailure::invalid_t_to_o_type, transport_class == io_class
                                                                   ? "T->O is point-to-point or multicast"
                                                                   : "T->O of class 3 is point-to-point");
    }
    if (open.o_to_t.redundant_owner) {
        return refusal(ConnectionFailure::redundant_owner_not_supported, "there are no redundant owners here");
    }
    return {};
}

OpenResult<void> check_rpi(const cip::ForwardOpen& open, std::uint32_t largest) {
    using assemblies::smallest_rpi;
    const auto words = [&] {
        return fmt::format("{} us O->T and {} us T->O asked; at least {} us{}", open.o_to_t_rpi, open.t_to_o_rpi,
                           smallest_rpi, largest > 0 ? fmt::format(" and at most {} us", largest) : "");
    };
    if (open.o_to_t_rpi == 0 || open.t_to_o_rpi == 0) return refusal(ConnectionFailure::rpi_not_supported, words());
    const auto kind = [&](std::uint32_t rpi) {
        if (rpi < smallest_rpi) return cip::RpiKind::minimum;
        return largest > 0 && rpi > largest ? cip::RpiKind::maximum : cip::RpiKind::acceptable;
    };
    const auto best = [&](std::uint32_t rpi) {
        return std::clamp(rpi, smallest_rpi, largest > 0 ? largest : std::max(rpi, smallest_rpi));
    };
    const cip::RpiRefusal wanted{kind(open.o_to_t_rpi), kind(open.t_to_o_rpi), best(open.o_to_t_rpi),
                                 best(open.t_to_o_rpi)};
    if (wanted.o_to_t_kind == cip::RpiKind::acceptable && wanted.t_to_o_kind == cip::RpiKind::acceptable) {
        return {};
    }
    return refusal(wanted.status(), words());
}

OpenResult<std::span<const cip::Segment>> check_key(const cip::Path& path, const cip::NodeIdentity& node) {
    std::span<const cip::Segment> segments = path.segments;
    if (!segments.empty()) {
        if (const auto* hop = std::get_if<cip::PortSegment>(&segments.front())) {
            if (!is_self(*hop)) return refusal(no_route(*hop), "this device routes nowhere");
            segments = segments.subspan(1);
        }
    }
    if (!segments.empty()) {
        if (const auto* key = std::get_if<cip::ElectronicKey>(&segments.front())) {
            if (const auto failure = cip::mismatch(*key, node)) return key_refusal(*failure, *key, node);
            segments = segments.subspan(1);
        }
    }
    return segments;
}

cip::Status check_route(cip::ByteView route) {
    const auto path = cip::Path::parse(route);
    if (!path) return cip::GeneralStatus::path_segment_error;
    if (path->segments.empty()) return {};
    const auto* hop = std::get_if<cip::PortSegment>(&path->segments.front());
    if (hop == nullptr) return cip::GeneralStatus::path_segment_error;
    if (path->segments.size() == 1 && is_self(*hop)) return {};
    return no_route(*hop);
}

OpenResult<IoOpen> check_io_open(const cip::ForwardOpen& open, const cip::NodeIdentity& node) {
    if (const auto sound = check_transport(open); !sound) return sound.error();
    const auto path = cip::Path::parse(open.path);
    if (!path) return refusal(ConnectionFailure::invalid_path_segment, "the connection path is malformed");
    const auto segments = check_key(*path, node);
    if (!segments) return segments.error();
    const auto points = application_paths(*segments);
    if (!points) return points.error();
    const auto connection = check_points(*points);
    if (!connection) return connection.error();
    if (const auto sound = check_rpi(open, assemblies::largest_rpi); !sound) return sound.error();
    const auto inhibit = check_inhibit(open, *path);
    if (!inhibit) return inhibit.error();
    if (const auto sound = check_sizes(open, **connection, points->configuration_octets); !sound) return sound.error();
    return IoOpen{*connection, static_cast<enip::Trigger>(open.transport.trigger), *inhibit};
}

}  // namespace servobus::adapter
