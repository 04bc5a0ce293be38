#include "adapter/tcp_ip_object.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include "adapter/multicast_groups.hpp"
#include "adapter/usable_address.hpp"
#include "adapter/wire_checks.hpp"
#include "cip/path.hpp"
#include "cip/services.hpp"
#include "cip/strings.hpp"
#include "enip/endpoint.hpp"

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

// They stand in Get_Attributes_All, as its order demands, and answer 0x14 alone (R-TCP-1): nothing is behind them.
constexpr std::array<std::uint16_t, 2> only_in_all{safety_network_number, quick_connect};
constexpr std::array<std::uint16_t, 8> settable{control,    interface_configuration, host_name, ttl, multicast,
                                                select_acd, last_conflict,           inactivity};

// Status (R-TCP-2).
constexpr std::uint32_t configured = 1;
constexpr std::uint32_t change_pending = 1U << 5;
constexpr std::uint32_t conflict_now = 1U << 6;
constexpr std::uint32_t no_address_left = 1U << 7;
// Capability (R-TCP-3).
constexpr std::uint32_t bootp_too = 1;
constexpr std::uint32_t dhcp_settable_acd = 0x94;

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
    if (text.size() % 2 != 0) reader.take(1);
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

}  // namespace

cip::ClassInfo TcpIpObject::info() const {
    return {.class_id = class_id, .revision = 4, .max_instance_attribute = inactivity};
}

bool TcpIpObject::offers(std::uint8_t service) const {
    return service == cip::service::get_attributes_all || service == cip::service::get_attribute_single ||
           service == cip::service::set_attribute_single || service == cip::service::get_attribute_list;
}

std::optional<cip::AttributeAccess> TcpIpObject::attribute(std::uint32_t, std::uint32_t id) const {
    if (id < all.front() || id > all.back() || std::ranges::count(only_in_all, id) > 0) return std::nullopt;
    return cip::AttributeAccess{true, std::ranges::count(settable, id) > 0};
}

std::span<const std::uint16_t> TcpIpObject::attributes_all() const { return all; }

cip::Status TcpIpObject::get(std::uint32_t, std::uint32_t id, cip::Writer& value) const {
    switch (id) {
        case status:
            value.u32(status_word());
            break;
        case capability:
            value.u32(capability_word());
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
            write_interface(value, told_interface());
            break;
        case host_name:
            write_padded(value, settings_.host_name);
            break;
        case safety_network_number:
            value.zeros(safety_octets);
            break;
        case ttl:
            value.u8(settings_.ttl);
            break;
        case multicast:
            write_multicast(value);
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

std::uint32_t TcpIpObject::status_word() const {
    const auto& address = network_.state.address;
    return (address.configured ? configured : 0) | (address.pending ? change_pending : 0) |
           (address.conflict ? conflict_now : 0) | (address.without_address ? no_address_left : 0);
}

std::uint32_t TcpIpObject::capability_word() const { return dhcp_settable_acd | (has_bootp() ? bootp_too : 0); }

bool TcpIpObject::has_bootp() const { return network_.state.address_service == AddressService::dhcp_and_bootp; }

// Whoever has set an address reads it back at once, also while it is not in force yet.
const InterfaceConfiguration& TcpIpObject::told_interface() const {
    const bool waits = network_.state.address.pending && settings_.method == AddressMethod::stored;
    return waits ? settings_.configured : network_.state.interface;
}

// By the algorithm there are as many groups as are in use: they are taken from the first on (R-MC-2).
void TcpIpObject::write_multicast(cip::Writer& value) const {
    const auto groups = multicast_groups(network_, network_.state.place().address);
    const bool chosen = settings_.multicast.chosen;
    value.u8(chosen ? 1 : 0);
    value.u8(0);
    value.u16(static_cast<std::uint16_t>(chosen ? groups.count : std::max<std::size_t>(device_.groups_in_use(), 1)));
    value.u32(groups.first);
}

cip::Status TcpIpObject::set(std::uint32_t, std::uint32_t id, cip::ByteView value) {
    switch (id) {
        case control:
            return set_control(value);
        case interface_configuration:
            return set_interface(value);
        case host_name:
            return set_host_name(value);
        case ttl:
            return set_ttl(value);
        case multicast:
            return set_multicast(value);
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

// R-TCP-4. To ask a server for an address gives the present one up, which an I/O connection does not survive.
cip::Status TcpIpObject::set_control(cip::ByteView value) {
    const auto wanted = whole_value<std::uint32_t>(value);
    if (!wanted) return wanted.error();
    const bool known = *wanted == static_cast<std::uint32_t>(AddressMethod::stored) ||
                       *wanted == static_cast<std::uint32_t>(AddressMethod::dhcp) ||
                       (*wanted == static_cast<std::uint32_t>(AddressMethod::bootp) && has_bootp());
    if (!known) return cip::GeneralStatus::invalid_attribute_value;
    const auto method = static_cast<AddressMethod>(*wanted);
    if (method == settings_.method) return {};
    if (method == AddressMethod::stored) {
        settings_.configured = network_.state.interface;  // the address that is in force stays, as a stored one
        settings_.method = method;
        return {};
    }
    if (device_.io_is_open()) return cip::GeneralStatus::device_state_conflict;
    settings_.method = method;
    want_address();
    return {};
}

// In the order of R-TCP-6.
cip::Status TcpIpObject::set_interface(cip::ByteView value) {
    if (device_.io_is_open()) return cip::GeneralStatus::device_state_conflict;
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
    const bool other = wanted != told_interface();
    settings_.configured = std::move(wanted);
    if (other) want_address();
    return {};
}

void TcpIpObject::want_address() {
    network_.state.address.pending = true;
    device_.address_changed();
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

// R-TCP-8: what is being sent by multicast is not redirected.
cip::Status TcpIpObject::set_ttl(cip::ByteView value) {
    if (device_.groups_in_use() > 0) return cip::GeneralStatus::object_state_conflict;
    const auto wanted = whole_value<std::uint8_t>(value);
    if (!wanted) return wanted.error();
    if (*wanted == 0) return cip::GeneralStatus::invalid_attribute_value;
    settings_.ttl = *wanted;
    return {};
}

// R-MC-2. By the algorithm the other members do not count.
cip::Status TcpIpObject::set_multicast(cip::ByteView value) {
    if (device_.groups_in_use() > 0) return cip::GeneralStatus::object_state_conflict;
    cip::Reader reader(value);
    const auto control = reader.u8();
    const auto reserved = reader.u8();
    MulticastAllocation wanted{.chosen = control == 1, .count = reader.u16(), .start = reader.u32()};
    if (const auto wrong = length_status(reader); wrong != cip::GeneralStatus::success) return wrong;
    if (control > 1) return cip::GeneralStatus::invalid_attribute_value;
    if (!wanted.chosen) {
        settings_.multicast = {};
        return {};
    }
    const bool counted = wanted.count >= 1 && wanted.count <= max_multicast_groups;
    if (reserved != 0 || !counted || !enip::is_multicast(wanted.start) ||
        !enip::is_multicast(wanted.start + wanted.count - 1)) {
        return cip::GeneralStatus::invalid_attribute_value;
    }
    settings_.multicast = wanted;
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
    network_.state.address.conflict = false;  // R-ACD-6
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
