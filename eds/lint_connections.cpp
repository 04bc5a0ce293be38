#include <fmt/format.h>

#include <unordered_map>

#include "eds/field_values.hpp"
#include "eds/lint_rules.hpp"

namespace servobus::eds {
namespace {

constexpr std::size_t fields_of_a_connection = 15;
constexpr std::size_t with_safety = 17;

class ConnectionCheck {
public:
    ConnectionCheck(const DataSheet& sheet, const Connection& connection, Notes& notes)
        : sheet_(sheet), connection_(connection), notes_(notes) {}

    void run() {
        check_transport();
        check_direction("O->T", connection_.parameters.o_to_t(), connection_.o_to_t);
        check_direction("T->O", connection_.parameters.t_to_o(), connection_.t_to_o);
        if ((connection_.parameters.bits & ParameterWord::reserved_bits) != 0) {
            error(fmt::format("the parameters 0x{:08X} have reserved bits", connection_.parameters.bits));
        }
        check_ownership();
        check_part("the proxy's configuration", connection_.proxy_configuration);
        check_part("the target's configuration", connection_.target_configuration);
        if (connection_.path.empty()) error("there is no path");
        check_path(sheet_, connection_.path, connection_.line, connection_.keyword, notes_);
    }

private:
    void error(std::string_view words) {
        notes_.error(connection_.line, fmt::format("{}: {}", connection_.keyword, words));
    }
    void warning(std::string_view words) {
        notes_.warning(connection_.line, fmt::format("{}: {}", connection_.keyword, words));
    }

    void check_transport() {
        const auto& word = connection_.transport;
        if ((word.bits & TransportWord::reserved_bits) != 0) {
            error(fmt::format("trigger and transport 0x{:08X} have reserved bits", word.bits));
        }
        if (!word.ownership()) {
            error(
                "exactly one of the bits 24 to 27 has to be set: listen only, input only, exclusive or redundant "
                "owner");
        }
        if ((word.bits & TransportWord::class_bits) == 0) error("no transport class is allowed");
        if ((word.bits & TransportWord::trigger_bits) == 0) error("no trigger is allowed");
    }

    void check_direction(std::string_view name, const DirectionBits& bits, const Flow& flow) {
        using cip::RealTimeFormat;
        constexpr std::uint8_t safety = 5;
        if (!bits.fixed && !bits.variable) error(fmt::format("{} has neither a fixed nor a variable size", name));
        if (!bits.null && !bits.multicast && !bits.point_to_point)
            error(fmt::format("{} has no connection type", name));
        if (bits.priorities == 0) warning(fmt::format("{} has no priority", name));
        const bool format_exists = bits.is(RealTimeFormat::modeless) || bits.is(RealTimeFormat::zero_length) ||
                                   bits.is(RealTimeFormat::heartbeat) || bits.is(RealTimeFormat::header32) ||
                                   bits.format == safety;
        if (!format_exists) error(fmt::format("{} has the reserved format {}", name, bits.format));
        if (bits.is(RealTimeFormat::zero_length) && !bits.variable) {
            error(fmt::format("{} tells idle by a length of zero, and has no variable size", name));
        }
        if (bits.is(RealTimeFormat::heartbeat) && flow.size.maximum.value_or(0) > 0) {
            error(fmt::format("{} is a heartbeat, and has {} octets", name, *flow.size.maximum));
        }
        if (flow.size == Range{} && !bits.is(RealTimeFormat::heartbeat)) {
            warning(fmt::format("neither size nor format tell how many octets {} has", name));
        }
        check_interval(name, flow.rpi);
        check_size(name, flow.size, flow.format);
    }

    void check_interval(std::string_view name, const Range& rpi) {
        if (rpi.minimum == 0U || rpi.standard == 0U) warning(fmt::format("the interval of {} may be 0", name));
        const auto* parameter = rpi.parameter ? sheet_.parameter(*rpi.parameter) : nullptr;
        if (parameter == nullptr || parameter->type == cip::DataType::UDINT) return;
        warning(fmt::format("the interval of {} is Param{}, which is no UDINT", name, *rpi.parameter));
    }

    // What is stated against what the format has.
    void check_size(std::string_view name, const Range& size, const std::string& format) {
        const auto* assembly = sheet_.assembly(format);
        if (assembly == nullptr || !assembly->size || !size.maximum) return;
        const auto octets = *assembly->size;
        if (!size.parameter && *size.maximum != octets) {
            error(fmt::format("{} has {} octets, and {} has {}", name, *size.maximum, format, octets));
        } else if (size.parameter && *size.maximum > octets) {
            warning(fmt::format("{} has up to {} octets, and {} has {}", name, *size.maximum, format, octets));
        }
    }

    void check_part(std::string_view name, const ConfigurationPart& part) { check_size(name, part.size, part.format); }

    // Who only looks sends no data; who listens needs what others are sent.
    void check_ownership() {
        const auto ownership = connection_.transport.ownership();
        if (!ownership) return;
        const bool looks = *ownership == Ownership::listen_only || *ownership == Ownership::input_only;
        const bool heartbeat = connection_.parameters.o_to_t().is(cip::RealTimeFormat::heartbeat);
        if (looks && !heartbeat && connection_.o_to_t.size.maximum.value_or(0) > 0) {
            warning("who only looks should send a heartbeat, and O->T has data");
        }
        if (!looks && heartbeat) warning("an owner should send data, and O->T is a heartbeat");
        if (*ownership == Ownership::listen_only && !connection_.parameters.t_to_o().multicast) {
            error("who only listens joins a multicast, and T->O has none");
        }
    }

    const DataSheet& sheet_;
    const Connection& connection_;
    Notes& notes_;
};

void check_names(const DataSheet& sheet, Notes& notes) {
    std::unordered_map<std::string, std::string_view> seen;
    for (const auto& connection : sheet.connections) {
        if (connection.name.empty()) {
            notes.error(connection.line,
                        fmt::format("{}: there is no name, by which it is chosen", connection.keyword));
            continue;
        }
        const auto [first, is_new] = seen.try_emplace(lower_case(connection.name), connection.keyword);
        if (is_new) continue;
        notes.error(connection.line, fmt::format("{} has the name of {}, {}", connection.keyword, first->second,
                                                 shown(connection.name)));
    }
}

void check_fields(const Entry& entry, Notes& notes) {
    const auto count = entry.fields.size();
    if (count >= fields_of_a_connection && count <= with_safety) return;
    notes.error(entry.line,
                fmt::format("{} has {} fields, where {} belong", entry.keyword, count, fields_of_a_connection));
}

void check_yes_or_no(const Entry& entry, Notes& notes) {
    const auto& value = entry.field(1).value;
    if (value == "Yes" || value == "No") return;
    notes.error(entry.line, fmt::format("{} is '{}', and Yes or No can be", entry.keyword, shown(value)));
}

}  // namespace

void lint_connections(const Sheet& sheet, Notes& notes) {
    for (const auto& connection : sheet.read.connections) ConnectionCheck(sheet.read, connection, notes).run();
    check_names(sheet.read, notes);
    const std::string manager = "Connection Manager";
    for (const auto* entry : numbered(sheet.document, manager, "Connection")) check_fields(*entry, notes);
    for (const auto* keyword : {"PITNS", "PITNS_usec"}) {
        if (const auto* entry = sheet.document.find(manager, keyword)) check_yes_or_no(*entry, notes);
    }
}

}  // namespace servobus::eds
