#include "adapter/tcp_ip_object.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include "adapter/usable_address.hpp"
#include "adapter/wire_checks.hpp"
#include "cip/path.hpp"
#include "cip/services.hpp"
#include "cip/strings.hpp"

namespace servobus::adapter {
namespace {

constexpr std::uint16_t class_id = 0xF5;
constexpr std::uint16_t ethernet_link_class = 0xF6;

enum Attribute : std::uint16_t {
    status = 1,
    capability = 2,
    control = 3,
    physical_link = 4,
    interface_configuration = 5,
    host_name = 6,
    safety_network_number = 7,
    ttl = 8,
    multicast = 9,
    select_acd = 10,
    last_conflict = 11,
    quick_connect = 12,
    inactivity = 13,
};

constexpr std::array<std::uint16_t, 13> all{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13};

// Not in the manual: they stand in Get_Attributes_All, as its order demands, and answer 0x14 alone (R-TCP-1).
constexpr std::array<std::uint16_t, 4> only_in_all{safety_network_number, ttl, multicast, quick_connect};

constexpr std::uint32_t configured = 1;            // R-TCP-2
constexpr std::uint32_t dhcp_settable_acd = 0x94;  // R-TCP-3
constexpr std::size_t max_domain = 48;
constexpr std::size_t max_host_name = 64;
constexpr std::uint16_t max_inactivity = 3600;
constexpr std::size_t safety_octets = 6;

// The strings of this object are filled up to an even number of octets (R-TYP-5).
void write_padded(cip::Writer& writer, const std::string& text) {
    cip::write_string(writer, text);
    if (text.size() % 2 != 0) writer.u8(0);
}

std::string read_padded(cip::Reader& reader) {
    auto text = cip::read_string(reader);
    if (text.size() % 2 != 0 && reader.remaining() > 0) reader.take(1);
    return text;
}

bool is_host_name(const std::string& text) {
    return std::ranges::all_of(
        text, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.'; });
}

void write_interface(cip::Writer& value, const InterfaceConfiguration& config) {
    value.u32(config.address);
    value.u32(config.mask);
    value.u32(config.gateway);
    value.u32(config.name_server_1);
    value.u32(config.name_server_2);
    write_padded(value, config.domain);
}

// Allocation control 0 (by the algorithm), one group, its address (R-MC-2).
void write_multicast(cip::Writer& value, const InterfaceConfiguration& config) {
    value.u8(0);
    value.u8(0);
    value.u16(1);
    value.u32(multicast_start(config.address, config.mask));
}

}  // namespace

std::uint32_t multicast_start(std::uint32_t address, std::uint32_t mask) {
    constexpr std::uint32_t base = 0xEFC00100;  // 239.192.1.0
    const auto host = address & ~mask;
    return base + ((host - 1) & 0x3FF) * 32;
}

cip::ClassInfo TcpIpObject::info() const {
    return {.class_id = class_id, .revision = 4, .max_instance_attribute = inactivity};
}

bool TcpIpObject::offers(std::uint8_t service) const {
    return service == cip::service::get_attributes_all || service == cip::service::get_attribute_single ||
           service == cip::service::set_attribute_single || service == cip::service::get_attribute_list;
}

std::optional<cip::AttributeAccess> TcpIpObject::attribute(std::uint32_t, std::uint32_t id) const {
    if (id < all.front() || id > all.back() || std::ranges::count(only_in_all, id) > 0) return std::nullopt;
    const bool settable = id == control || id == interface_configuration || id == host_name || id == select_acd ||
                          id == last_conflict || id == inactivity;
    return cip::AttributeAccess{true, settable};
}

std::span<const std::uint16_t> TcpIpObject::attributes_all() const { return all; }

cip::Status TcpIpObject::get(std::uint32_t, std::uint32_t id, cip::Writer& value) const {
    switch (id) {
        case status:
            value.u32(configured);
            break;
        case capability:
            value.u32(dhcp_settable_acd);
            break;
        case control:
            value.u32(static_cast<std::uint32_t>(settings_.method));
            break;
        case physical_link: {
            const auto path = cip::Path::to(ethernet_link_class, 1);
            value.u16(static_cast<std::uint16_t>(path.words()));
            path.write(value);
            break;
        }
        case interface_configuration:
            write_interface(value, state_.interface);
            break;
        case host_name:
            write_padded(value, settings_.host_name);
            break;
        case safety_network_number:
            value.zeros(safety_octets);
            break;
        case ttl:
            value.u8(1);
            break;
        case multicast:
            write_multicast(value, state_.interface);
            break;
        case select_acd:
            value.u8(settings_.select_acd ? 1 : 0);
            break;
        case last_conflict:
            value.bytes(settings_.last_conflict);
            break;
        case quick_connect:
            value.u8(0);
            break;
        case inactivity:
            value.u16(settings_.inactivity_seconds);
            break;
        default:
            return cip::GeneralStatus::attribute_not_supported;
    }
    return {};
}

cip::Status TcpIpObject::set(std::uint32_t, std::uint32_t id, cip::ByteView value) {
    switch (id) {
        case control:
            return set_control(value);
        case interface_configuration:
            return set_interface(value);
        case host_name:
            return set_host_name(value);
        case select_acd:
            return set_select_acd(value);
        case last_conflict:
            return set_last_conflict(value);
        case inactivity:
            return set_inactivity(value);
        default:
            return cip::GeneralStatus::attribute_not_settable;
    }
}

cip::Status TcpIpObject::set_control(cip::ByteView value) {
    const auto wanted = whole_value<std::uint32_t>(value);
    if (!wanted) return wanted.error();
    const auto method = static_cast<AddressMethod>(*wanted);
    const bool known = *wanted <= 0xFF && (method == AddressMethod::stored || method == AddressMethod::dhcp);
    if (!known) return cip::GeneralStatus::invalid_attribute_value;
    // The address that is in force stays, as a stored one (R-TCP-4).
    if (method == AddressMethod::stored && settings_.method != method) settings_.configured = state_.interface;
    settings_.method = method;
    return {};
}

cip::Status TcpIpObject::set_interface(cip::ByteView value) {
    if (settings_.method != AddressMethod::stored) return cip::GeneralStatus::object_state_conflict;
    cip::Reader reader(value);
    InterfaceConfiguration wanted;
    reader.field(wanted.address);
    reader.field(wanted.mask);
    reader.field(wanted.gateway);
    reader.field(wanted.name_server_1);
    reader.field(wanted.name_server_2);
    wanted.domain = read_padded(reader);
    if (const auto wrong = length_status(reader); wrong != cip::GeneralStatus::success) return wrong;
    if (wanted.domain.size() > max_domain) return cip::GeneralStatus::too_much_data;
    if (!is_usable(wanted)) return cip::GeneralStatus::invalid_attribute_value;
    settings_.configured = wanted;
    state_.interface = std::move(wanted);
    return {};
}

cip::Status TcpIpObject::set_host_name(cip::ByteView value) {
    cip::Reader reader(value);
    auto wanted = read_padded(reader);
    if (const auto wrong = length_status(reader); wrong != cip::GeneralStatus::success) return wrong;
    if (wanted.size() > max_host_name) return cip::GeneralStatus::too_much_data;
    if (!is_host_name(wanted)) return cip::GeneralStatus::invalid_attribute_value;
    settings_.host_name = std::move(wanted);
    return {};
}

cip::Status TcpIpObject::set_select_acd(cip::ByteView value) {
    const auto wanted = whole_value<std::uint8_t>(value);
    if (!wanted) return wanted.error();
    if (*wanted > 1) return cip::GeneralStatus::invalid_attribute_value;
    settings_.select_acd = *wanted == 1;
    return {};
}

// A conflict can be forgotten, not invented (R-TCP-10).
cip::Status TcpIpObject::set_last_conflict(cip::ByteView value) {
    const auto wrong = length_status(value, settings_.last_conflict.size());
    if (wrong != cip::GeneralStatus::success) return wrong;
    if (std::ranges::any_of(value, [](std::uint8_t octet) { return octet != 0; })) {
        return cip::GeneralStatus::invalid_attribute_value;
    }
    settings_.last_conflict = {};
    return {};
}

cip::Status TcpIpObject::set_inactivity(cip::ByteView value) {
    const auto wanted = whole_value<std::uint16_t>(value);
    if (!wanted) return wanted.error();
    if (*wanted > max_inactivity) return cip::GeneralStatus::invalid_attribute_value;
    settings_.inactivity_seconds = *wanted;
    return {};
}

}  // namespace servobus::adapter
