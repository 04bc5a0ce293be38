// Writes captures that Wireshark reads: what a socket has sent and received, in frames as they may have been on the
// wire. The frames are made up, addresses of the link layer and TCP's sequence numbers included; the payloads are not.
// capture_file.hpp reads captures.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <ostream>
#include <utility>

#include "cip/bytes.hpp"
#include "enip/endpoint.hpp"

namespace servobus::scanner {

/// When a packet was on the wire.
using CaptureTime = std::chrono::sys_time<std::chrono::nanoseconds>;

/// A capture of pcapng blocks: one section, one Ethernet interface, times in nanoseconds.
class PcapngWriter {
public:
    /// The most that a datagram of IPv4 holds.
    static constexpr std::size_t max_udp_payload = 65'507;
    /// TCP payloads are cut into segments of this size, as Ethernet does.
    static constexpr std::size_t tcp_segment = 1460;
    /// TCP connections whose sequence numbers are remembered; the oldest begins anew when there are more.
    static constexpr std::size_t max_streams = 1024;

    /// Writes what stands in front of the packets. The stream outlives the writer, and says itself when it fails.
    explicit PcapngWriter(std::ostream& out);

    /// False, and nothing is written, when the payload is longer than a datagram can be.
    bool udp(enip::Endpoint source, enip::Endpoint destination, cip::ByteView payload, CaptureTime time);

    /// The next octets of a TCP stream. A handshake goes before the first of a connection; who listens at port 44818,
    /// or is spoken to first, is its server.
    void tcp(enip::Endpoint source, enip::Endpoint destination, cip::ByteView payload, CaptureTime time);

    /// `source` has closed the connection. Nothing is written when no octet of it has been.
    void tcp_close(enip::Endpoint source, enip::Endpoint destination, CaptureTime time);

    /// Packets written so far, handshakes included.
    [[nodiscard]] std::uint64_t packets() const { return packets_; }

private:
    using Ends = std::pair<enip::Endpoint, enip::Endpoint>;  ///< the smaller end first
    struct Stream {
        std::uint64_t age = 0;
        std::uint32_t next_of_first = 0;
        std::uint32_t next_of_second = 0;
        std::size_t unacknowledged = 0;
    };

    Stream& stream(enip::Endpoint source, enip::Endpoint destination, CaptureTime time);
    void segment(enip::Endpoint source, enip::Endpoint destination, Stream& stream, std::uint8_t flags,
                 cip::ByteView payload, CaptureTime time);
    void begin_frame(enip::Endpoint source, enip::Endpoint destination, std::uint8_t protocol,
                     std::size_t transport_octets);
    void write_frame(CaptureTime time);

    std::ostream& out_;
    std::uint64_t packets_ = 0;
    std::uint16_t datagram_ = 0;
    std::map<Ends, Stream> streams_;
    std::uint64_t opened_ = 0;
    cip::Bytes frame_;
    cip::Bytes block_;
};

}  // namespace servobus::scanner
