// The DHCP client (R-DHC-1, R-DHC-2; RFC 2131, from INIT on). An address that it is granted is looked at by address conflict
// detection before it is used.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "adapter/address_client.hpp"

namespace servobus::adapter {

class DhcpClient final : public AddressClient {
public:
    DhcpClient(const MacAddress& own, const std::string& host_name, std::uint64_t seed)
        : AddressClient(own, host_name, seed) {}

    void start(enip::Time now) override;
    void stop() override;
    void confirm() override;
    void decline(std::chrono::seconds pause, enip::Time now) override;
    [[nodiscard]] std::optional<Event> on_timer(enip::Time now) override;
    [[nodiscard]] std::optional<enip::Time> next_deadline() const override;

private:
    enum class State : std::uint8_t {
        stopped,
        waiting,     ///< for the time to ask
        selecting,   ///< an offer is waited for
        requesting,  ///< the offer has been taken up
        checking,    ///< granted, not yet confirmed
        bound,
        renewing,   ///< the server is asked again
        rebinding,  ///< any server is
    };

    /// A server, and how it was reached.
    struct Server {
        std::uint32_t address = 0;
        MacAddress mac{};
    };
    /// When a lease is to be renewed, and when it ends; none of it when it lasts for ever.
    struct Lease {
        enip::Time renewal;
        enip::Time rebinding;
        enip::Time end;
    };

    [[nodiscard]] std::optional<Event> on_reply(const DhcpMessage& reply, const UdpFrame& frame,
                                                enip::Time now) override;
    [[nodiscard]] std::optional<Event> on_offer(const DhcpMessage& offer, enip::Time now);
    [[nodiscard]] std::optional<Event> on_ack(const DhcpMessage& ack, const UdpFrame& frame);
    [[nodiscard]] std::optional<Event> on_nak(const DhcpMessage& nak, enip::Time now);
    [[nodiscard]] std::optional<Lease> lease_of(const DhcpMessage& ack, std::uint32_t seconds) const;
    [[nodiscard]] bool has_lease() const;
    [[nodiscard]] bool waits_for_ack() const;
    [[nodiscard]] DhcpMessage message(DhcpType type, enip::Time now) const;
    void wait(std::chrono::milliseconds pause, enip::Time now);
    void discover(enip::Time now);
    void request_offer(enip::Time now);
    void renew(enip::Time now);
    void rebind(enip::Time now);
    [[nodiscard]] std::optional<Event> lose(enip::Time now);

    State state_ = State::stopped;
    std::optional<enip::Time> due_;
    Server server_;
    std::uint32_t offered_ = 0;
    int requests_ = 0;        ///< for this offer
    enip::Time requested_{};  ///< the latest of them: a lease counts from there
    std::optional<Lease> lease_;
};

}  // namespace servobus::adapter
