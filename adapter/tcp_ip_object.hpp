// The TCP/IP Interface object (0xF5, R-TCP).
#pragma once

#include <cstddef>
#include <functional>
#include <utility>

#include "adapter/network_state.hpp"
#include "cip/object.hpp"

namespace servobus::adapter {

/// What the object asks and tells the device around it.
struct TcpIpSurroundings {
    std::function<bool()> io_is_open;            ///< a class 0 or 1 connection is open
    std::function<std::size_t()> groups_in_use;  ///< multicast groups that are produced to, from the first on
    std::function<void()> address_changed;       ///< a Set wants another address, once its reply has left
};

class TcpIpObject final : public cip::Object {
public:
    /// The network must outlive the object.
    TcpIpObject(Network& network, TcpIpSurroundings surroundings)
        : settings_(network.settings), network_(network), device_(std::move(surroundings)) {}

    [[nodiscard]] cip::ClassInfo info() const override;
    [[nodiscard]] bool offers(std::uint8_t service) const override;
    [[nodiscard]] std::optional<cip::AttributeAccess> attribute(std::uint32_t instance,
                                                                std::uint32_t id) const override;
    [[nodiscard]] cip::Status get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] cip::Status set(std::uint32_t instance, std::uint32_t id, cip::ByteView value) override;
    [[nodiscard]] std::span<const std::uint16_t> attributes_all() const override;

private:
    [[nodiscard]] std::uint32_t status_word() const;
    [[nodiscard]] std::uint32_t capability_word() const;
    [[nodiscard]] bool has_bootp() const;
    [[nodiscard]] const InterfaceConfiguration& told_interface() const;
    void write_multicast(cip::Writer& value) const;

    [[nodiscard]] cip::Status set_control(cip::ByteView value);
    [[nodiscard]] cip::Status set_interface(cip::ByteView value);
    [[nodiscard]] cip::Status set_host_name(cip::ByteView value);
    [[nodiscard]] cip::Status set_ttl(cip::ByteView value);
    [[nodiscard]] cip::Status set_multicast(cip::ByteView value);
    [[nodiscard]] cip::Status set_select_acd(cip::ByteView value);
    [[nodiscard]] cip::Status set_last_conflict(cip::ByteView value);
    [[nodiscard]] cip::Status set_inactivity(cip::ByteView value);
    void want_address();

    NetworkSettings& settings_;
    Network& network_;
    TcpIpSurroundings device_;
};

}  // namespace servobus::adapter
