#include "adapter/qos_object.hpp"

#include "adapter/wire_checks.hpp"
#include "cip/services.hpp"

namespace servobus::adapter {
namespace {

constexpr std::uint32_t tag_enable = 1;
constexpr std::uint32_t first_ptp_dscp = 2;
constexpr std::uint32_t last_ptp_dscp = 3;
constexpr std::uint32_t first_dscp = 4;
constexpr std::uint32_t last_dscp = 8;
constexpr std::uint8_t max_dscp = 63;

}  // namespace

cip::ClassInfo QosObject::info() const {
    return {.class_id = 0x48, .max_instance_attribute = static_cast<std::uint16_t>(last_dscp)};
}

bool QosObject::offers(std::uint8_t service) const {
    return service == cip::service::get_attribute_single || service == cip::service::set_attribute_single;
}

std::uint8_t* QosObject::stored(std::uint32_t id) const {
    if (id == tag_enable) return &settings_.tag_enable;
    if (has_ptp_ && id >= first_ptp_dscp && id <= last_ptp_dscp) return &settings_.ptp_dscp[id - first_ptp_dscp];
    if (id >= first_dscp && id <= last_dscp) return &settings_.dscp[id - first_dscp];
    return nullptr;
}

// The manual prints Set alone; a value that cannot be read back would help nobody (R-QOS-2).
std::optional<cip::AttributeAccess> QosObject::attribute(std::uint32_t, std::uint32_t id) const {
    return stored(id) != nullptr ? std::optional(cip::AttributeAccess{true, true}) : std::nullopt;
}

cip::Status QosObject::get(std::uint32_t, std::uint32_t id, cip::Writer& value) const {
    value.u8(*stored(id));
    return {};
}

cip::Status QosObject::set(std::uint32_t, std::uint32_t id, cip::ByteView value) {
    const auto wanted = whole_value<std::uint8_t>(value);
    if (!wanted) return wanted.error();
    if (*wanted > (id == tag_enable ? 1 : max_dscp)) return cip::GeneralStatus::invalid_attribute_value;
    *stored(id) = *wanted;
    return {};
}

}  // namespace servobus::adapter
