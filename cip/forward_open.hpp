// Forward_Open, Large_Forward_Open and Forward_Close: requests and replies (R-CON-1 to R-CON-5, R-CON-13, R-CON-34).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"
#include "cip/message.hpp"
#include "cip/path.hpp"

namespace servobus::cip {

enum class ConnectionType : std::uint8_t { null = 0, multicast = 1, point_to_point = 2, reserved = 3 };
enum class Priority : std::uint8_t { low = 0, high = 1, scheduled = 2, urgent = 3 };

/// The network connection parameters of one direction: 16 bits in Forward_Open (R-CON-3), 32 in the large form (R-CON-4).
struct ConnectionParameters {
    bool redundant_owner = false;
    ConnectionType type = ConnectionType::point_to_point;
    Priority priority = Priority::low;
    bool variable = false;
    std::uint16_t size = 0;  ///< octets inside the data item; at most 511 in the 16-bit form

    [[nodiscard]] static ConnectionParameters from_word(std::uint16_t word);
    [[nodiscard]] static ConnectionParameters from_dword(std::uint32_t dword);
    [[nodiscard]] std::uint16_t to_word() const;
    [[nodiscard]] std::uint32_t to_dword() const;
    friend bool operator==(const ConnectionParameters&, const ConnectionParameters&) = default;
};

/// What names a connection until it is closed (R-CON-22).
struct ConnectionTriad {
    std::uint16_t serial_number = 0;
    std::uint16_t originator_vendor = 0;
    std::uint32_t originator_serial = 0;
    friend auto operator<=>(const ConnectionTriad&, const ConnectionTriad&) = default;
};

/// The transport class and trigger octet (R-CON-5).
struct Transport {
    bool server = false;
    std::uint8_t trigger = 0;          ///< 0 cyclic, 1 change of state, 2 application
    std::uint8_t transport_class = 0;  ///< 0..15, as on the wire

    [[nodiscard]] static Transport from_byte(std::uint8_t byte);
    [[nodiscard]] std::uint8_t to_byte() const;
    friend bool operator==(const Transport&, const Transport&) = default;
};

/// The request data of service 0x54 or, when `large`, 0x5B. Intervals in microseconds.
struct ForwardOpen {
    bool large = false;
    std::uint8_t priority_tick = 0x0A;
    std::uint8_t timeout_ticks = 0x0E;
    std::uint32_t o_to_t_id = 0;
    std::uint32_t t_to_o_id = 0;
    ConnectionTriad triad;
    std::uint8_t timeout_multiplier = 0;  ///< code 0..7 for 4..512 (R-CON-6)
    std::uint32_t o_to_t_rpi = 0;
    ConnectionParameters o_to_t;
    std::uint32_t t_to_o_rpi = 0;
    ConnectionParameters t_to_o;
    Transport transport;
    Bytes path;  ///< the encoded connection path; may be malformed, which has its own status

    [[nodiscard]] Bytes encode() const;
    /// truncated or trailing when the data ends before or after the connection path (0x13, 0x15).
    [[nodiscard]] static Decoded<ForwardOpen> parse(ByteView data, bool large);
    friend bool operator==(const ForwardOpen&, const ForwardOpen&) = default;
};

/// The data of a successful reply, 26 octets and the application reply (R-CON-13).
struct ForwardOpenReply {
    std::uint32_t o_to_t_id = 0;
    std::uint32_t t_to_o_id = 0;
    ConnectionTriad triad;
    std::uint32_t o_to_t_api = 0;
    std::uint32_t t_to_o_api = 0;
    Bytes application_reply;  ///< a whole number of words

    [[nodiscard]] Bytes encode() const;
    [[nodiscard]] static Decoded<ForwardOpenReply> parse(ByteView data);
    friend bool operator==(const ForwardOpenReply&, const ForwardOpenReply&) = default;
};

/// The data behind a refusal of any of the three services (R-CON-14).
struct ConnectionRefusal {
    ConnectionTriad triad;
    std::uint8_t remaining_path_words = 0;

    [[nodiscard]] Bytes encode() const;
    [[nodiscard]] static Decoded<ConnectionRefusal> parse(ByteView data);
    friend bool operator==(const ConnectionRefusal&, const ConnectionRefusal&) = default;
};

/// What a refusal with 0x0112 says about an interval (R-CON-14).
enum class RpiKind : std::uint8_t { acceptable = 0, unspecified = 1, minimum = 2, maximum = 3, required = 4 };

/// The extended words of 0x0112: which intervals, in microseconds, would be accepted.
struct RpiRefusal {
    RpiKind o_to_t_kind = RpiKind::acceptable;
    RpiKind t_to_o_kind = RpiKind::acceptable;
    std::uint32_t o_to_t = 0;
    std::uint32_t t_to_o = 0;

    [[nodiscard]] Status status() const;
    /// Nullopt when the status is another one, or says no more than 0x0112.
    [[nodiscard]] static std::optional<RpiRefusal> from(const Status& status);
    friend bool operator==(const RpiRefusal&, const RpiRefusal&) = default;
};

/// The production inhibit time in a connection path, in microseconds: segment 0x43 in ms, 0x51 in microseconds
/// (R-CON-51). Nullopt when there is none; the segments have the data that R-PTH-7 gives them, or are passed over.
[[nodiscard]] std::optional<std::uint32_t> production_inhibit_time(const Path& path);
/// The shorter of the two segments that can say it.
[[nodiscard]] NetworkSegment production_inhibit_segment(std::uint32_t microseconds);

/// The request data of service 0x4E.
struct ForwardClose {
    std::uint8_t priority_tick = 0x0A;
    std::uint8_t timeout_ticks = 0x0E;
    ConnectionTriad triad;
    Bytes path;

    [[nodiscard]] Bytes encode() const;
    [[nodiscard]] static Decoded<ForwardClose> parse(ByteView data);
    friend bool operator==(const ForwardClose&, const ForwardClose&) = default;
};

/// The data of a successful Forward_Close reply: triad, application reply size, reserved.
struct ForwardCloseReply {
    ConnectionTriad triad;
    Bytes application_reply;

    [[nodiscard]] Bytes encode() const;
    [[nodiscard]] static Decoded<ForwardCloseReply> parse(ByteView data);
    friend bool operator==(const ForwardCloseReply&, const ForwardCloseReply&) = default;
};

}  // namespace servobus::cip
