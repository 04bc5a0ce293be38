#include "adapter/port_object.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "cip/path.hpp"
#include "cip/services.hpp"
#include "cip/strings.hpp"
#include "enip/endpoint.hpp"

namespace servobus::adapter {
namespace {

constexpr std::uint16_t class_id = 0xF4;
constexpr std::uint16_t tcp_ip_class = 0xF5;

enum ClassAttribute : std::uint16_t { entry_port = 8, all_ports = 9 };

enum Attribute : std::uint16_t {
    type = 1,
    number = 2,
    link_object = 3,
    name = 4,
    node_address = 7,
};

constexpr std::array<std::uint16_t, 5> class_attributes{1, 2, 3, entry_port, all_ports};
constexpr std::array<std::uint16_t, 5> attributes{type, number, link_object, name, node_address};

constexpr std::uint16_t tcp_ip_type = 4;
constexpr std::uint16_t own_number = 2;  // 1 is a backplane's
constexpr std::string_view own_name = "EtherNet/IP";

// The hop that would lead here: the address in its usual text, as people write it into a route (R-PTH-6). No text without
// an address.
cip::Path own_hop(std::uint32_t address) {
    const auto text = address != 0 ? enip::address_text(address) : std::string();
    return cip::Path({cip::PortSegment{own_number, {text.begin(), text.end()}}});
}

}  // namespace

cip::ClassInfo PortObject::info() const {
    return {.class_id = class_id,
            .max_class_attribute = all_ports,
            .max_instance_attribute = node_address,
            .class_attributes_all = class_attributes};
}

bool PortObject::get_class_attribute(std::uint32_t id, cip::Writer& value) const {
    if (id == entry_port) {
        value.u16(1);  // the instance of the port that the request came through
    } else if (id == all_ports) {
        value.zeros(4);  // instance 0
        value.u16(tcp_ip_type);
        value.u16(own_number);
    } else {
        return false;
    }
    return true;
}

bool PortObject::offers(std::uint8_t service) const {
    return service == cip::service::get_attribute_single || service == cip::service::get_attributes_all;
}

std::optional<cip::AttributeAccess> PortObject::attribute(std::uint32_t, std::uint32_t id) const {
    return std::ranges::count(attributes, id) > 0 ? std::optional(cip::AttributeAccess{}) : std::nullopt;
}

std::span<const std::uint16_t> PortObject::attributes_all() const { return attributes; }

cip::Status PortObject::get(std::uint32_t, std::uint32_t id, cip::Writer& value) const {
    switch (id) {
        case type:
            value.u16(tcp_ip_type);
            break;
        case number:
            value.u16(own_number);
            break;
        case link_object: {
            const auto path = cip::Path::to(tcp_ip_class, 1);
            value.u16(static_cast<std::uint16_t>(path.words()));
            path.write(value);
            break;
        }
        case name:
            cip::write_short_string(value, own_name);
            break;
        case node_address:
            own_hop(state_.interface.address).write(value);
            break;
        default:
            return cip::GeneralStatus::attribute_not_supported;
    }
    return {};
}

}  // namespace servobus::adapter
