// The DSCP values that EtherNet/IP traffic carries unless somebody has chosen others (R-QOS-2, R-QOS-5).
#pragma once

#include <cstdint>

namespace servobus::enip {

inline constexpr std::uint8_t dscp_urgent = 55;  ///< class 0 and 1, by the priority of the direction
inline constexpr std::uint8_t dscp_scheduled = 47;
inline constexpr std::uint8_t dscp_high = 43;
inline constexpr std::uint8_t dscp_low = 31;
inline constexpr std::uint8_t dscp_ptp_event = 59;    ///< PTP messages that are time stamped
inline constexpr std::uint8_t dscp_ptp_general = 47;  ///< the others of PTP
inline constexpr std::uint8_t dscp_explicit = 27;     ///< all at TCP and UDP 44818

}  // namespace servobus::enip
