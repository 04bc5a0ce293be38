#include "adapter/dlr_object.hpp"

#include <array>

#include "cip/services.hpp"

namespace servobus::adapter {
namespace {

enum Attribute : std::uint16_t {
    topology = 1,
    status = 2,
    supervisor_status = 3,
    supervisor_configuration = 4,
    rapid_faults = 5,
    last_active_node_1 = 6,
    last_active_node_2 = 7,
    participants = 8,
    active_supervisor = 10,
    active_supervisor_precedence = 11,
    capability = 12,
};

// Revision 3 leaves attribute 9 out (R-DLR-3).
constexpr std::array<std::uint16_t, 11> all{1, 2, 3, 4, 5, 6, 7, 8, 10, 11, 12};

constexpr std::uint8_t no_supervisor = 0xFF;
constexpr std::uint16_t unknown_count = 0xFFFF;
constexpr std::uint32_t announce_based = 0x01;
constexpr std::uint32_t beacon_based = 0x02;
constexpr std::uint32_t takes_flush_tables = 0x80;
constexpr std::size_t configuration_octets = 12;
constexpr std::size_t node_octets = 10;

}  // namespace

cip::ClassInfo DlrObject::info() const {
    return {.class_id = 0x47, .revision = 3, .max_instance_attribute = capability};
}

bool DlrObject::offers(std::uint8_t service) const {
    return service == cip::service::get_attribute_single || service == cip::service::get_attributes_all;
}

std::optional<cip::AttributeAccess> DlrObject::attribute(std::uint32_t, std::uint32_t id) const {
    const bool printed = id == topology || id == status || id == active_supervisor || id == capability;
    return printed ? std::optional(cip::AttributeAccess{}) : std::nullopt;
}

std::span<const std::uint16_t> DlrObject::attributes_all() const { return all; }

cip::Status DlrObject::get(std::uint32_t, std::uint32_t id, cip::Writer& value) const {
    switch (id) {
        case topology:
            value.u8(ring_.topology);
            break;
        case status:
            value.u8(ring_.status);
            break;
        case supervisor_status:
            value.u8(no_supervisor);
            break;
        case supervisor_configuration:
            value.zeros(configuration_octets);
            break;
        case rapid_faults:
            value.u16(0);
            break;
        case last_active_node_1:
        case last_active_node_2:
            value.zeros(node_octets);
            break;
        case participants:
            value.u16(unknown_count);
            break;
        case active_supervisor:
            value.u32(ring_.supervisor_address);
            value.bytes(ring_.supervisor_mac);
            break;
        case active_supervisor_precedence:
            value.u8(ring_.supervisor_precedence);
            break;
        case capability:
            value.u32((ring_.announce_based ? announce_based : beacon_based) | takes_flush_tables);
            break;
        default:
            return cip::GeneralStatus::attribute_not_supported;
    }
    return {};
}

}  // namespace servobus::adapter
