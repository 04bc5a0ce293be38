#include "scanner/sheet_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>

#include "cip/services.hpp"
#include "scanner/connection_path.hpp"
#include "scanner/io_words.hpp"

namespace servobus::scanner {
namespace {

using cip::ConnectionType;
using cip::Priority;
using cip::RealTimeFormat;
using std::chrono::microseconds;

constexpr microseconds usual_interval{10'000};

// ------------------------------------------------------------------------------------------------- which connection

std::string list_of(const eds::DataSheet& sheet) {
    constexpr std::size_t worth_listing = 20;
    std::string text;
    for (std::size_t i = 0; i < std::min(sheet.connections.size(), worth_listing); ++i) {
        const auto& each = sheet.connections[i];
        text += fmt::format("{}'{}' ({})", i > 0 ? ", " : "", each.name, each.keyword);
    }
    if (sheet.connections.size() > worth_listing) {
        text += fmt::format(" and {} more", sheet.connections.size() - worth_listing);
    }
    return text;
}

std::optional<std::uint32_t> number_of(std::string_view text) {
    std::uint32_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return number;
}

std::vector<const eds::Connection*> beginning_with(const eds::DataSheet& sheet, std::string_view text) {
    std::vector<const eds::Connection*> found;
    for (const auto& each : sheet.connections) {
        if (eds::same_name(std::string_view(each.name).substr(0, text.size()), text)) found.push_back(&each);
    }
    return found;
}

// ------------------------------------------------------------------------------------------------------- one direction

/// The kinds that a direction may have, the preferred first.
constexpr std::array kinds{ConnectionType::point_to_point, ConnectionType::multicast, ConnectionType::null};
constexpr std::array priorities{Priority::scheduled, Priority::urgent, Priority::high, Priority::low};

bool allows(const eds::DirectionBits& bits, ConnectionType type) {
    switch (type) {
        case ConnectionType::null:
            return bits.null;
        case ConnectionType::multicast:
            return bits.multicast;
        case ConnectionType::point_to_point:
            return bits.point_to_point;
        case ConnectionType::reserved:
            break;
    }
    return false;
}

bool allows(const eds::DirectionBits& bits, Priority priority) {
    return (bits.priorities >> static_cast<unsigned>(priority) & 1) != 0;
}

std::optional<RealTimeFormat> format_of(const eds::DirectionBits& bits) {
    for (const auto& word : format_words) {
        if (bits.is(word.second)) return word.second;
    }
    return std::nullopt;
}

microseconds interval_of(const eds::Range& rpi) {
    if (rpi.standard) return microseconds(*rpi.standard);
    const auto usual = static_cast<std::uint32_t>(usual_interval.count());
    return microseconds(std::clamp(usual, rpi.minimum.value_or(0), rpi.maximum.value_or(UINT32_MAX)));
}

/// The direction as the sheet has it; its point is in the path.
Parsed<IoDirection> direction_of(std::string_view name, const eds::Flow& flow, const eds::DirectionBits& bits) {
    IoDirection direction;
    const auto format = format_of(bits);
    if (!format)
        return Mistake{fmt::format("{}: the real-time format {} is none that is known here", name, bits.format)};
    direction.format = *format;
    const auto kind = std::ranges::find_if(kinds, [&](ConnectionType type) { return allows(bits, type); });
    if (kind == kinds.end())
        return Mistake{fmt::format("{}: the file allows neither multicast nor point-to-point", name)};
    direction.type = *kind;
    const auto priority = std::ranges::find_if(priorities, [&](Priority each) { return allows(bits, each); });
    if (priority != priorities.end()) direction.priority = *priority;
    direction.variable = bits.variable && (!bits.fixed || direction.format == RealTimeFormat::zero_length);
    direction.rpi = interval_of(flow.rpi);
    if (direction.format == RealTimeFormat::heartbeat || direction.type == ConnectionType::null) return direction;
    const auto size = flow.size.standard ? flow.size.standard : flow.size.maximum;
    if (!size) return Mistake{fmt::format("{}: the file does not say how many octets there are", name)};
    if (*size > std::numeric_limits<std::uint16_t>::max()) {
        return Mistake{fmt::format("{}: {} octets are more than a connection can have", name, *size)};
    }
    direction.data_octets = *size;
    return direction;
}

enip::Trigger trigger_of(const eds::TransportWord& transport) {
    if (transport.cyclic()) return enip::Trigger::cyclic;
    if (transport.change_of_state()) return enip::Trigger::change_of_state;
    return transport.application() ? enip::Trigger::application : enip::Trigger::cyclic;
}

bool allows(const eds::TransportWord& transport, enip::Trigger trigger) {
    const bool says = transport.cyclic() || transport.change_of_state() || transport.application();
    switch (trigger) {
        case enip::Trigger::cyclic:
            return transport.cyclic() || !says;
        case enip::Trigger::change_of_state:
            return transport.change_of_state();
        case enip::Trigger::application:
            return transport.application();
    }
    return false;
}

// --------------------------------------------------------------------------------------------------------------- path

/// Points in their usual places make the usual path; any other is taken as it is.
Parsed<IoPlan> with_path(IoPlan plan, const cip::Bytes& octets) {
    const auto path = eds::segments(octets);
    if (!path || path->segments.empty()) return Mistake{"the path of the connection in the file cannot be read"};
    const auto parts = ConnectionPath::read(path->encode());
    plan.configuration_instance = parts.configuration();
    plan.o_to_t.point = parts.o_to_t().value_or(0);
    plan.t_to_o.point = parts.t_to_o().value_or(0);
    auto usual = plan;
    usual.configuration.clear();
    if (usual.path() != *path) plan.application_path = *path;
    return plan;
}

// ---------------------------------------------------------------------------------------------------------- conflicts

std::string interval_text(microseconds interval) {
    return fmt::format("{} ms", static_cast<double>(interval.count()) / 1000);
}

std::string range_text(const eds::Range& range, auto text) {
    if (range.minimum && range.maximum && *range.minimum == *range.maximum) return text(*range.minimum);
    if (!range.maximum) return fmt::format("{} and more", text(range.minimum.value_or(0)));
    return fmt::format("{} to {}", text(range.minimum.value_or(0)), text(*range.maximum));
}

std::optional<Mistake> conflict(std::string_view name, const eds::Flow& flow, const eds::DirectionBits& bits,
                                const IoDirection& direction) {
    const auto wrong = [&](const std::string& what, const std::string& allowed) {
        return Mistake{fmt::format("{}: {}; the file allows {}", name, what, allowed)};
    };
    const auto rpi = static_cast<std::uint32_t>(std::clamp<std::int64_t>(direction.rpi.count(), 0, UINT32_MAX));
    if (!flow.rpi.allows(rpi)) {
        return wrong("an interval of " + interval_text(direction.rpi),
                     range_text(flow.rpi, [](std::uint32_t value) { return interval_text(microseconds(value)); }));
    }
    const bool has_data = direction.format != RealTimeFormat::heartbeat && direction.type != ConnectionType::null;
    if (has_data && !flow.size.allows(static_cast<std::uint32_t>(direction.data_octets))) {
        return wrong(fmt::format("{} octets", direction.data_octets),
                     range_text(flow.size, [](std::uint32_t value) { return fmt::format("{} octets", value); }));
    }
    if (!bits.is(direction.format)) {
        const auto format = format_of(bits);
        return wrong(std::string(cip::name(direction.format)),
                     format ? std::string(cip::name(*format)) : "another format");
    }
    if (!allows(bits, direction.type)) {
        const bool multicast = direction.type == ConnectionType::multicast;
        return wrong(multicast ? "multicast" : "point-to-point", multicast ? "point-to-point" : "multicast");
    }
    if (bits.priorities != 0 && !allows(bits, direction.priority)) {
        std::string allowed;
        for (const auto& word : priority_words) {
            if (allows(bits, word.second)) allowed += fmt::format("{}{}", allowed.empty() ? "" : " or ", word.first);
        }
        return wrong(fmt::format("priority {}", word_of(priority_words, direction.priority)), allowed);
    }
    if (direction.variable && !bits.variable) return wrong("a variable size", "a fixed one");
    return std::nullopt;
}

}  // namespace

Parsed<const eds::Connection*> choose_connection(const eds::DataSheet& sheet, std::string_view text) {
    if (sheet.connections.empty()) return Mistake{"the file has no connection"};
    if (text.empty()) {
        if (sheet.connections.size() == 1) return &sheet.connections.front();
        return Mistake{
            fmt::format("the file has {} connections; write which: {}", sheet.connections.size(), list_of(sheet))};
    }
    if (const auto* exact = sheet.connection(text)) return exact;
    if (const auto number = number_of(text)) {
        if (const auto* numbered = sheet.connection(fmt::format("Connection{}", *number))) return numbered;
    }
    const auto found = beginning_with(sheet, text);
    if (found.size() == 1) return found.front();
    return Mistake{fmt::format("{} connection of the file is called '{}'; there are {}",
                               found.empty() ? "no" : "more than one", text, list_of(sheet))};
}

Parsed<IoPlan> plan_of(const eds::DataSheet& sheet, const eds::Connection& connection) {
    if (!connection.transport.allows_class(1)) {
        return Mistake{
            fmt::format("'{}' is no connection of class 1, and others are not opened here", connection.name)};
    }
    const auto outputs = direction_of("O->T", connection.o_to_t, connection.parameters.o_to_t());
    if (!outputs) return outputs.error();
    const auto inputs = direction_of("T->O", connection.t_to_o, connection.parameters.t_to_o());
    if (!inputs) return inputs.error();
    IoPlan plan;
    plan.o_to_t = *outputs;
    plan.t_to_o = *inputs;
    plan.trigger = trigger_of(connection.transport);
    plan.redundant_owner = connection.transport.is(eds::Ownership::redundant_owner);
    // Who only listens gets what others get (R-CON-32).
    if (connection.transport.is(eds::Ownership::listen_only) && connection.parameters.t_to_o().multicast) {
        plan.t_to_o.type = ConnectionType::multicast;
    }
    plan.configuration = sheet.configuration(connection);
    if (plan.configuration.size() % 2 != 0) plan.configuration.push_back(0);
    const auto octets = sheet.connection_path(connection);
    if (!octets) return Mistake{octets.error()};
    auto whole = with_path(std::move(plan), *octets);
    if (whole && whole->path().words() > cip::max_path_words) {
        return Mistake{"the configuration data of the file is longer than a path can be"};
    }
    return whole;
}

std::optional<Mistake> conflict(const eds::Connection& connection, const IoPlan& plan) {
    if (auto wrong = conflict("O->T", connection.o_to_t, connection.parameters.o_to_t(), plan.o_to_t)) return wrong;
    if (auto wrong = conflict("T->O", connection.t_to_o, connection.parameters.t_to_o(), plan.t_to_o)) return wrong;
    if (allows(connection.transport, plan.trigger)) return std::nullopt;
    std::string allowed;
    for (const auto& word : trigger_words) {
        if (!allows(connection.transport, word.second)) continue;
        allowed += fmt::format("{}{}", allowed.empty() ? "" : " or ", word.first);
    }
    return Mistake{fmt::format("the trigger {}; the file allows {}", word_of(trigger_words, plan.trigger), allowed)};
}

std::optional<cip::ElectronicKey> key_of(const eds::Device& device) {
    if (!device.vendor || !device.product_type || !device.product_code || !device.major_revision) return std::nullopt;
    return cip::ElectronicKey{.vendor = *device.vendor,
                              .device_type = *device.product_type,
                              .product_code = *device.product_code,
                              .major_revision = *device.major_revision,
                              .minor_revision = device.minor_revision.value_or(0)};
}

std::string_view ownership_text(const eds::Connection& connection) {
    const auto ownership = connection.transport.ownership();
    if (!ownership) return "";
    switch (*ownership) {
        case eds::Ownership::listen_only:
            return "listen only";
        case eds::Ownership::input_only:
            return "input only";
        case eds::Ownership::exclusive_owner:
            return "exclusive owner";
        case eds::Ownership::redundant_owner:
            return "redundant owner";
    }
    return "";
}

}  // namespace servobus::scanner
