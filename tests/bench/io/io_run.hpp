// A stretch of cyclic traffic as the measuring originator sees it.
#pragma once

#include <optional>
#include <vector>

#include "tests/bench/io/sockets.hpp"
#include "tests/bench/io/statistics.hpp"

namespace servobus::bench {

/// Where O->T datagrams go.
struct Outlet {
    enip::Endpoint peer;
    std::uint32_t connection = 0;
    std::uint32_t first_sequence = 1;
};

struct RunSettings {
    double seconds = 10;
    double interval_us = 1000;
    /// Sends at any time within the interval, so that the latency of an action does not hang on how the intervals of
    /// both directions happen to lie to each other.
    bool dither = false;
};

struct IoRun {
    std::vector<Arrival> arrivals;
    std::vector<double> action_us;  ///< from the change of an output to the first T->O datagram that shows it
    std::size_t changes = 0;        ///< of the output; those never seen are changes less action_us
    std::uint32_t sent = 0;         ///< O->T datagrams
};

/// Receives for a while and, when there is an outlet, sends to it once per interval.
[[nodiscard]] IoRun run_io(Receiver& receiver, const std::optional<Outlet>& outlet, const RunSettings& settings);

/// Sleeps to absolute deadlines of `interval_us` and does nothing else: how late it wakes up, as arrivals of a clock.
struct TimerRun {
    std::vector<double> late_us;
    Intervals intervals;
};
enum class TimerKind { nanosleep, timerfd };
[[nodiscard]] TimerRun run_timer(TimerKind kind, const RunSettings& settings);

}  // namespace servobus::bench
