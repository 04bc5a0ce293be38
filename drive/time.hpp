// Time as the drive sees it: an argument, never a clock (decision 2).
#pragma once

#include <chrono>
#include <cstdint>

namespace servobus::drive {

/// Since an epoch of the caller's choice; it never goes back.
using Time = std::chrono::microseconds;

/// The period of the position loop (004 §5.3).
inline constexpr Time control_period{100};
inline constexpr double control_period_s = 1e-4;
inline constexpr std::int64_t periods_per_ms = Time(1000) / control_period;

}  // namespace servobus::drive
