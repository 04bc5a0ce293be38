// Captures for tests: the golden vectors' conversations, and I/O that flows or does not, as our writer puts them.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include "cip/forward_open.hpp"
#include "cip/message.hpp"
#include "enip/encapsulation.hpp"
#include "enip/io_packet.hpp"
#include "enip/messages.hpp"
#include "scanner/capture.hpp"
#include "scanner/capture_file.hpp"
#include "scanner/pcapng.hpp"
#include "tests/support/golden.hpp"

namespace servobus::scanner::test {

using namespace std::chrono_literals;
using servobus::test::golden_vectors;
using servobus::test::octets;

inline constexpr enip::Endpoint originator{0xC0A8020A, 50'000};
inline constexpr enip::Endpoint target{0xC0A80264, enip::tcp_port};
inline constexpr enip::Endpoint originator_io{originator.address, enip::io_port};
inline constexpr enip::Endpoint target_io{target.address, enip::io_port};
inline constexpr CaptureTime capture_begin{1'700'000'000s};

inline cip::Bytes octets_of(const std::string& text) { return {text.begin(), text.end()}; }

/// A capture under construction; time goes on by a millisecond with each message unless it is told otherwise.
class SampleCapture {
public:
    PcapngWriter& writer() { return writer_; }
    CaptureTime now() const { return now_; }
    void wait(std::chrono::nanoseconds time) { now_ += time; }

    void say(bool request, cip::ByteView frame) {
        writer_.tcp(request ? originator : target, request ? target : originator, frame, now_);
        now_ += 1ms;
    }
    void io(bool o_to_t, cip::ByteView datagram, enip::Endpoint destination) {
        writer_.udp(o_to_t ? originator_io : target_io, destination, datagram, now_);
    }
    void io(bool o_to_t, cip::ByteView datagram) { io(o_to_t, datagram, o_to_t ? target_io : originator_io); }

    /// A scene of the golden vectors, or one of its messages and the reply.
    void golden(unsigned scene, const std::string& prefix = {}) {
        for (const auto& vector : golden_vectors()) {
            if (vector.scene != scene || !vector.name.starts_with(prefix)) continue;
            if (vector.name.ends_with("_rep") && vector.name.starts_with("fo_")) {
                // 239.192.13.96 in the sockaddr item.
                const auto group = octets("EF C0 0D 60");
                const bool multicast = !std::ranges::search(vector.octets, group).empty();
                receiver_ = {multicast ? 0xEFC00D60 : originator.address, enip::io_port};
            }
            if (vector.transport == "tcp") say(vector.is_request(), vector.octets);
            if (vector.transport != "udp") continue;
            if (vector.port == enip::tcp_port) {
                writer_.udp(vector.is_request() ? originator : target, vector.is_request() ? target : originator,
                            vector.octets, now_);
            } else {
                io(vector.is_request(), vector.octets, vector.is_request() ? target_io : receiver_);
            }
            now_ += 10ms;
        }
    }

    std::string text() const { return out_.str(); }

private:
    std::ostringstream out_;
    PcapngWriter writer_{out_};
    CaptureTime now_ = capture_begin;
    enip::Endpoint receiver_ = originator_io;  ///< of T->O
};

/// A class 1 datagram; `header` goes in front of the data where there is one.
inline cip::Bytes io_datagram(std::uint32_t id, std::uint32_t sequence, cip::ByteView data) {
    cip::Bytes datagram(enip::io_packet_overhead + 2 + data.size());
    const auto place = enip::begin_io_packet(datagram, id, sequence);
    place[0] = static_cast<std::uint8_t>(sequence);
    place[1] = static_cast<std::uint8_t>(sequence >> 8);
    std::copy(data.begin(), data.end(), place.begin() + 2);
    return datagram;
}

struct ReadCapture {
    CaptureSummary summary;
    Conversation conversation;
};

inline ReadCapture read(const std::string& text) {
    std::istringstream file(text);
    ReadCapture capture;
    capture.summary = read_capture(file, [&](const CapturedPacket& packet) { capture.conversation.take(packet); });
    capture.conversation.finish();
    return capture;
}

}  // namespace servobus::scanner::test
