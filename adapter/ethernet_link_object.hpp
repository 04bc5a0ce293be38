// The Ethernet Link object (0xF6, R-ETH): the two ports of the module.
#pragma once

#include "adapter/network_state.hpp"
#include "cip/object.hpp"

namespace servobus::adapter {

class EthernetLinkObject final : public cip::Object {
public:
    /// The network must outlive the object.
    explicit EthernetLinkObject(Network& network) : settings_(network.settings), state_(network.state) {}

    [[nodiscard]] cip::ClassInfo info() const override;
    [[nodiscard]] bool has_instance(std::uint32_t instance) const override;
    [[nodiscard]] bool offers(std::uint8_t service) const override;
    [[nodiscard]] std::optional<cip::AttributeAccess> attribute(std::uint32_t instance,
                                                                std::uint32_t id) const override;
    [[nodiscard]] cip::Status get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] cip::Status set(std::uint32_t instance, std::uint32_t id, cip::ByteView value) override;
    [[nodiscard]] std::span<const std::uint16_t> attributes_all() const override;

private:
    [[nodiscard]] enip::InterfaceFacts facts_of(std::uint32_t instance) const;

    NetworkSettings& settings_;
    const NetworkState& state_;
};

}  // namespace servobus::adapter
