// What a capture tells about connections: who opened which, what was answered, and what then flowed.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "cip/forward_open.hpp"
#include "cip/message.hpp"
#include "enip/common_packet.hpp"
#include "enip/endpoint.hpp"
#include "enip/io_packet.hpp"
#include "enip/messages.hpp"
#include "scanner/captured_packet.hpp"
#include "scanner/identity.hpp"
#include "scanner/interval_statistics.hpp"
#include "scanner/tcp_stream.hpp"

namespace servobus::scanner {

/// The class 0 and 1 datagrams of one direction of a connection.
struct CapturedFlow {
    /// Sizes that differ, of which each is counted; any further one counts as the last.
    static constexpr std::size_t max_sizes = 8;
    /// Places where they were sent to.
    static constexpr std::size_t max_destinations = 4;

    std::uint64_t packets = 0;
    CaptureTime first{};
    CaptureTime last{};
    IntervalStatistics statistics{std::chrono::nanoseconds(0)};  ///< against the granted interval
    std::uint64_t repeated = 0;  ///< an unchanged sequence count of class 1: the data is not new
    /// What the first four octets would say if they were a run/idle header.
    std::uint64_t header_run = 0;
    std::uint64_t header_idle = 0;
    std::uint64_t header_odd = 0;                  ///< reserved bits set: this is no header
    std::map<std::size_t, std::uint64_t> sizes{};  ///< of the data item
    std::map<enip::Endpoint, std::uint64_t> destinations{};

    void take(const enip::IoPacket& packet, enip::Endpoint destination, CaptureTime time, bool counted);

private:
    std::optional<std::uint16_t> count_{};
};

/// A Forward_Open and what became of it.
struct CapturedOpen {
    enip::Endpoint originator;
    enip::Endpoint target;  ///< where the request went: a router when there is a route
    CaptureTime asked{};
    cip::Bytes route{};  ///< of the Unconnected_Send around it, encoded
    bool large = false;
    std::optional<cip::ForwardOpen> request{};             ///< nullopt when its lengths are wrong
    std::optional<enip::SocketAddress> wanted_receiver{};  ///< T->O sockaddr item of the request

    std::optional<CaptureTime> answered{};
    cip::Status status{};  ///< when answered
    /// The encapsulation layer refused it.
    std::optional<enip::EncapsulationStatus> encapsulation_status{};
    std::optional<cip::ForwardOpenReply> reply{};          ///< of a success; nullopt too when it makes no sense
    std::optional<enip::SocketAddress> target_receiver{};  ///< sockaddr items of the reply
    std::optional<enip::SocketAddress> given_receiver{};

    CapturedFlow o_to_t{};
    CapturedFlow t_to_o{};

    std::optional<CaptureTime> closing{};  ///< Forward_Close was sent
    std::optional<cip::Status> close_status{};
    std::optional<CaptureTime> replaced{};  ///< when another open got the same ids

    [[nodiscard]] bool granted() const { return answered && status.ok() && reply.has_value(); }
    /// Class 0 or 1, whose data travels by UDP.
    [[nodiscard]] bool carries_io() const { return request && request->transport.transport_class <= 1; }
    /// Where T->O is expected: what the sockaddr items say, or port 2222 of the originator.
    [[nodiscard]] enip::Endpoint expected_receiver() const;
};

/// Reads packets in the order of their times.
class Conversation {
public:
    static constexpr std::size_t max_streams = 4096;  ///< TCP connections
    static constexpr std::size_t max_opens = 512;
    static constexpr std::size_t max_pending = 64;  ///< requests of a connection without reply
    static constexpr std::size_t max_identities = 1024;

    struct Counters {
        std::uint64_t streams_left_out = 0;
        std::uint64_t opens_left_out = 0;
        std::uint64_t io_without_open = 0;  ///< class 0/1 datagrams of connections whose Forward_Open is not there
        std::uint64_t io_malformed = 0;     ///< at port 2222, and no class 0/1 datagram
    };

    void take(const CapturedPacket& packet);
    /// The capture is over.
    void finish();

    [[nodiscard]] const std::vector<CapturedOpen>& opens() const { return opens_; }
    /// Who a node said that it was, in ListIdentity or Get_Attributes_All of its Identity object.
    [[nodiscard]] const Identity* identity(std::uint32_t address) const;
    [[nodiscard]] const Counters& counters() const { return counters_; }
    /// Of all TCP connections together.
    [[nodiscard]] TcpStream::Counters tcp() const;

private:
    enum class Asked : std::uint8_t { open, close, identity };
    struct Pending {
        Asked what;
        bool connected;
        std::uint32_t session;
        enip::SenderContext context;
        std::uint16_t sequence;
        std::size_t open;  ///< index in opens_
    };
    struct Connection {
        enip::Endpoint client;
        enip::Endpoint server;
        TcpStream requests;
        TcpStream replies;
        std::deque<Pending> pending;
    };
    struct Envelope {
        const enip::Frame& frame;
        const enip::SendData& data;
        bool connected;
        std::uint16_t sequence;
        CaptureTime time;
    };

    void take_tcp(const CapturedPacket& packet);
    void take_udp(const CapturedPacket& packet);
    Connection* connection_of(const CapturedPacket& packet);
    void read_frame(Connection& connection, bool request, const enip::Frame& frame, CaptureTime time);
    void read_request(Connection& connection, const Envelope& envelope, cip::ByteView message, cip::ByteView route);
    void read_reply(Connection& connection, const Envelope& envelope, cip::ByteView message);
    void read_identities(const enip::Frame& frame, std::uint32_t address);
    void keep_identity(std::uint32_t address, const Identity& identity);
    void asked_open(Connection& connection, const Envelope& envelope, const cip::Request& request, cip::ByteView route);
    void asked_close(Connection& connection, const Envelope& envelope, const cip::Request& request);
    void expect(Connection& connection, Asked what, const Envelope& envelope, std::size_t open);
    [[nodiscard]] std::optional<Pending> expected(Connection& connection, const Envelope& envelope);
    void answered_open(std::size_t index, const Envelope& envelope, const cip::Response& response);
    bool read_io(const CapturedPacket& packet, const enip::IoPacket& io);

    std::map<std::pair<enip::Endpoint, enip::Endpoint>, Connection> connections_;
    std::vector<CapturedOpen> opens_;
    std::map<std::uint32_t, std::vector<std::size_t>> by_id_;  ///< granted opens by either id
    std::map<std::uint32_t, Identity> identities_;
    Counters counters_;
};

}  // namespace servobus::scanner
