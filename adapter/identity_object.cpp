#include "adapter/identity_object.hpp"

#include <array>

#include "cip/services.hpp"
#include "cip/strings.hpp"

namespace servobus::adapter {
namespace {

enum Attribute : std::uint16_t {
    vendor = 1,
    device_type = 2,
    product_code = 3,
    revision = 4,
    status = 5,
    serial_number = 6,
    product_name = 7,
    state = 8,
    heartbeat_interval = 10,
};

// It ends with the product name: the manual knows no attribute 8 (R-ID-6).
constexpr std::array<std::uint16_t, 7> all{1, 2, 3, 4, 5, 6, 7};
constexpr std::array<std::uint16_t, 4> class_attributes_in_all{1, 2, 6, 7};  // R-OBJ-3

constexpr auto last_reset_type = static_cast<std::uint8_t>(ResetType::factory_defaults_keep_network);

}  // namespace

IdentityObject::IdentityObject(const drive::Identity& identity, Reset reset, std::function<DeviceCondition()> condition)
    : identity_(identity), reset_(std::move(reset)), condition_(std::move(condition)) {}

cip::ClassInfo IdentityObject::info() const {
    return {.class_id = cip::class_id::identity,
            .max_instance_attribute = heartbeat_interval,
            .class_attributes_all = class_attributes_in_all};
}

bool IdentityObject::offers(std::uint8_t service) const {
    return service == cip::service::get_attribute_single || service == cip::service::get_attributes_all ||
           service == cip::service::get_attribute_list || service == cip::service::reset;
}

std::optional<cip::AttributeAccess> IdentityObject::attribute(std::uint32_t, std::uint32_t id) const {
    const bool known = (id >= vendor && id <= state) || id == heartbeat_interval;
    return known ? std::optional(cip::AttributeAccess{}) : std::nullopt;
}

std::span<const std::uint16_t> IdentityObject::attributes_all() const { return all; }

cip::Status IdentityObject::get(std::uint32_t, std::uint32_t id, cip::Writer& value) const {
    switch (id) {
        case vendor:
            value.u16(identity_.vendor);
            break;
        case device_type:
            value.u16(identity_.device_type);
            break;
        case product_code:
            value.u16(identity_.product_code);
            break;
        case revision:
            value.u8(identity_.major_revision);
            value.u8(identity_.minor_revision);
            break;
        case status:
            value.u16(identity_status(condition_()));
            break;
        case serial_number:
            value.u32(identity_.serial_number);
            break;
        case product_name:
            cip::write_short_string(value, identity_.product_name);
            break;
        case state:
            value.field(identity_state(condition_()));
            break;
        case heartbeat_interval:
            value.u8(0);  // EtherNet/IP has no heartbeat message, so that the device sends none
            break;
        default:
            return cip::GeneralStatus::attribute_not_supported;
    }
    return {};
}

cip::Response IdentityObject::call(const cip::RequestView& request, const cip::RequestPath&,
                                   const cip::Origin& origin) {
    const auto answer = [&](cip::GeneralStatus status) { return cip::Response{request.service, status, {}}; };
    if (request.data.size() > 1) return answer(cip::GeneralStatus::too_much_data);
    const std::uint8_t type = request.data.empty() ? 0 : request.data[0];
    if (type > last_reset_type) return answer(cip::GeneralStatus::invalid_parameter);
    return answer(reset_(static_cast<ResetType>(type), origin.now));
}

enip::IdentityItem IdentityObject::item(enip::SocketAddress own) const {
    enip::IdentityItem item;
    item.socket = own;
    item.vendor = identity_.vendor;
    item.device_type = identity_.device_type;
    item.product_code = identity_.product_code;
    item.major_revision = identity_.major_revision;
    item.minor_revision = identity_.minor_revision;
    const auto condition = condition_();
    item.status = identity_status(condition);
    item.serial_number = identity_.serial_number;
    item.product_name = identity_.product_name;
    item.state = static_cast<std::uint8_t>(identity_state(condition));
    return item;
}

cip::NodeIdentity node_identity(const drive::Identity& identity) {
    return {identity.vendor, identity.device_type, identity.product_code, identity.major_revision,
            identity.minor_revision};
}

}  // namespace servobus::adapter
