#include "adapter/time_sync_object.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "adapter/wire_checks.hpp"
#include "cip/services.hpp"

namespace servobus::adapter {
namespace {

enum Attribute : std::uint16_t {
    ptp_enable = 1,
    is_synchronized_now = 2,
    system_time_microseconds = 3,
    system_time_nanoseconds = 4,
    offset_from_master_now = 5,
    max_offset_from_master = 6,
    mean_path_delay_to_master = 7,
    grandmaster_clock_info = 8,
    parent_clock_info = 9,
    local_clock_info = 10,
    number_of_ports = 11,
    port_state_info = 12,
    port_enable_cfg = 13,
    port_log_announce_interval_cfg = 14,
    port_log_sync_interval_cfg = 15,
    priority_1 = 16,
    priority_2 = 17,
    domain_number = 18,
    clock_type = 19,
    manufacture_identity = 20,
    product_description_text = 21,
    revision_data_text = 22,
    user_description = 23,
    port_profile_identity_info = 24,
    port_physical_address_info = 25,
    port_protocol_address_info = 26,
    steps_removed = 27,
    system_time_and_offset = 28,
};

constexpr std::uint16_t revision = 3;
constexpr std::string_view manufacturer = "Jenny Science AG";
constexpr std::uint16_t no_steps = 65535;  // R-TSY-3
constexpr std::size_t profile_octets = 8;
constexpr std::size_t text_octets = 16;
constexpr std::size_t address_octets = 16;
constexpr std::size_t max_user_description = 128;

std::uint64_t count_of(std::chrono::nanoseconds time) { return static_cast<std::uint64_t>(time.count()); }
std::uint64_t microseconds_of(std::chrono::nanoseconds time) {
    return static_cast<std::uint64_t>(std::chrono::floor<std::chrono::microseconds>(time).count());
}

// EUI-64 of a MAC address (IEEE 1588, 7.5.2.2.2).
ClockIdentity identity_of(const MacAddress& mac) {
    return {mac[0], mac[1], mac[2], 0xFF, 0xFE, mac[3], mac[4], mac[5]};
}

// A clock that hears of no other is its own grandmaster (8.2.3).
PtpNode lone_node(const MacAddress& mac) {
    PtpNode node;
    node.own.identity = identity_of(mac);
    node.parent.parent.clock = node.own.identity;
    node.parent.grandmaster = node.own.identity;
    return node;
}

void write_quality(cip::Writer& value, const ClockQuality& quality) {
    value.u16(quality.clock_class);
    value.u16(quality.accuracy);
    value.u16(quality.variance);
}

void write_time_properties(cip::Writer& value, const TimePropertiesDataSet& time) {
    value.little(time.utc_offset);
    value.u16(time.flags);
    value.u16(time.time_source);
}

// UDINT size, then the octets.
void write_text(cip::Writer& value, std::string_view text) {
    value.u32(static_cast<std::uint32_t>(text.size()));
    value.bytes({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

// Octets in an array of fixed size: the rest is zero, what does not fit is left out.
void write_array(cip::Writer& value, cip::ByteView octets, std::size_t size) {
    const auto taken = octets.first(std::min(octets.size(), size));
    value.bytes(taken);
    value.zeros(size - taken.size());
}

// UINT count, then of each port its number and what `write` adds.
template <class Ports, class Write>
void write_ports(cip::Writer& value, const Ports& ports, Write write) {
    value.u16(static_cast<std::uint16_t>(ports.size()));
    for (const auto& port : ports) {
        value.u16(port.data.identity.port);
        write(port);
    }
}

std::vector<PtpPort> described(const std::vector<PtpPort>& ports) {
    std::vector<PtpPort> found;
    std::ranges::copy_if(ports, std::back_inserter(found), [](const PtpPort& port) { return !!port.description; });
    return found;
}

void write_physical_address(cip::Writer& value, const ClockDescription& description) {
    const auto& protocol = description.physical_protocol;
    write_array(value, {reinterpret_cast<const std::uint8_t*>(protocol.data()), protocol.size()}, text_octets);
    value.u16(static_cast<std::uint16_t>(std::min(description.physical_address.size(), address_octets)));
    write_array(value, description.physical_address, address_octets);
}

void write_protocol_address(cip::Writer& value, const ClockDescription& description) {
    value.u16(description.network_protocol);
    value.u16(static_cast<std::uint16_t>(std::min(description.protocol_address.size(), address_octets)));
    write_array(value, description.protocol_address, address_octets);
}

// The first octet of PTP's is the first one here: bit 7 ordinary clock, 6 boundary clock, 5 and 4 transparent clocks, 3
// management node. Bit 8 is CIP's own.
std::uint16_t clock_type_of(const PtpNode& node) {
    constexpr unsigned slave_only = 0x0100;
    const auto found = std::ranges::find_if(node.ports, [](const PtpPort& port) { return !!port.description; });
    const unsigned type = found != node.ports.end() ? found->description->clock_type >> 8U : 0U;
    return static_cast<std::uint16_t>(type | (node.own.slave_only ? slave_only : 0U));
}

std::string user_description_of(const std::vector<PtpPort>& ports) {
    const auto found = std::ranges::find_if(ports, [](const PtpPort& port) { return !!port.description; });
    return found != ports.end() ? found->description->user_description.substr(0, max_user_description) : std::string();
}

}  // namespace

cip::ClassInfo TimeSyncObject::info() const {
    return {.class_id = 0x43, .revision = revision, .max_instance_attribute = system_time_and_offset};
}

bool TimeSyncObject::offers(std::uint8_t service) const {
    return service == cip::service::get_attribute_single || service == cip::service::set_attribute_single ||
           service == cip::service::get_attribute_list || service == cip::service::set_attribute_list;
}

// Nobody tells the manufacturer's OUI. What belongs to the node of this machine is set there and not here.
std::optional<cip::AttributeAccess> TimeSyncObject::attribute(std::uint32_t, std::uint32_t id) const {
    if (id < ptp_enable || id > system_time_and_offset || id == manufacture_identity) return std::nullopt;
    return cip::AttributeAccess{.settable = id == ptp_enable || id == max_offset_from_master};
}

// Where PTP is disabled, or nobody does it here, there is a clock that hears of no other.
PtpNode TimeSyncObject::node() const {
    return settings().enabled && known_.node ? *known_.node : lone_node(network_.state.mac);
}

// R-TSY-3.
bool TimeSyncObject::is_synchronized(const PtpNode& node) const {
    const auto offset = offset_from_master(node).count();
    const auto magnitude = static_cast<std::uint64_t>(offset < 0 ? -offset : offset);
    return has_master(node) && magnitude < settings().max_offset_from_master;
}

// Manufacturer, model, serial number.
std::string TimeSyncObject::product_description() const {
    return fmt::format("{};{};{:08X}", manufacturer, identity_.product_name, identity_.serial_number);
}

// Of the hardware, the firmware, the software; the first and the last are not known.
std::string TimeSyncObject::revision_data() const {
    return fmt::format(";{}.{};", identity_.major_revision, identity_.minor_revision);
}

// R-TSY-1, R-TSY-2.
cip::Status TimeSyncObject::get(std::uint32_t, std::uint32_t id, cip::Writer& value) const {
    const auto node = this->node();
    const auto& ports = node.ports;
    switch (id) {
        case ptp_enable:
            value.u8(settings().enabled ? 1 : 0);
            break;
        case is_synchronized_now:
            value.u8(is_synchronized(node) ? 1 : 0);
            break;
        case system_time_microseconds:
            value.u64(microseconds_of(system_time()));
            break;
        case system_time_nanoseconds:
            value.u64(count_of(system_time()));
            break;
        case offset_from_master_now:
            value.u64(count_of(offset_from_master(node)));
            break;
        case max_offset_from_master:
            value.u64(settings().max_offset_from_master);
            break;
        case mean_path_delay_to_master:
            value.u64(count_of(mean_path_delay(node)));
            break;
        case grandmaster_clock_info:
            value.bytes(node.parent.grandmaster);
            write_quality(value, node.parent.grandmaster_quality);
            write_time_properties(value, node.time);
            value.u16(node.parent.grandmaster_priority_1);
            value.u16(node.parent.grandmaster_priority_2);
            break;
        case parent_clock_info:
            value.bytes(node.parent.parent.clock);
            value.u16(node.parent.parent.port);
            value.u16(node.parent.observed_variance);
            value.u32(node.parent.observed_phase_change_rate);
            break;
        case local_clock_info:
            value.bytes(node.own.identity);
            write_quality(value, node.own.quality);
            write_time_properties(value, node.time);  // a node has one set of them
            break;
        case number_of_ports:
            value.u16(static_cast<std::uint16_t>(ports.size()));
            break;
        case port_state_info:
            write_ports(value, ports,
                        [&](const PtpPort& port) { value.u16(static_cast<std::uint16_t>(port.data.state)); });
            break;
        case port_enable_cfg:
            write_ports(value, ports,
                        [&](const PtpPort& port) { value.u16(port.data.state != PtpPortState::disabled ? 1 : 0); });
            break;
        case port_log_announce_interval_cfg:
            write_ports(value, ports,
                        [&](const PtpPort& port) { value.little(std::int16_t{port.data.log_announce_interval}); });
            break;
        case port_log_sync_interval_cfg:
            write_ports(value, ports,
                        [&](const PtpPort& port) { value.little(std::int16_t{port.data.log_sync_interval}); });
            break;
        case priority_1:
            value.u8(node.own.priority_1);
            break;
        case priority_2:
            value.u8(node.own.priority_2);
            break;
        case domain_number:
            value.u8(node.own.domain);
            break;
        case clock_type:
            value.u16(clock_type_of(node));
            break;
        case product_description_text:
            write_text(value, product_description());
            break;
        case revision_data_text:
            write_text(value, revision_data());
            break;
        case user_description:
            write_text(value, user_description_of(ports));
            break;
        case port_profile_identity_info:
            write_ports(value, described(ports),
                        [&](const PtpPort& port) { write_array(value, port.description->profile, profile_octets); });
            break;
        case port_physical_address_info:
            write_ports(value, described(ports),
                        [&](const PtpPort& port) { write_physical_address(value, *port.description); });
            break;
        case port_protocol_address_info:
            write_ports(value, described(ports),
                        [&](const PtpPort& port) { write_protocol_address(value, *port.description); });
            break;
        case steps_removed:
            value.u16(has_master(node) ? node.current.steps_removed : no_steps);
            break;
        case system_time_and_offset:
            value.u64(microseconds_of(system_time()));
            value.u64(microseconds_of(ahead_));
            break;
        default:
            return cip::GeneralStatus::attribute_not_supported;
    }
    return {};
}

cip::Status TimeSyncObject::set(std::uint32_t, std::uint32_t id, cip::ByteView value) {
    if (id == ptp_enable) {
        const auto wanted = whole_value<std::uint8_t>(value);
        if (!wanted) return wanted.error();
        if (*wanted > 1) return cip::GeneralStatus::invalid_attribute_value;
        settings().enabled = *wanted == 1;
        return {};
    }
    const auto wanted = whole_value<std::uint64_t>(value);
    if (!wanted) return wanted.error();
    // With 0 the clock would never be synchronised.
    if (*wanted == 0) return cip::GeneralStatus::invalid_attribute_value;
    settings().max_offset_from_master = *wanted;
    return {};
}

std::optional<std::size_t> TimeSyncObject::value_size(std::uint32_t, std::uint32_t id, cip::ByteView) const {
    if (id == ptp_enable) return sizeof(std::uint8_t);
    if (id == max_offset_from_master) return sizeof(std::uint64_t);
    return std::nullopt;
}

}  // namespace servobus::adapter
