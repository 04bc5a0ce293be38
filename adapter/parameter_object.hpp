// A vendor class (0x64, 0x65, ...): the rows of the device's table that have this class in their address.
#pragma once

#include <cstdint>

#include "cip/object.hpp"
#include "drive/device.hpp"

namespace servobus::adapter {

class ParameterObject final : public cip::Object {
public:
    /// The device must outlive the object.
    ParameterObject(drive::Device& device, std::uint16_t class_id);

    [[nodiscard]] cip::ClassInfo info() const override { return info_; }
    [[nodiscard]] bool offers(std::uint8_t service) const override;
    [[nodiscard]] std::optional<cip::AttributeAccess> attribute(std::uint32_t instance,
                                                                std::uint32_t id) const override;
    [[nodiscard]] std::optional<std::uint32_t> implied_attribute() const override;
    [[nodiscard]] cip::Status get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] cip::Status set(std::uint32_t instance, std::uint32_t id, cip::ByteView value) override;
    [[nodiscard]] std::optional<std::size_t> value_size(std::uint32_t instance, std::uint32_t id,
                                                        cip::ByteView data) const override;

private:
    [[nodiscard]] const drive::Parameter* row(std::uint32_t id) const;

    drive::Device& device_;
    cip::ClassInfo info_;
};

}  // namespace servobus::adapter
