// The open class 3 connections (R-CON-45 to R-CON-47).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include "adapter/connection_ids.hpp"
#include "adapter/limits.hpp"
#include "adapter/open_refusal.hpp"
#include "cip/forward_open.hpp"
#include "cip/message_router.hpp"
#include "cip/object.hpp"
#include "cip/request_path.hpp"
#include "enip/messages.hpp"

namespace servobus::adapter {

struct ExplicitConnection {
    std::uint16_t number = 0;     ///< of Get_Connection_Data
    std::uint32_t o_to_t_id = 0;  ///< ours: what arrives carries it
    std::uint32_t t_to_o_id = 0;  ///< the originator's: what we send carries it
    cip::ConnectionTriad triad;
    std::uint64_t session = 0;    ///< the TCP connection that opened it
    std::uint32_t address = 0;    ///< the originator's IPv4 address
    std::size_t reply_limit = 0;  ///< octets of a message router reply
    std::uint8_t multiplier_code = 0;
    std::uint32_t o_to_t_rpi = 0;
    std::uint32_t t_to_o_rpi = 0;
    std::chrono::microseconds timeout{};
    cip::Time deadline{};
    std::optional<std::uint16_t> last_sequence{};
    cip::Bytes last_reply{};  ///< resent when a sequence count repeats (R-CON-46)
};

class ExplicitConnections {
public:
    /// All of them outlive this.
    ExplicitConnections(ConnectionIds& ids, const cip::NodeIdentity& node, const Limits& limits)
        : ids_(ids), node_(node), limits_(limits) {}

    /// Steps 3 to 9 of R-CON-15, and the connection. `number` is free.
    [[nodiscard]] OpenResult<const ExplicitConnection*> open(const cip::ForwardOpen& open, const cip::Origin& origin,
                                                             std::uint16_t number);
    void close(std::uint32_t o_to_t_id) { connections_.erase(o_to_t_id); }
    /// A TCP connection has gone: its connections go with it (R-ENC-25).
    void on_session_closed(std::uint64_t session);
    /// Closes the connections whose time is over, and tells of each.
    void on_timer(cip::Time now, const std::function<void(const ExplicitConnection&)>& timed_out);
    [[nodiscard]] std::optional<cip::Time> next_deadline() const;

    /// A SendUnitData, answered by `router`: the data of the one that goes back. Nullopt when nothing is answered: unknown
    /// id, id of another TCP connection, or no message in it.
    [[nodiscard]] std::optional<cip::Bytes> on_message(const enip::ConnectedMessage& message, const cip::Origin& origin,
                                                       cip::MessageRouter& router);

    /// What `reply` says takes the place of the reply that is remembered for its sequence count, in a connection of this
    /// TCP connection.
    void amend(std::uint64_t session, const enip::ConnectedMessage& reply);

    [[nodiscard]] const ExplicitConnection* find(const cip::ConnectionTriad& triad) const;
    [[nodiscard]] const ExplicitConnection* find(std::uint16_t number) const;
    [[nodiscard]] bool uses(std::uint32_t id) const { return connections_.contains(id); }
    [[nodiscard]] std::size_t size() const { return connections_.size(); }

private:
    [[nodiscard]] OpenResult<void> check(const cip::ForwardOpen& open) const;
    [[nodiscard]] OpenResult<void> check_path(cip::ByteView octets) const;
    [[nodiscard]] OpenResult<void> check_sizes(const cip::ForwardOpen& open) const;

    ConnectionIds& ids_;
    const cip::NodeIdentity& node_;
    const Limits& limits_;
    std::map<std::uint32_t, ExplicitConnection> connections_;  ///< by our id
};

}  // namespace servobus::adapter
