// What the Connection Manager tells of a connection: Get_Connection_Data, Search_Connection_Data and
// Get_Connection_Owner (R-CM-7, R-CM-8).
#pragma once

#include <cstdint>

#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"
#include "cip/forward_open.hpp"

namespace servobus::cip {

/// States of a connection (R-CO-1), as far as one that can be asked for has them.
inline constexpr std::uint16_t connection_established = 3;

/// The reply of services 0x56 and 0x57, 56 octets. Intervals in microseconds.
struct ConnectionData {
    std::uint16_t number = 0;
    std::uint16_t state = connection_established;
    std::uint16_t originator_port = 0;
    std::uint16_t target_port = 0;
    ConnectionTriad triad;
    std::uint32_t o_to_t_id_at_originator = 0;
    std::uint32_t o_to_t_id_at_target = 0;
    std::uint8_t o_to_t_multiplier = 0;
    std::uint32_t o_to_t_rpi = 0;
    std::uint32_t o_to_t_api = 0;
    std::uint32_t t_to_o_id_at_originator = 0;
    std::uint32_t t_to_o_id_at_target = 0;
    std::uint8_t t_to_o_multiplier = 0;
    std::uint32_t t_to_o_rpi = 0;
    std::uint32_t t_to_o_api = 0;

    [[nodiscard]] Bytes encode() const;
    [[nodiscard]] static Decoded<ConnectionData> parse(ByteView data);
    friend bool operator==(const ConnectionData&, const ConnectionData&) = default;
};

/// The reply of service 0x5A: how many connections a path has, and who owns it.
struct ConnectionOwner {
    std::uint8_t connections = 0;
    std::uint8_t claim_output_ownership = 0;
    std::uint8_t ready_for_ownership = 0;
    std::uint8_t last_action = 0;
    ConnectionTriad triad;

    [[nodiscard]] Bytes encode() const;
    [[nodiscard]] static Decoded<ConnectionOwner> parse(ByteView data);
    friend bool operator==(const ConnectionOwner&, const ConnectionOwner&) = default;
};

}  // namespace servobus::cip
