// The Port object (0xF4, R-PRT): the one way into the device, its EtherNet/IP port.
#pragma once

#include "adapter/network_state.hpp"
#include "cip/object.hpp"

namespace servobus::adapter {

class PortObject final : public cip::Object {
public:
    /// The state must outlive the object.
    explicit PortObject(const NetworkState& state) : state_(state) {}

    [[nodiscard]] cip::ClassInfo info() const override;
    [[nodiscard]] bool get_class_attribute(std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] bool offers(std::uint8_t service) const override;
    [[nodiscard]] std::optional<cip::AttributeAccess> attribute(std::uint32_t instance,
                                                                std::uint32_t id) const override;
    [[nodiscard]] cip::Status get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] std::span<const std::uint16_t> attributes_all() const override;

private:
    const NetworkState& state_;
};

}  // namespace servobus::adapter
