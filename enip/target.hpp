// What a server of this protocol is to its sockets: octets and time in, octets and the next deadline out (decision 2).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cip/bytes.hpp"
#include "enip/dscp.hpp"
#include "enip/endpoint.hpp"
#include "enip/io_queue.hpp"
#include "enip/time.hpp"

namespace servobus::enip {

/// A datagram to send.
struct Datagram {
    Endpoint local;  ///< the address to send it from; 0 when the system may choose
    Endpoint peer;
    cip::Bytes octets;
};

/// A target without sockets. All calls come from one thread at a time; `now` never goes back.
class Target {
public:
    using ConnectionId = std::uint64_t;

    virtual ~Target() = default;

    /// A TCP connection has been accepted. Nullopt: close it at once.
    [[nodiscard]] virtual std::optional<ConnectionId> on_open(Endpoint peer, Endpoint local, Time now) = 0;

    /// Octets of a connection. Returns how many were taken: fewer than given when the replies that wait have reached
    /// their limit, or others should have their turn; write the replies and offer the rest again.
    [[nodiscard]] virtual std::size_t on_octets(ConnectionId id, cip::ByteView octets, Time now) = 0;

    /// The replies that wait, gathered; they are the caller's now.
    [[nodiscard]] virtual cip::Bytes take_replies(ConnectionId id) = 0;

    /// True when the connection is to be closed, once its replies are written.
    [[nodiscard]] virtual bool wants_close(ConnectionId id) const = 0;

    /// The connection is gone, whoever closed it. The id is not used again.
    virtual void on_closed(ConnectionId id, Time now) = 0;

    /// A datagram at UDP 44818. `broadcast`: it was not sent to `local` alone.
    virtual void on_datagram(Endpoint peer, Endpoint local, bool broadcast, cip::ByteView octets, Time now) = 0;

    /// The datagrams that are due.
    [[nodiscard]] virtual std::vector<Datagram> take_datagrams() = 0;

    /// What the packets of TCP and of those datagrams carry (R-QOS-5). It may change when the target restarts.
    [[nodiscard]] virtual std::uint8_t explicit_dscp() const { return dscp_explicit; }

    /// A datagram at the port of class 0 and 1 (UDP 2222), which carries data of a connection or nothing that counts.
    virtual void on_io(Endpoint peer, Endpoint local, cip::ByteView octets, Time now) = 0;

    /// True while what such a datagram brings is told at deadlines alone: then a server that is busy may bring all of them
    /// when the next one comes, and need not wake for each.
    [[nodiscard]] virtual bool io_may_wait() const { return false; }

    /// The class 0 and 1 datagrams that are due, to leave from that port. Whoever has sent them clears the queue.
    [[nodiscard]] virtual IoQueue& io_queue() = 0;

    /// To be called when serving starts, and at or after next_deadline().
    virtual void on_timer(Time now) = 0;
    [[nodiscard]] virtual std::optional<Time> next_deadline() const = 0;

    /// How far the clock of the day, which counts from 1970 in UTC, is ahead of that of `now`: to be told again and again,
    /// because somebody may set it or keep it right.
    virtual void on_day_clock(std::chrono::nanoseconds /*ahead*/) {}

    /// Connections that on_timer() or on_open() has decided to close.
    [[nodiscard]] virtual std::vector<ConnectionId> take_expired() = 0;

    /// Connections whose replies have become ready otherwise than by their own on_octets(): to be written now.
    [[nodiscard]] virtual std::vector<ConnectionId> take_ready() { return {}; }

protected:
    Target() = default;
    Target(const Target&) = default;
    Target& operator=(const Target&) = default;
};

}  // namespace servobus::enip
