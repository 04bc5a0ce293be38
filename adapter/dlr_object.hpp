// The Device Level Ring object (0x47, R-DLR) of a node that is no supervisor.
#pragma once

#include "adapter/network_state.hpp"
#include "cip/object.hpp"

namespace servobus::adapter {

class DlrObject final : public cip::Object {
public:
    /// The status must outlive the object.
    explicit DlrObject(const RingStatus& ring) : ring_(ring) {}

    [[nodiscard]] cip::ClassInfo info() const override;
    [[nodiscard]] bool offers(std::uint8_t service) const override;
    [[nodiscard]] std::optional<cip::AttributeAccess> attribute(std::uint32_t instance,
                                                                std::uint32_t id) const override;
    [[nodiscard]] cip::Status get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] std::span<const std::uint16_t> attributes_all() const override;

private:
    const RingStatus& ring_;
};

}  // namespace servobus::adapter
