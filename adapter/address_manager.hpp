// How the device comes to its IPv4 address: by attribute 3 of 0xF5 it is the stored one, or a BOOTP or DHCP server is asked
// (R-DHC); address conflict detection looks at it before and while it is used (R-ACD). What is so now is written into the
// NetworkState, which clients read; who has the sockets looks at address().
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include "adapter/address_client.hpp"
#include "adapter/address_conflict.hpp"
#include "adapter/log.hpp"
#include "adapter/network_state.hpp"
#include "enip/link_user.hpp"

namespace servobus::adapter {

class AddressManager final : public enip::AddressUser {
public:
    /// The network outlives this; its MAC address is the port's. Nothing happens before restart(). The seed chooses
    /// transactions and intervals.
    AddressManager(Network& network, std::uint64_t seed, Log log = {});
    ~AddressManager() override;
    AddressManager(const AddressManager&) = delete;
    AddressManager& operator=(const AddressManager&) = delete;

    /// Power is on, or the device restarts: the address is given up and looked for anew, at the next on_timer(). SelectAcd
    /// takes effect (R-TCP-9).
    void restart();
    /// The same, without the power: attribute 3 or 5 was set, and its reply has left (R-TCP-6).
    void change_address();
    /// Called when the address has been lost otherwise, to a rival or with its lease: everything that uses it must end.
    void on_loss(std::function<void()> lost) { lost_ = std::move(lost); }

    void on_frame(std::size_t port, const enip::HeardFrame& heard, enip::Time now) override;
    void on_link(std::size_t port, bool up, enip::Time now) override;
    void on_timer(enip::Time now) override;
    [[nodiscard]] std::optional<enip::Time> next_deadline() const override;
    [[nodiscard]] std::vector<enip::LinkFrame> take_frames() override;
    [[nodiscard]] std::optional<enip::InterfaceAddress> address() const override;

    [[nodiscard]] IgnoredReplies ignored_replies() const;

private:
    [[nodiscard]] std::unique_ptr<AddressClient> client_of(AddressMethod method);
    void forget();
    void begin(enip::Time now);
    void begin_with_stored(enip::Time now);
    void follow_settings();
    void examine(const InterfaceConfiguration& configuration, enip::Time now);
    void use();
    void drop();
    void lose();
    void take(std::optional<AddressClient::Event> event, enip::Time now);
    void take(std::optional<AddressVerdict> verdict, enip::Time now);
    void suffer_conflict(enip::Time now);

    Network& network_;
    Log log_;
    std::mt19937_64 random_;
    std::function<void()> lost_;
    bool link_up_ = true;
    bool detects_ = true;                    ///< SelectAcd at the latest restart
    bool begins_ = false;                    ///< at the next on_timer()
    std::unique_ptr<AddressClient> client_;  ///< none: the stored address is followed
    AddressConflictDetection detection_;
    InterfaceConfiguration candidate_;  ///< that is examined, or in use
    bool in_use_ = false;
    std::optional<enip::Time> retry_;  ///< of a stored address that somebody else had
};

}  // namespace servobus::adapter
