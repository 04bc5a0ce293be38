#include "adapter/ethernet_link_object.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "adapter/wire_checks.hpp"
#include "cip/services.hpp"
#include "cip/strings.hpp"

namespace servobus::adapter {
namespace {

constexpr std::uint16_t class_id = 0xF6;

enum Attribute : std::uint16_t {
    speed = 1,
    flags = 2,
    physical_address = 3,
    interface_counters = 4,
    media_counters = 5,
    interface_control = 6,
    interface_type = 7,
    interface_state = 8,
    admin_state = 9,
    label = 10,
    capability = 11,
};

// Without the capability: it came with revision 4, and who reads all attributes expects the label to be the last.
constexpr std::array<std::uint16_t, 10> all{1, 2, 3, 4, 5, 6, 7, 8, 9, 10};

// What attribute 6 takes (R-ETH-6), as attribute 11 tells it (R-ETH-10).
constexpr std::uint32_t negotiates_and_takes_manual_settings = 1U << 1 | 1U << 3;
struct Mode {
    std::uint16_t speed;
    std::uint8_t full_duplex;
};
constexpr std::array<Mode, 4> modes{{{10, 0}, {10, 1}, {100, 0}, {100, 1}}};

constexpr std::uint32_t module_speed = 100;
// Flags (R-ETH-2).
constexpr std::uint32_t link_is_up = 1;
constexpr std::uint32_t is_full_duplex = 1U << 1;
constexpr unsigned negotiation_shift = 2;
constexpr std::uint8_t twisted_pair = 2;
constexpr std::uint8_t enabled = 1;

constexpr std::uint16_t autonegotiate = 1;
constexpr std::uint16_t full_duplex = 2;

using LinkControl = NetworkSettings::LinkControl;

// The module on somebody's desk: its link partner takes whatever it is told to do.
void take_control(const LinkControl& control, enip::InterfaceFacts& facts) {
    const bool negotiates = (control.bits & autonegotiate) != 0;
    facts.link = true;
    facts.speed = negotiates ? module_speed : control.forced_speed;
    facts.full_duplex = negotiates || (control.bits & full_duplex) != 0;
    facts.negotiation = negotiates ? enip::Negotiation::done : enip::Negotiation::not_attempted;
}

std::uint32_t flags_of(const enip::InterfaceFacts& facts) {
    if (!facts.link) return 0;
    return link_is_up | (facts.full_duplex ? is_full_duplex : 0) |
           static_cast<std::uint32_t>(facts.negotiation) << negotiation_shift;
}

void write(cip::Writer& value, const enip::InterfaceCounters& counters) {
    for (const auto count :
         {counters.in_octets, counters.in_unicast, counters.in_non_unicast, counters.in_discards, counters.in_errors,
          counters.in_unknown_protocols, counters.out_octets, counters.out_unicast, counters.out_non_unicast,
          counters.out_discards, counters.out_errors}) {
        value.u32(count);
    }
}

void write(cip::Writer& value, const enip::MediaCounters& counters) {
    for (const auto count : {counters.alignment_errors, counters.fcs_errors, counters.single_collisions,
                             counters.multiple_collisions, counters.sqe_test_errors, counters.deferred_transmissions,
                             counters.late_collisions, counters.excessive_collisions, counters.mac_transmit_errors,
                             counters.carrier_sense_errors, counters.frames_too_long, counters.mac_receive_errors}) {
        value.u32(count);
    }
}

}  // namespace

// Port 1 is the interface that the drive is at. What is plugged into port 2 is nothing, unless somebody reads it.
enip::InterfaceFacts EthernetLinkObject::facts_of(std::uint32_t instance) const {
    const auto& read = state_.ports[instance - 1];
    auto facts = read ? read() : enip::InterfaceFacts{};
    if (instance == 1 && !facts.ethernet) take_control(settings_.links[0], facts);
    return facts;
}

cip::ClassInfo EthernetLinkObject::info() const {
    const auto ports = static_cast<std::uint16_t>(settings_.links.size());
    return {.class_id = class_id,
            .revision = 4,
            .max_instance = ports,
            .instances = ports,
            .max_instance_attribute = capability};
}

bool EthernetLinkObject::has_instance(std::uint32_t instance) const {
    return instance >= 1 && instance <= settings_.links.size();
}

bool EthernetLinkObject::offers(std::uint8_t service) const {
    return service == cip::service::get_attributes_all || service == cip::service::get_attribute_single ||
           service == cip::service::set_attribute_single || service == cip::service::get_attribute_list;
}

std::optional<cip::AttributeAccess> EthernetLinkObject::attribute(std::uint32_t, std::uint32_t id) const {
    // The admin state is not in the manual; it stands in Get_Attributes_All alone (R-ETH-7).
    if (id < speed || id > capability || id == admin_state) return std::nullopt;
    return cip::AttributeAccess{true, id == interface_control};
}

std::span<const std::uint16_t> EthernetLinkObject::attributes_all() const { return all; }

cip::Status EthernetLinkObject::get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const {
    const auto& link = settings_.links[instance - 1];
    switch (id) {
        case speed:
            value.u32(facts_of(instance).speed);
            break;
        case flags:
            value.u32(flags_of(facts_of(instance)));
            break;
        case physical_address:
            value.bytes(state_.mac);
            break;
        case interface_counters:
            write(value, facts_of(instance).counters);
            break;
        case media_counters:
            write(value, facts_of(instance).media);
            break;
        case interface_control:
            value.u16(link.bits);
            value.u16(link.forced_speed);
            break;
        case interface_type:
            value.u8(twisted_pair);
            break;
        case interface_state:
        case admin_state:
            value.u8(enabled);
            break;
        case label:
            cip::write_short_string(value, fmt::format("PORT {}", instance));
            break;
        case capability:
            value.u32(negotiates_and_takes_manual_settings);
            value.u8(static_cast<std::uint8_t>(modes.size()));
            for (const auto& mode : modes) {
                value.u16(mode.speed);
                value.u8(mode.full_duplex);
            }
            break;
        default:
            return cip::GeneralStatus::attribute_not_supported;
    }
    return {};
}

// R-ETH-6.
cip::Status EthernetLinkObject::set(std::uint32_t instance, std::uint32_t, cip::ByteView value) {
    cip::Reader reader(value);
    LinkControl wanted;
    reader.field(wanted.bits);
    reader.field(wanted.forced_speed);
    if (const auto wrong = length_status(reader); wrong != cip::GeneralStatus::success) return wrong;
    if ((wanted.bits & ~(autonegotiate | full_duplex)) != 0) return cip::GeneralStatus::invalid_attribute_value;
    if ((wanted.bits & autonegotiate) != 0) {
        if (wanted.bits != autonegotiate || wanted.forced_speed != 0) return cip::GeneralStatus::object_state_conflict;
    } else if (std::ranges::find(modes, wanted.forced_speed, &Mode::speed) == modes.end()) {
        return cip::GeneralStatus::invalid_attribute_value;
    }
    settings_.links[instance - 1] = wanted;
    return {};
}

}  // namespace servobus::adapter
