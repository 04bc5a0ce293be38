// Unconnected_Send: a request with the route that it takes (R-CM-9, R-CM-10).
#pragma once

#include <chrono>
#include <cstdint>

#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"

namespace servobus::cip {

/// The request data of service 0x52. The reply is the embedded service's own, unless the route fails.
struct UnconnectedSend {
    std::uint8_t priority_tick = 0x0A;  ///< bits 3..0: a tick is 2^n ms
    std::uint8_t timeout_ticks = 0x05;
    Bytes message;     ///< the embedded request, encoded
    Bytes route_path;  ///< port segments, encoded; may be malformed, which has its own status

    [[nodiscard]] std::chrono::milliseconds timeout() const {
        return std::chrono::milliseconds{std::int64_t{timeout_ticks} << (priority_tick & 0x0F)};
    }

    [[nodiscard]] Bytes encode() const;
    /// truncated or trailing when the length fields and the data do not agree.
    [[nodiscard]] static Decoded<UnconnectedSend> parse(ByteView data);
    friend bool operator==(const UnconnectedSend&, const UnconnectedSend&) = default;
};

}  // namespace servobus::cip
