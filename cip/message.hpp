// The message router's request and reply (R-MSG-1, R-MSG-2).
#pragma once

#include <cstdint>

#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"
#include "cip/path.hpp"
#include "cip/status.hpp"
#include "cip/wire.hpp"

namespace servobus::cip {

/// A service, where it goes, and its data.
struct Request {
    std::uint8_t service = 0;
    Path path;
    Bytes data;

    [[nodiscard]] Bytes encode() const;
    /// For whoever reads requests without answering them; a target uses RequestView, which tells its errors apart.
    [[nodiscard]] static Decoded<Request> parse(ByteView message);
    friend bool operator==(const Request&, const Request&) = default;
};

/// A request in the octets that it came in: the path is not looked at yet.
struct RequestView {
    std::uint8_t service = 0;
    ByteView path;
    ByteView data;

    /// Fails with truncated when there is no service and path size, path_too_long when the path is not all there.
    /// `service` is known in the second case: the octet in front.
    [[nodiscard]] static Decoded<RequestView> parse(ByteView message);
};

/// A reply. `service` is the request's; the reply bit is added and taken off on the wire.
struct Response {
    std::uint8_t service = 0;
    Status status{};
    Bytes data{};

    /// Appends it.
    void write(Writer& writer) const;
    [[nodiscard]] Bytes encode() const;
    [[nodiscard]] std::size_t encoded_size() const { return 4 + 2 * status.extended.size() + data.size(); }
    /// The reserved octet is not checked (R-SCN-6). Fails with bad_value when the reply bit is missing.
    [[nodiscard]] static Decoded<Response> parse(ByteView message);
    friend bool operator==(const Response&, const Response&) = default;
};

}  // namespace servobus::cip
