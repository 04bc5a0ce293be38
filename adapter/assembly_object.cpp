#include "adapter/assembly_object.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "adapter/wire_checks.hpp"
#include "assemblies/connection.hpp"
#include "assemblies/parameter_value.hpp"
#include "cip/services.hpp"

namespace servobus::adapter {
namespace {

constexpr std::uint32_t data_attribute = 3;
constexpr std::uint32_t size_attribute = 4;

// The instances without data (R-DEV-7, R-ASM-1).
constexpr std::array<std::uint32_t, 3> empty_instances{assemblies::configuration_instance, assemblies::input_only_point,
                                                       assemblies::listen_only_point};

bool is_output(std::uint32_t instance) {
    const auto* layout = assemblies::find_layout(instance);
    return layout != nullptr && layout->direction == assemblies::Direction::o_to_t;
}

std::size_t size_of(std::uint32_t instance) {
    const auto* layout = assemblies::find_layout(instance);
    return layout != nullptr ? layout->size() : 0;
}

}  // namespace

bool is_assembly_instance(std::uint32_t instance) {
    return assemblies::find_layout(instance) != nullptr || std::ranges::count(empty_instances, instance) > 0;
}

// All of them from the start, so that nothing is allocated when data comes.
AssemblyObject::AssemblyObject(drive::Device& device) : device_(device) {
    for (const auto& layout : assemblies::layouts()) {
        if (layout.direction == assemblies::Direction::o_to_t) written_[layout.instance] = cip::Bytes(layout.size());
    }
}

cip::ClassInfo AssemblyObject::info() const {
    return {.class_id = cip::class_id::assembly,
            .revision = 2,
            .max_instance = empty_instances.back(),
            .instances = static_cast<std::uint16_t>(assemblies::layouts().size() + empty_instances.size()),
            .max_instance_attribute = size_attribute};
}

bool AssemblyObject::has_instance(std::uint32_t instance) const { return is_assembly_instance(instance); }

bool AssemblyObject::offers(std::uint8_t service) const {
    return service == cip::service::get_attribute_single || service == cip::service::set_attribute_single;
}

std::optional<cip::AttributeAccess> AssemblyObject::attribute(std::uint32_t instance, std::uint32_t id) const {
    if (id == data_attribute) {
        const bool owned = owned_ && owned_();
        return cip::AttributeAccess{true, is_output(instance) && !owned};
    }
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
    if (layout->direction == assemblies::Direction::o_to_t) {
        value.bytes(written_.at(layout->instance));
        return {};
    }
    cip::Bytes image(layout->size());
    assemblies::pack(*layout, device_, 0, image);
    value.bytes(image);
    return {};
}

void AssemblyObject::received(const assemblies::Layout& layout, cip::ByteView octets) { keep(layout, octets); }

// Padding reads back as zero (R-ASM-7), so what is kept is what the layout knows.
void AssemblyObject::keep(const assemblies::Layout& layout, cip::ByteView octets) {
    auto& kept = written_.at(layout.instance);
    std::ranges::copy(octets, kept.begin());
    std::size_t offset = 0;
    for (const auto& member : layout.members) {
        if (member.kind == assemblies::Member::Kind::padding) {
            std::ranges::fill(std::span(kept).subspan(offset, member.octets), std::uint8_t{0});
        }
        offset += member.octets;
    }
}

cip::Status AssemblyObject::set(std::uint32_t instance, std::uint32_t, cip::ByteView value) {
    const auto wrong = length_status(value, size_of(instance));
    if (wrong != cip::GeneralStatus::success) return wrong;
    const auto& layout = *assemblies::find_layout(instance);
    if (const auto refusal = assemblies::unpack(layout, value, device_)) return assemblies::to_status(*refusal);
    keep(layout, value);
    return {};
}

std::optional<std::size_t> AssemblyObject::value_size(std::uint32_t instance, std::uint32_t, cip::ByteView) const {
    return size_of(instance);
}

}  // namespace servobus::adapter
