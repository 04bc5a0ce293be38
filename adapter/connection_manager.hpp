// The Connection Manager (0x06, R-CM): opens and closes the connections of the device, answers what is asked about them,
// and executes requests that come in an Unconnected_Send.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

#include "adapter/connection_ids.hpp"
#include "adapter/explicit_connections.hpp"
#include "adapter/io_connections.hpp"
#include "adapter/limits.hpp"
#include "adapter/log.hpp"
#include "cip/connection_data.hpp"
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
inline constexpr std::size_t connection_counters = 8;

/// What the device has and uses, for those who plan how much to ask of it: attributes 11 to 13 (R-CM-2).
struct Resources {
    std::uint16_t cpu = 0;           ///< tenths of a percent
    std::uint32_t buffer = 0;        ///< octets that may wait to be sent, of all peers together
    std::uint32_t buffer_space = 0;  ///< of these, what is free now
};

class ConnectionManager final : public cip::Object {
public:
    /// `router` executes embedded and connected requests. All references must outlive this object. `incarnation`: see
    /// ConnectionIds.
    ConnectionManager(cip::MessageRouter& router, cip::NodeIdentity node, DriveIo& drive, const Network& network,
                      const Limits& limits, std::uint16_t incarnation, Log log);

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
    [[nodiscard]] cip::Response refuse(const cip::RequestView& request, cip::Status status) override;

    /// A SendUnitData, and the data of the one that answers it. Nullopt when nothing is answered: unknown id, id of another
    /// TCP connection, or no message in it.
    [[nodiscard]] std::optional<cip::Bytes> on_connected(const enip::ConnectedMessage& message,
                                                         const cip::Origin& origin);

    /// A TCP connection has gone: its class 3 connections go with it, class 1 lives on (R-ENC-25).
    void on_session_closed(std::uint64_t session) { explicit_.on_session_closed(session); }
    /// What a SendUnitData to this TCP connection says now takes the place of what its class 3 connection remembers.
    void amend(std::uint64_t session, const enip::Frame& reply);
    /// Closes the connections whose time is over, and produces what is due into `queue`.
    void on_timer(cip::Time now, enip::IoQueue& queue);
    [[nodiscard]] std::optional<cip::Time> next_deadline() const;

    /// Asked before each open, whatever it asks for: for tests of originators, and for a device that takes none now.
    using RefuseOpen = std::function<std::optional<OpenRefusal>(const cip::ForwardOpen&)>;
    void refuse_opens(RefuseOpen refuse) { refuse_ = std::move(refuse); }

    /// Asked for attributes 11 to 13.
    void tell_resources(std::function<Resources()> resources) { resources_ = std::move(resources); }

    [[nodiscard]] IoConnections& io() { return io_; }
    [[nodiscard]] const IoConnections& io() const { return io_; }
    [[nodiscard]] const ExplicitConnections& explicit_connections() const { return explicit_; }
    [[nodiscard]] std::uint16_t counter(Counter which) const { return counters_[static_cast<std::size_t>(which) - 1]; }

private:
    cip::Response forward_open(const cip::RequestView& request, const cip::Origin& origin);
    cip::Response forward_close(const cip::RequestView& request, const cip::Origin& origin);
    cip::Response unconnected_send(const cip::RequestView& request, const cip::Origin& origin);
    cip::Response get_connection_data(const cip::RequestView& request) const;
    cip::Response search_connection_data(const cip::RequestView& request) const;
    cip::Response get_connection_owner(const cip::RequestView& request) const;

    [[nodiscard]] OpenResult<cip::ForwardOpenReply> admit(const cip::ForwardOpen& open, const cip::Origin& origin);
    [[nodiscard]] OpenResult<cip::ForwardOpenReply> admit_explicit(const cip::ForwardOpen& open,
                                                                   const cip::Origin& origin);
    [[nodiscard]] OpenResult<cip::ForwardOpenReply> admit_io(const cip::ForwardOpen& open, const cip::Origin& origin);
    [[nodiscard]] std::uint16_t free_number() const;
    [[nodiscard]] bool is_free(std::uint16_t number) const;
    void write_entries(cip::Writer& value) const;
    void count(Counter counter);
    void count_reject(const cip::Status& status);

    cip::MessageRouter& router_;
    cip::NodeIdentity node_;
    const Limits& limits_;
    Log log_;
    ConnectionIds ids_;
    ExplicitConnections explicit_;
    IoConnections io_;
    RefuseOpen refuse_;
    std::function<Resources()> resources_ = [] { return Resources{}; };
    std::array<std::uint16_t, connection_counters> counters_{};
};

}  // namespace servobus::adapter
