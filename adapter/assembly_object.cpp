#include "adapter/assembly_object.hpp"

#include <algorithm>
#include <array>

#include "adapter/wire_checks.hpp"
#include "assemblies/parameter_value.hpp"
#include "cip/services.hpp"

namespace servobus::adapter {
namespace {

constexpr std::uint32_t data_attribute = 3;
constexpr std::uint32_t size_attribute = 4;

// The instances without data (R-DEV-7, R-ASM-1).
constexpr std::array<std::uint32_t, 3> empty_instances{1, 254, 255};

bool is_empty_instance(std::uint32_t instance) { return std::ranges::count(empty_instances, instance) > 0; }

bool is_output(std::uint32_t instance) {
    const auto* layout = assemblies::find_layout(instance);
    return layout != nullptr && layout->direction == assemblies::Direction::o_to_t;
}

std::size_t size_of(std::uint32_t instance) {
    const auto* layout = assemblies::find_layout(instance);
    return layout != nullptr ? layout->size() : 0;
}

}  // namespace

AssemblyObject::AssemblyObject(drive::Device& device) : device_(device) {}

cip::ClassInfo AssemblyObject::info() const {
    return {.class_id = cip::class_id::assembly,
            .revision = 2,
            .max_instance = empty_instances.back(),
            .instances = static_cast<std::uint16_t>(assemblies::layouts().size() + empty_instances.size()),
            .max_instance_attribute = size_attribute};
}

bool AssemblyObject::has_instance(std::uint32_t instance) const {
    return assemblies::find_layout(instance) != nullptr || is_empty_instance(instance);
}

bool AssemblyObject::offers(std::uint8_t service) const {
    return service == cip::service::get_attribute_single || service == cip::service::set_attribute_single;
}

std::optional<cip::AttributeAccess> AssemblyObject::attribute(std::uint32_t instance, std::uint32_t id) const {
    if (id == data_attribute) return cip::AttributeAccess{true, is_output(instance)};
    if (id == size_attribute) return cip::AttributeAccess{};
    return std::nullopt;
}

cip::Status AssemblyObject::get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const {
    if (id == size_attribute) {
        value.u16(static_cast<std::uint16_t>(size_of(instance)));
        return {};
    }
    const auto* layout = assemblies::find_layout(instance);
    if (layout == nullptr) return {};
    cip::Bytes image(layout->size());
    const auto written = written_.find(instance);
    if (layout->direction == assemblies::Direction::t_to_o) {
        assemblies::pack(*layout, device_, 0, image);
    } else if (written != written_.end()) {
        image = written->second;
    }
    value.bytes(image);
    return {};
}

cip::Status AssemblyObject::set(std::uint32_t instance, std::uint32_t, cip::ByteView value) {
    const auto wrong = length_status(value, size_of(instance));
    if (wrong != cip::GeneralStatus::success) return wrong;
    const auto& layout = *assemblies::find_layout(instance);
    if (const auto refusal = assemblies::unpack(layout, value, device_)) return assemblies::to_status(*refusal);
    // Padding reads back as zero (R-ASM-7), so what is kept is what the layout knows.
    cip::Bytes kept(value.begin(), value.end());
    std::size_t offset = 0;
    for (const auto& member : layout.members) {
        if (member.kind == assemblies::Member::Kind::padding)
            std::fill_n(kept.begin() + static_cast<std::ptrdiff_t>(offset), member.octets, std::uint8_t{0});
        offset += member.octets;
    }
    written_[instance] = std::move(kept);
    return {};
}

std::optional<std::size_t> AssemblyObject::value_size(std::uint32_t instance, std::uint32_t, cip::ByteView) const {
    return size_of(instance);
}

}  // namespace servobus::adapter
