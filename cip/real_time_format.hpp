// The real-time formats of class 0 and 1 data: what stands beside the application's octets (R-CON-7, R-CON-8).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace servobus::cip {

/// The numbers are those of the connection entries of an EDS (R-EDS-9).
enum class RealTimeFormat : std::uint8_t {
    modeless = 0,     ///< data alone, always run
    zero_length = 1,  ///< data: run, none: idle; needs a variable size
    heartbeat = 3,    ///< never data
    header32 = 4,     ///< a 32-bit run/idle header, then data
};

inline constexpr std::size_t sequence_count_octets = 2;  ///< in front of everything else in class 1
inline constexpr std::size_t run_idle_octets = 4;
inline constexpr std::uint32_t run_bit = 1;  ///< of the run/idle header

/// The connection size that a direction has in class 1: everything inside the data item.
[[nodiscard]] constexpr std::size_t connection_size(RealTimeFormat format, std::size_t data_octets) {
    const std::size_t header = format == RealTimeFormat::header32 ? run_idle_octets : 0;
    return sequence_count_octets + header + (format == RealTimeFormat::heartbeat ? 0 : data_octets);
}

/// "32-bit run/idle header".
[[nodiscard]] constexpr std::string_view name(RealTimeFormat format) {
    switch (format) {
        case RealTimeFormat::modeless:
            return "modeless";
        case RealTimeFormat::zero_length:
            return "zero length";
        case RealTimeFormat::heartbeat:
            return "heartbeat";
        case RealTimeFormat::header32:
            return "32-bit run/idle header";
    }
    return "reserved";
}

}  // namespace servobus::cip
