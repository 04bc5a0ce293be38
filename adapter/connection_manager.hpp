// The Connection Manager (0x06, R-CM) as far as explicit messages need it: class 3 connections and Unconnected_Send.
// Class 0 and 1 (I/O) opens are refused with 0x01/0x0103 until this device serves them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "adapter/limits.hpp"
#include "adapter/log.hpp"
#include "cip/forward_open.hpp"
#include "cip/message_router.hpp"
#include "cip/object.hpp"
#include "cip/status.hpp"
#include "cip/unconnected_send.hpp"
#include "enip/messages.hpp"

namespace servobus::adapter {

/// Attributes 1 to 8 of instance 1 (R-CM-2).
enum class Counter : std::uint8_t {
    open_requests = 1,
    open_format_rejects,
    open_resource_rejects,
    open_other_rejects,
    close_requests,
    close_format_rejects,
    close_other_rejects,
    connection_timeouts,
};

/// An open class 3 connection (R-CON-45 to R-CON-47).
struct ExplicitConnection {
    std::uint32_t o_to_t_id = 0;  ///< ours: what arrives carries it
    std::uint32_t t_to_o_id = 0;  ///< the originator's: what we send carries it
    cip::ConnectionTriad triad;
    std::uint64_t session = 0;    ///< the TCP connection that opened it
    std::uint32_t address = 0;    ///< the originator's IPv4 address
    std::size_t reply_limit = 0;  ///< octets of a message router reply
    std::chrono::microseconds timeout{};
    cip::Time deadline{};
    std::optional<std::uint16_t> last_sequence{};
    cip::Bytes last_reply{};  ///< resent when a sequence count repeats (R-CON-46)
};

class ConnectionManager final : public cip::Object {
public:
    /// `router` executes embedded and connected requests and must outlive this object. `incarnation` goes into the
    /// upper half of every connection id that this target chooses, so that ids differ between starts (R-CON-16).
    ConnectionManager(cip::MessageRouter& router, cip::NodeIdentity node, const Limits& limits,
                      std::uint16_t incarnation, Log log);

    // As a CIP object.
    [[nodiscard]] cip::ClassInfo info() const override;
    [[nodiscard]] bool offers(std::uint8_t service) const override;
    [[nodiscard]] std::optional<cip::AttributeAccess> attribute(std::uint32_t instance,
                                                                std::uint32_t id) const override;
    [[nodiscard]] cip::Status get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] cip::Status set(std::uint32_t instance, std::uint32_t id, cip::ByteView value) override;
    [[nodiscard]] std::optional<std::size_t> value_size(std::uint32_t instance, std::uint32_t id,
                                                        cip::ByteView data) const override;
    [[nodiscard]] cip::Response call(const cip::RequestView& request, const cip::RequestPath& path,
                                     const cip::Origin& origin) override;

    /// A SendUnitData. Nullopt when nothing is answered: unknown id, id of another TCP connection, or no message in it.
    [[nodiscard]] std::optional<enip::SendData> on_connected(const enip::ConnectedMessage& message,
                                                             std::uint64_t session, std::uint32_t address,
                                                             cip::Time now);

    /// A TCP connection has gone: its class 3 connections go with it (R-ENC-25).
    void on_session_closed(std::uint64_t session);
    /// Closes the connections whose time is over.
    void on_timer(cip::Time now);
    [[nodiscard]] std::optional<cip::Time> next_deadline() const;

    [[nodiscard]] std::size_t connections() const { return connections_.size(); }

private:
    cip::Response forward_open(const cip::RequestView& request, const cip::Origin& origin);
    cip::Response forward_close(const cip::RequestView& request, const cip::Origin& origin);
    cip::Response unconnected_send(const cip::RequestView& request, const cip::Origin& origin);

    [[nodiscard]] cip::Status check(const cip::ForwardOpen& open) const;
    [[nodiscard]] cip::Status check_path(cip::ByteView octets) const;
    [[nodiscard]] cip::Status check_sizes(const cip::ForwardOpen& open) const;
    ExplicitConnection& admit(const cip::ForwardOpen& open, const cip::Origin& origin);
    [[nodiscard]] std::uint32_t choose_id();
    [[nodiscard]] ExplicitConnection* find(const cip::ConnectionTriad& triad);
    void count(Counter counter);
    void count_reject(const cip::Status& status);

    cip::MessageRouter& router_;
    cip::NodeIdentity node_;
    const Limits& limits_;
    std::uint16_t incarnation_;
    std::uint16_t last_number_ = 0;
    Log log_;
    std::map<std::uint32_t, ExplicitConnection> connections_;  ///< by our id
    std::array<std::uint16_t, 8> counters_{};
};

}  // namespace servobus::adapter
