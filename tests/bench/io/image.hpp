// The datagrams of connection 103/100 as octets at offsets (R-IO-1, R-IO-2), written down a second time on purpose.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>

#include "tests/bench/io/statistics.hpp"

namespace servobus::bench {

inline constexpr std::size_t o_to_t_octets = 18 + 2 + 4 + 32;
inline constexpr std::size_t t_to_o_octets = 18 + 2 + 28;
inline constexpr std::uint16_t o_to_t_size = 2 + 4 + 32;
inline constexpr std::uint16_t t_to_o_size = 2 + 28;
/// DigitalOutputsXENAX, the last member of 103 and of 100. Bits 16 to 23 are outputs of the drive (60FEh).
inline constexpr std::size_t outputs_in_o_to_t = 18 + 2 + 4 + 28;
inline constexpr std::size_t outputs_in_t_to_o = 18 + 2 + 24;

inline void put16(std::span<std::uint8_t> octets, std::size_t at, std::uint16_t value) {
    for (int i = 0; i < 2; ++i) octets[at++] = static_cast<std::uint8_t>(value >> (8 * i));
}
inline void put32(std::span<std::uint8_t> octets, std::size_t at, std::uint32_t value) {
    for (int i = 0; i < 4; ++i) octets[at++] = static_cast<std::uint8_t>(value >> (8 * i));
}
inline std::uint32_t get32(std::span<const std::uint8_t> octets, std::size_t at) {
    std::uint32_t value = 0;
    if (octets.size() < at + 4) return value;
    for (std::size_t i = 4; i-- > 0;) value = value << 8 | octets[at + i];
    return value;
}

/// `sequence` is that of the encapsulation, its lower half the sequence count of the data.
template <std::size_t Octets>
void write_head(std::array<std::uint8_t, Octets>& octets, std::uint32_t connection, std::uint32_t sequence) {
    put16(octets, 0, 2);
    put16(octets, 2, 0x8002);
    put16(octets, 4, 8);
    put32(octets, 6, connection);
    put32(octets, 10, sequence);
    put16(octets, 14, 0x00B1);
    put16(octets, 16, static_cast<std::uint16_t>(Octets - 18));
    put16(octets, 18, static_cast<std::uint16_t>(sequence));
}

/// In run, with everything else zero: no member of it moves the drive.
inline std::array<std::uint8_t, o_to_t_octets> o_to_t(std::uint32_t connection, std::uint32_t sequence,
                                                      std::uint32_t outputs) {
    std::array<std::uint8_t, o_to_t_octets> octets{};
    write_head(octets, connection, sequence);
    put32(octets, 20, 1);
    put32(octets, outputs_in_o_to_t, outputs);
    return octets;
}

inline std::array<std::uint8_t, t_to_o_octets> t_to_o(std::uint32_t connection, std::uint32_t sequence,
                                                      std::uint32_t outputs) {
    std::array<std::uint8_t, t_to_o_octets> octets{};
    write_head(octets, connection, sequence);
    put32(octets, outputs_in_t_to_o, outputs);
    return octets;
}

inline Arrival read_arrival(std::span<const std::uint8_t> octets, Nanoseconds time) {
    const auto at = octets.size() == o_to_t_octets ? outputs_in_o_to_t : outputs_in_t_to_o;
    return {time, get32(octets, 10), get32(octets, at), get32(octets, 6)};
}

}  // namespace servobus::bench
