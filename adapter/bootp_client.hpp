// The BOOTP client (R-DHC-3; RFC 951, RFC 1542): one request, one reply, and an address for as long as the power is on.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "adapter/address_client.hpp"

namespace servobus::adapter {

class BootpClient final : public AddressClient {
public:
    BootpClient(const MacAddress& own, const std::string& host_name, std::uint64_t seed)
        : AddressClient(own, host_name, seed) {}

    void start(enip::Time now) override;
    void stop() override;
    void confirm() override {}
    void decline(std::chrono::seconds pause, enip::Time now) override;
    [[nodiscard]] std::optional<Event> on_timer(enip::Time now) override;
    [[nodiscard]] std::optional<enip::Time> next_deadline() const override { return due_; }

private:
    [[nodiscard]] std::optional<Event> on_reply(const DhcpMessage& reply, const UdpFrame& frame,
                                                enip::Time now) override;
    void wait(std::chrono::milliseconds pause, enip::Time now);

    std::optional<enip::Time> due_;  ///< to ask; nullopt: stopped, or granted
};

}  // namespace servobus::adapter
