// The QoS object (0x48, R-QOS). What is set marks packets from the next restart on.
#pragma once

#include "adapter/network_settings.hpp"
#include "cip/object.hpp"

namespace servobus::adapter {

class QosObject final : public cip::Object {
public:
    /// The settings must outlive the object. Attributes 2 and 3 are for devices with PTP.
    explicit QosObject(QualityOfService& settings, bool has_ptp = false) : settings_(settings), has_ptp_(has_ptp) {}

    [[nodiscard]] cip::ClassInfo info() const override;
    [[nodiscard]] bool offers(std::uint8_t service) const override;
    [[nodiscard]] std::optional<cip::AttributeAccess> attribute(std::uint32_t instance,
                                                                std::uint32_t id) const override;
    [[nodiscard]] cip::Status get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] cip::Status set(std::uint32_t instance, std::uint32_t id, cip::ByteView value) override;

private:
    /// The value behind an attribute; null: there is none of that number.
    [[nodiscard]] std::uint8_t* stored(std::uint32_t id) const;

    QualityOfService& settings_;
    bool has_ptp_;
};

}  // namespace servobus::adapter
