// What the two ways to get an address from a server have in common: a transaction of ours, asked again and again at growing
// intervals until a reply fits it.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "adapter/dhcp_message.hpp"
#include "adapter/mac_address.hpp"
#include "adapter/network_settings.hpp"
#include "adapter/udp_frame.hpp"
#include "cip/bytes.hpp"
#include "enip/link_user.hpp"
#include "enip/time.hpp"

namespace servobus::adapter {

/// Datagrams to the client's port that changed nothing.
struct IgnoredReplies {
    std::uint64_t malformed = 0;   ///< no message
    std::uint64_t foreign = 0;     ///< of another transaction, or for another MAC address
    std::uint64_t unexpected = 0;  ///< of a kind, or from a server, that is not waited for
    std::uint64_t illegal = 0;     ///< they grant what no host can have
};

class AddressClient {
public:
    enum class Event : std::uint8_t {
        granted,  ///< there is a configuration; confirm() or decline() it
        changed,  ///< a renewed lease brings another mask, gateway or name server
        lost,     ///< the address must not be used any longer
    };

    virtual ~AddressClient() = default;
    AddressClient(const AddressClient&) = delete;
    AddressClient& operator=(const AddressClient&) = delete;

    /// Asks from now on, without end.
    virtual void start(enip::Time now) = 0;
    /// Asks no more, and forgets what it was granted.
    virtual void stop() = 0;
    /// What was granted is in use.
    virtual void confirm() = 0;
    /// What was granted cannot be used, since somebody has it. After `pause` it is asked again.
    virtual void decline(std::chrono::seconds pause, enip::Time now) = 0;
    [[nodiscard]] virtual std::optional<Event> on_timer(enip::Time now) = 0;
    [[nodiscard]] virtual std::optional<enip::Time> next_deadline() const = 0;

    /// A frame with an IPv4 packet. Others than datagrams to the client's port are not its business.
    [[nodiscard]] std::optional<Event> on_frame(const enip::HeardFrame& frame, enip::Time now);
    /// A datagram to the client's port.
    [[nodiscard]] std::optional<Event> on_datagram(const UdpFrame& frame, enip::Time now);
    /// What was granted last.
    [[nodiscard]] const InterfaceConfiguration& granted() const { return granted_; }
    [[nodiscard]] const IgnoredReplies& ignored() const { return ignored_; }
    /// Whole frames that are to be sent.
    [[nodiscard]] std::vector<cip::Bytes> take_frames() { return std::exchange(frames_, {}); }

protected:
    /// `host_name` outlives this; it is looked at when a new transaction begins (R-TCP-7).
    AddressClient(const MacAddress& own, const std::string& host_name, std::uint64_t seed)
        : own_(own), host_name_(host_name), random_(seed) {}

    [[nodiscard]] virtual std::optional<Event> on_reply(const DhcpMessage& reply, const UdpFrame& frame,
                                                        enip::Time now) = 0;

    /// Another transaction, in which nothing has been asked yet.
    void begin_transaction(enip::Time now);
    /// A message of this transaction.
    [[nodiscard]] DhcpMessage request(enip::Time now) const;
    void send_to_all(const DhcpMessage& message, std::uint32_t source = 0);
    void send(const DhcpMessage& message, std::uint32_t source, const MacAddress& mac, std::uint32_t destination);
    /// 4, 8, 16, 32, 64, 64 ... seconds, each up to one second more or less (RFC 2131, 4.1).
    [[nodiscard]] std::chrono::milliseconds next_interval();
    /// The next one is the first again: something else is asked.
    void restart_intervals() { asked_ = 0; }

    /// Mask, gateway, name servers and domain of a reply, as far as a host can have them; nullopt when it cannot have the
    /// address. Counts that.
    [[nodiscard]] std::optional<InterfaceConfiguration> configuration_of(const DhcpMessage& reply);
    [[nodiscard]] const MacAddress& own() const { return own_; }
    std::nullopt_t count(std::uint64_t IgnoredReplies::*which) {
        ++(ignored_.*which);
        return std::nullopt;
    }

    InterfaceConfiguration granted_;

private:
    MacAddress own_;
    const std::string& host_name_;
    std::mt19937_64 random_;
    std::uint32_t transaction_ = 0;
    enip::Time began_{};
    std::string name_sent_;  ///< the host name of this transaction
    int asked_ = 0;          ///< how often the same
    IgnoredReplies ignored_;
    std::vector<cip::Bytes> frames_;
};

}  // namespace servobus::adapter
