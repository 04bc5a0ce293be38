// One direction of a captured TCP connection, put into order and cut into encapsulation messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include "enip/frame_decoder.hpp"
#include "scanner/captured_packet.hpp"

namespace servobus::scanner {

class TcpStream {
public:
    /// Segments that wait for one before them. When there are more, that one is given up: the capture has lost it.
    static constexpr std::size_t max_waiting = 64;

    struct Counters {
        std::uint64_t repeated = 0;   ///< segments that had been seen
        std::uint64_t reordered = 0;  ///< segments that came too early
        std::uint64_t gaps = 0;       ///< places where octets are missing for good
        std::uint64_t skipped = 0;    ///< segments without a message's beginning, after a gap or at the start
    };
    using Sink = std::function<void(const enip::Frame&, CaptureTime)>;

    void take(const CapturedPacket& segment, const Sink& sink);
    /// Nothing more comes: what waits is read, whatever is missing before it.
    void finish(const Sink& sink);
    [[nodiscard]] const Counters& counters() const { return counters_; }

private:
    struct Waiting {
        cip::Bytes octets;
        CaptureTime time;
    };

    void pass_gap(const Sink& sink);
    void read_waiting(const Sink& sink);
    void read(cip::ByteView octets, CaptureTime time, const Sink& sink);

    std::optional<std::uint32_t> next_{};
    // By distance from next_ at the time of arrival, which is turned into a number that only grows.
    std::map<std::uint64_t, Waiting> waiting_;
    std::uint64_t position_ = 0;  ///< octets in front of next_
    bool in_step_ = false;        ///< the next octet belongs to a message whose beginning is known
    enip::FrameDecoder decoder_;
    Counters counters_;
};

}  // namespace servobus::scanner
