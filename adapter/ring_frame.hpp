// The frames of Device Level Ring (DLR, R-DLR-7 to R-DLR-11).
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "adapter/mac_address.hpp"
#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"

namespace servobus::adapter {

enum class RingFrameType : std::uint8_t {
    beacon = 1,
    neighbor_check_request,
    neighbor_check_response,
    status,  ///< of a node's links, or of its neighbors
    locate_fault,
    announce,
    sign_on,
    advertise,
    flush_tables,
    learning_update,
};

/// Where frames go that are for more than one node (R-DLR-11).
inline constexpr MacAddress ring_beacon_mac{0x01, 0x21, 0x6C, 0x00, 0x00, 0x01};
inline constexpr MacAddress ring_neighbor_mac{0x01, 0x21, 0x6C, 0x00, 0x00, 0x02};
inline constexpr MacAddress ring_announce_mac{0x01, 0x21, 0x6C, 0x00, 0x00, 0x03};
inline constexpr MacAddress ring_learning_mac{0x01, 0x21, 0x6C, 0x00, 0x00, 0x05};

/// The header, and behind it what belongs to the type. Numbers are big-endian on the wire.
struct RingFrame {
    MacAddress destination{};
    MacAddress source{};
    RingFrameType type{};
    std::uint8_t source_port = 0;      ///< 1 or 2; 0 is both, or not known
    std::uint32_t source_address = 0;  ///< IPv4, host order; 0: none
    std::uint32_t sequence = 0;
    cip::ByteView content{};  ///< of the caller; when it was received, with the padding

    /// With priority 7 in a VLAN tag, except a learning update.
    [[nodiscard]] cip::Bytes encode() const;
    /// With or without a tag. `truncated`; `bad_value`: no frame of a ring, or of another version.
    [[nodiscard]] static cip::Decoded<RingFrame> parse(cip::ByteView octets);
};

enum class RingState : std::uint8_t { normal = 1, fault = 2 };

/// What a beacon carries (R-DLR-8).
struct Beacon {
    RingState state{};
    std::uint8_t precedence = 0;
    std::uint32_t interval = 0;  ///< us
    std::uint32_t timeout = 0;   ///< us

    [[nodiscard]] cip::Bytes encode() const;
    /// `bad_value`: another state than these two, or a timeout of nothing.
    [[nodiscard]] static cip::Decoded<Beacon> parse(cip::ByteView content);
};

/// A node of the list that a sign-on collects.
struct SignOnEntry {
    MacAddress mac{};
    std::uint32_t address = 0;
    friend bool operator==(const SignOnEntry&, const SignOnEntry&) = default;
};

/// As many as a frame of 1518 octets has room for.
inline constexpr std::size_t max_sign_on_entries = 148;

[[nodiscard]] cip::Bytes encode_sign_on(const std::vector<SignOnEntry>& entries);
/// `truncated`, or `too_many`.
[[nodiscard]] cip::Decoded<std::vector<SignOnEntry>> parse_sign_on(cip::ByteView content);

}  // namespace servobus::adapter
