// The Assembly object (0x04, R-ASM): the layouts as attributes. Connections to them are not served yet.
#pragma once

#include <cstdint>
#include <map>

#include "assemblies/layout.hpp"
#include "cip/object.hpp"
#include "drive/device.hpp"

namespace servobus::adapter {

class AssemblyObject final : public cip::Object {
public:
    /// The device must outlive the object.
    explicit AssemblyObject(drive::Device& device);

    [[nodiscard]] cip::ClassInfo info() const override;
    [[nodiscard]] bool has_instance(std::uint32_t instance) const override;
    [[nodiscard]] bool offers(std::uint8_t service) const override;
    [[nodiscard]] std::optional<cip::AttributeAccess> attribute(std::uint32_t instance,
                                                                std::uint32_t id) const override;
    [[nodiscard]] cip::Status get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] cip::Status set(std::uint32_t instance, std::uint32_t id, cip::ByteView value) override;
    [[nodiscard]] std::optional<std::size_t> value_size(std::uint32_t instance, std::uint32_t id,
                                                        cip::ByteView data) const override;

private:
    drive::Device& device_;
    std::map<std::uint32_t, cip::Bytes> written_;  ///< what was last set, per O->T instance (R-ASM-2)
};

}  // namespace servobus::adapter
