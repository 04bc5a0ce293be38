#include "adapter/parameter_object.hpp"

#include <algorithm>

#include "assemblies/parameter_value.hpp"
#include "cip/services.hpp"

namespace servobus::adapter {

ParameterObject::ParameterObject(drive::Device& device, std::uint16_t class_id) : device_(device) {
    info_.class_id = class_id;
    for (const auto& row : device.store().table()) {
        if (row.cip.class_id != class_id) continue;
        info_.max_instance_attribute = std::max(info_.max_instance_attribute, row.cip.attribute);
    }
}

// 000 names 0x0E and 0x10; the list services read and write the same rows in one message.
bool ParameterObject::offers(std::uint8_t service) const {
    return service == cip::service::get_attribute_single || service == cip::service::set_attribute_single ||
           service == cip::service::get_attribute_list || service == cip::service::set_attribute_list;
}

const drive::Parameter* ParameterObject::row(std::uint32_t id) const {
    if (id > 0xFFFF) return nullptr;
    return device_.find({info_.class_id, static_cast<std::uint16_t>(id)});
}

std::optional<cip::AttributeAccess> ParameterObject::attribute(std::uint32_t, std::uint32_t id) const {
    const auto* found = row(id);
    if (found == nullptr) return std::nullopt;
    return cip::AttributeAccess{drive::may_get(found->access), drive::may_set(found->access)};
}

// Attribute 0 is real here, and originators leave out a segment whose number is 0 (R-DEV-4).
std::optional<std::uint32_t> ParameterObject::implied_attribute() const {
    return row(0) != nullptr ? std::optional<std::uint32_t>(0) : std::nullopt;
}

cip::Status ParameterObject::get(std::uint32_t, std::uint32_t id, cip::Writer& value) const {
    const auto* found = row(id);
    const auto result = device_.read(*found);
    if (const auto* refusal = std::get_if<drive::Refusal>(&result)) return assemblies::to_status(*refusal);
    assemblies::write_value(value, *found, std::get<drive::Value>(result));
    return {};
}

cip::Status ParameterObject::set(std::uint32_t, std::uint32_t id, cip::ByteView value) {
    const auto* found = row(id);
    auto parsed = assemblies::read_value(*found, value);
    if (!parsed) return parsed.error();
    const auto refusal = device_.write(*found, std::move(*parsed));
    return refusal ? assemblies::to_status(*refusal) : cip::Status{};
}

std::optional<std::size_t> ParameterObject::value_size(std::uint32_t, std::uint32_t id, cip::ByteView data) const {
    return assemblies::value_size(*row(id), data);
}

}  // namespace servobus::adapter
