// The open class 1 connections of the device: who owns it, who looks on, what is produced for whom (R-CON-18 to R-CON-37,
// R-CON-50, R-IO).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "adapter/connection_ids.hpp"
#include "adapter/drive_io.hpp"
#include "adapter/forward_open_checks.hpp"
#include "adapter/identity_status.hpp"
#include "adapter/limits.hpp"
#include "adapter/log.hpp"
#include "adapter/network_state.hpp"
#include "adapter/open_refusal.hpp"
#include "assemblies/connection.hpp"
#include "cip/forward_open.hpp"
#include "cip/object.hpp"
#include "enip/io_queue.hpp"
#include "enip/io_stream.hpp"

namespace servobus::adapter {

/// What is sent of one T->O point: to one originator, or by multicast to all that have joined (R-MC-3).
struct Production {
    const assemblies::Layout* layout = nullptr;
    bool multicast = false;
    cip::ConnectionParameters parameters;  ///< of the open that started it, for those who join (R-CON-33)
    cip::Transport transport;
    enip::IoProducer producer;
};

struct IoConnection {
    std::uint16_t number = 0;  ///< of Get_Connection_Data
    const assemblies::Connection* kind = nullptr;
    cip::ForwardOpen request;     ///< as it came
    std::uint32_t o_to_t_id = 0;  ///< ours
    std::uint32_t t_to_o_id = 0;  ///< the originator's; ours for multicast (R-CON-16)
    enip::Endpoint originator{};  ///< its address, and where point-to-point data goes
    enip::IoConsumer consumer;
    Production* production = nullptr;  ///< owned by IoConnections, shared for multicast

    [[nodiscard]] bool is_owner() const { return kind->kind == assemblies::Connection::Kind::exclusive_owner; }
    [[nodiscard]] bool is_listener() const { return kind->kind == assemblies::Connection::Kind::listen_only; }
};

/// Datagrams that changed nothing (R-IO-7). What a connection itself counts is in its consumer.
struct StrayCounters {
    std::uint64_t malformed = 0;
    std::uint64_t unknown_id = 0;
    std::uint64_t wrong_source = 0;
    std::uint64_t too_late = 0;  ///< the time of its connection is over
};

class IoConnections {
public:
    /// All references outlive this. The DSCP values are those of now (R-QOS-4).
    IoConnections(DriveIo& drive, const Network& network, ConnectionIds& ids, const Limits& limits, const Log& log);

    /// Steps 8 and 9 of R-CON-15, then the connection: `wanted` has passed check_io_open. Sockaddr items are read from
    /// `origin` and written to it (R-CPF-8). `number` is free.
    [[nodiscard]] OpenResult<const IoConnection*> open(const cip::ForwardOpen& request, const IoOpen& wanted,
                                                       const cip::Origin& origin, std::uint16_t number);
    /// By Forward_Close. An owner's drive stops, and listeners go with the last that they listened to (R-CON-32).
    void close(const IoConnection& connection);
    /// All of them end, because the device gives up the address that they come to. Nobody is told.
    void abandon();

    void on_datagram(enip::Endpoint peer, cip::ByteView octets, enip::Time now);
    /// Produces what is due into `queue`, and ends the connections whose time is over; `timed_out` counts them.
    void on_timer(enip::Time now, enip::IoQueue& queue, std::uint16_t& timed_out);
    /// Values may have changed: what is sent on a change of state looks at them.
    void note_changes(enip::Time now);
    /// There are connections, and all of their productions are cyclic.
    [[nodiscard]] bool tells_at_deadlines() const;
    [[nodiscard]] std::optional<enip::Time> next_deadline() const;

    [[nodiscard]] const IoConnection* find(const cip::ConnectionTriad& triad) const;
    [[nodiscard]] const IoConnection* find(std::uint16_t number) const;
    [[nodiscard]] std::span<const std::unique_ptr<IoConnection>> all() const { return connections_; }
    [[nodiscard]] bool uses(std::uint32_t id) const;
    [[nodiscard]] std::size_t size() const { return connections_.size(); }
    [[nodiscard]] const IoConnection* owner() const { return owner_; }
    /// Multicast groups that are produced to, counted from the first that the device has (R-MC-1).
    [[nodiscard]] std::size_t groups_in_use() const;
    [[nodiscard]] const StrayCounters& strays() const { return strays_; }

    /// What they do, all together (R-ID-4).
    [[nodiscard]] IoCondition condition() const;

private:
    /// Sockaddr items as a request has them.
    struct Sockets {
        std::uint16_t receive_port = enip::io_port;  ///< where the originator wants point-to-point data
        bool present = false;
    };

    [[nodiscard]] OpenResult<Sockets> check_sockets(const cip::Origin& origin) const;
    [[nodiscard]] OpenResult<void> check_owner(const IoOpen& wanted) const;
    [[nodiscard]] OpenResult<void> check_listener(const cip::ForwardOpen& request, const IoOpen& wanted) const;
    [[nodiscard]] OpenResult<void> check_subnet(const cip::ForwardOpen& request, const cip::Origin& origin) const;
    [[nodiscard]] OpenResult<void> check_joining(const cip::ForwardOpen& request, const IoOpen& wanted) const;
    [[nodiscard]] OpenResult<void> check_room(const IoOpen& wanted) const;
    [[nodiscard]] Production* multicast_of(const assemblies::Layout& layout) const;
    [[nodiscard]] Production& produce(const cip::ForwardOpen& request, const IoOpen& wanted, const cip::Origin& origin,
                                      const Sockets& sockets);
    void reply_with_sockets(const IoConnection& connection, const Sockets& sockets, const cip::Origin& origin) const;
    [[nodiscard]] enip::Endpoint group_of(const assemblies::Layout& layout, std::uint32_t local) const;

    void take(IoConnection& connection, const enip::IoPacket& packet, enip::Time now);
    void remove(const IoConnection& connection);
    void remove_orphans();

    DriveIo& drive_;
    const Network& network_;
    ConnectionIds& ids_;
    const Limits& limits_;
    const Log& log_;
    QualityOfService qos_;
    std::vector<std::unique_ptr<IoConnection>> connections_;
    std::vector<std::unique_ptr<Production>> productions_;
    IoConnection* owner_ = nullptr;
    bool faulted_ = false;  ///< a connection has timed out, and none was opened since
    StrayCounters strays_{};
};

/// "exclusive owner 101/100 of 192.168.2.1".
[[nodiscard]] std::string describe(const IoConnection& connection);

}  // namespace servobus::adapter
