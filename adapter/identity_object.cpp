#include "adapter/identity_object.hpp"

#include <array>

#include "cip/services.hpp"
#include "cip/strings.hpp"

namespace servobus::adapter {
namespace {

constexpr std::array<std::uint16_t, 8> attributes{1, 2, 3, 4, 5, 6, 7, 8};
// Get_Attributes_All ends with the product name: the manual knows no attribute 8 (R-ID-6).
constexpr std::size_t attributes_in_all = 7;
constexpr std::array<std::uint16_t, 4> class_attributes_in_all{1, 2, 6, 7};  // R-OBJ-3

}  // namespace

IdentityObject::IdentityObject(drive::Identity identity, Reset reset, std::function<Present()> present)
    : identity_(std::move(identity)), reset_(std::move(reset)), present_(std::move(present)) {}

cip::ClassInfo IdentityObject::info() const {
    return {.class_id = cip::class_id::identity,
            .max_instance_attribute = 8,
            .class_attributes_all = class_attributes_in_all};
}

bool IdentityObject::offers(std::uint8_t service) const {
    return service == cip::service::get_attribute_single || service == cip::service::get_attributes_all ||
           service == cip::service::get_attribute_list || service == cip::service::reset;
}

std::optional<cip::AttributeAccess> IdentityObject::attribute(std::uint32_t, std::uint32_t id) const {
    if (id < attributes.front() || id > attributes.back()) return std::nullopt;
    return cip::AttributeAccess{};
}

std::span<const std::uint16_t> IdentityObject::attributes_all() const {
    return std::span(attributes).first(attributes_in_all);
}

cip::Status IdentityObject::get(std::uint32_t, std::uint32_t id, cip::Writer& value) const {
    switch (id) {
        case 1:
            value.u16(identity_.vendor);
            break;
        case 2:
            value.u16(identity_.device_type);
            break;
        case 3:
            value.u16(identity_.product_code);
            break;
        case 4:
            value.u8(identity_.major_revision);
            value.u8(identity_.minor_revision);
            break;
        case 5:
            value.u16(present_().status);
            break;
        case 6:
            value.u32(identity_.serial_number);
            break;
        case 7:
            cip::write_short_string(value, identity_.product_name);
            break;
        case 8:
            value.field(present_().state);
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
    const auto type = static_cast<ResetType>(request.data.empty() ? 0 : request.data[0]);
    if (type != ResetType::restart && type != ResetType::factory_defaults) {
        return answer(cip::GeneralStatus::invalid_parameter);
    }
    return answer(reset_(type, origin.now));
}

enip::IdentityItem IdentityObject::item(enip::SocketAddress own) const {
    enip::IdentityItem item;
    item.socket = own;
    item.vendor = identity_.vendor;
    item.device_type = identity_.device_type;
    item.product_code = identity_.product_code;
    item.major_revision = identity_.major_revision;
    item.minor_revision = identity_.minor_revision;
    const auto present = present_();
    item.status = present.status;
    item.serial_number = identity_.serial_number;
    item.product_name = identity_.product_name;
    item.state = static_cast<std::uint8_t>(present.state);
    return item;
}

cip::NodeIdentity node_identity(const drive::Identity& identity) {
    return {identity.vendor, identity.device_type, identity.product_code, identity.major_revision,
            identity.minor_revision};
}

}  // namespace servobus::adapter
