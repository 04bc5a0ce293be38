// The TCP/IP Interface object (0xF5, R-TCP).
#pragma once

#include "adapter/network_state.hpp"
#include "cip/object.hpp"

namespace servobus::adapter {

class TcpIpObject final : public cip::Object {
public:
    /// The settings must outlive the object.
    explicit TcpIpObject(Network& network) : settings_(network.settings), state_(network.state) {}

    [[nodiscard]] cip::ClassInfo info() const override;
    [[nodiscard]] bool offers(std::uint8_t service) const override;
    [[nodiscard]] std::optional<cip::AttributeAccess> attribute(std::uint32_t instance,
                                                                std::uint32_t id) const override;
    [[nodiscard]] cip::Status get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] cip::Status set(std::uint32_t instance, std::uint32_t id, cip::ByteView value) override;
    [[nodiscard]] std::span<const std::uint16_t> attributes_all() const override;

private:
    [[nodiscard]] cip::Status set_control(cip::ByteView value);
    [[nodiscard]] cip::Status set_interface(cip::ByteView value);
    [[nodiscard]] cip::Status set_host_name(cip::ByteView value);
    [[nodiscard]] cip::Status set_select_acd(cip::ByteView value);
    [[nodiscard]] cip::Status set_last_conflict(cip::ByteView value);
    [[nodiscard]] cip::Status set_inactivity(cip::ByteView value);

    NetworkSettings& settings_;
    NetworkState& state_;
};

/// The first multicast address of a node, by the CIP algorithm (R-MC-1). Host order.
[[nodiscard]] std::uint32_t multicast_start(std::uint32_t address, std::uint32_t mask);

}  // namespace servobus::adapter
