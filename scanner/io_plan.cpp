#include "scanner/io_plan.hpp"

#include <algorithm>
#include <limits>

#include "assemblies/layout.hpp"
#include "cip/services.hpp"

namespace servobus::scanner {
namespace {

/// What the 16-bit parameters can say (R-CON-3); more needs a Large_Forward_Open.
constexpr std::size_t largest_small_size = 511;

std::uint32_t microseconds(std::chrono::microseconds time) {
    return static_cast<std::uint32_t>(
        std::clamp<std::int64_t>(time.count(), 0, std::numeric_limits<std::uint32_t>::max()));
}

cip::Path connection_manager() { return cip::Path::to(cip::class_id::connection_manager, 1); }

IoDirection direction(std::uint32_t point, const assemblies::Layout* layout, cip::RealTimeFormat format) {
    IoDirection made;
    made.point = point;
    made.data_octets = layout != nullptr ? layout->size() : 0;
    made.format = format;
    return made;
}

}  // namespace

cip::ConnectionParameters IoDirection::parameters(bool redundant_owner) const {
    if (type == cip::ConnectionType::null) return {.type = type, .priority = priority};
    return {.redundant_owner = redundant_owner,
            .type = type,
            .priority = priority,
            .variable = variable,
            .size = static_cast<std::uint16_t>(connection_size())};
}

bool IoPlan::needs_large() const {
    return large || std::max(o_to_t.connection_size(), t_to_o.connection_size()) > largest_small_size;
}

cip::Path IoPlan::path() const {
    auto path = route;
    auto& segments = path.segments;
    if (key) segments.emplace_back(*key);
    if (inhibit) segments.emplace_back(cip::production_inhibit_segment(microseconds(*inhibit)));
    if (application_path) {
        segments.insert(segments.end(), application_path->segments.begin(), application_path->segments.end());
    } else {
        segments.emplace_back(cip::logical(cip::LogicalType::class_id, cip::class_id::assembly));
        if (configuration_instance) {
            segments.emplace_back(cip::logical(cip::LogicalType::instance, *configuration_instance));
        }
        segments.emplace_back(cip::logical(cip::LogicalType::connection_point, o_to_t.point));
        segments.emplace_back(cip::logical(cip::LogicalType::connection_point, t_to_o.point));
    }
    if (!configuration.empty()) segments.emplace_back(cip::DataSegment{configuration});
    return path;
}

cip::ForwardOpen IoPlan::forward_open(std::uint32_t o_to_t_id, std::uint32_t t_to_o_id,
                                      const cip::ConnectionTriad& triad) const {
    cip::ForwardOpen open;
    open.large = needs_large();
    open.o_to_t_id = o_to_t_id;
    open.t_to_o_id = t_to_o_id;
    open.triad = triad;
    open.timeout_multiplier = multiplier_code;
    open.o_to_t_rpi = microseconds(o_to_t.rpi);
    open.o_to_t = o_to_t.parameters(redundant_owner);
    open.t_to_o_rpi = microseconds(t_to_o.rpi);
    open.t_to_o = t_to_o.parameters();
    open.transport = {.trigger = static_cast<std::uint8_t>(trigger), .transport_class = 1};
    open.path = path().encode();
    return open;
}

cip::Request open_request(const cip::ForwardOpen& open) {
    const auto service = open.large ? cip::service::large_forward_open : cip::service::forward_open;
    return {service, connection_manager(), open.encode()};
}

cip::Request close_request(const cip::ForwardOpen& open) {
    cip::ForwardClose close;
    close.triad = open.triad;
    close.path = open.path;
    return {cip::service::forward_close, connection_manager(), close.encode()};
}

IoPlan plan_of(const assemblies::Connection& connection) {
    IoPlan plan;
    plan.o_to_t = direction(connection.o_to_t_point, connection.outputs(), connection.o_to_t_format());
    plan.t_to_o = direction(connection.t_to_o_point, connection.inputs(), connection.t_to_o_format());
    return plan;
}

}  // namespace servobus::scanner
