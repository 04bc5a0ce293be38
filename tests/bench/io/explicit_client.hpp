// Explicit messages over a plain socket: one request after the other.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "cip/forward_open.hpp"
#include "cip/message.hpp"
#include "tests/bench/io/sockets.hpp"

namespace servobus::bench {

class ExplicitClient {
public:
    /// Waits until somebody listens, and registers a session. `local_address` 0: whatever the system takes.
    explicit ExplicitClient(enip::Endpoint peer, std::uint32_t local_address = 0);

    /// The frame of an unconnected request.
    [[nodiscard]] cip::Bytes frame(const cip::Request& request) const;
    /// Sends a frame and reads its reply, header and all.
    [[nodiscard]] const cip::Bytes& exchange(const cip::Bytes& frame);
    [[nodiscard]] cip::Response call(const cip::Request& request);
    /// Opens a class 3 connection to the Message Router; the frame of a request over it, its sequence count still 0.
    [[nodiscard]] cip::Bytes connected_frame(const cip::Request& request);
    [[nodiscard]] const Descriptor& socket() const { return socket_; }
    /// The session is the caller's from now on.
    [[nodiscard]] Descriptor release() { return std::move(socket_); }

private:
    Descriptor socket_;
    std::uint32_t session_ = 0;
    cip::Bytes reply_;
};

/// Of a connection that this process has not opened before.
[[nodiscard]] cip::ConnectionTriad new_triad();
/// Get_Attribute_Single of PositionActualValue.
[[nodiscard]] cip::Request read_position();
/// `count` of them in a Multiple_Service_Packet; 1: alone.
[[nodiscard]] cip::Request read_positions(std::size_t count);

}  // namespace servobus::bench
