// The clocks of the benchmark, in nanoseconds. The kernel stamps datagrams with CLOCK_REALTIME; deadlines are those of
// CLOCK_MONOTONIC. Both run at the same rate, so a drift measured by one is the drift by the other.
#pragma once

#include <cerrno>
#include <cstdint>
#include <ctime>

namespace servobus::bench {

using Nanoseconds = std::int64_t;

inline constexpr Nanoseconds second = 1'000'000'000;

inline Nanoseconds nanoseconds(const timespec& time) { return time.tv_sec * second + time.tv_nsec; }

inline timespec to_timespec(Nanoseconds time) { return {time / second, time % second}; }

inline Nanoseconds monotonic() {
    timespec time{};
    ::clock_gettime(CLOCK_MONOTONIC, &time);
    return nanoseconds(time);
}

inline Nanoseconds realtime() {
    timespec time{};
    ::clock_gettime(CLOCK_REALTIME, &time);
    return nanoseconds(time);
}

/// False when a signal has come before.
inline bool sleep_until(Nanoseconds deadline) {
    const auto time = to_timespec(deadline);
    return ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) == 0;
}

}  // namespace servobus::bench
