// How far the clock of the day is ahead of the one that everything here runs by. It changes when somebody sets the clock
// of the day, and slowly while PTP or NTP keeps it right.
#pragma once

#include <chrono>
#include <optional>

#include "enip/time.hpp"

namespace servobus::enip::asio {

/// The clocks are compared again after this time; who asks more often hears the same again.
inline constexpr std::chrono::milliseconds day_clock_interval{10};

class DayClock {
public:
    /// The two clocks; the second counts from 1970 in UTC.
    struct Clocks {
        Time (*steady)();
        std::chrono::nanoseconds (*day)();
    };

    DayClock();  ///< those of this machine
    explicit DayClock(Clocks clocks) : clocks_(clocks) {}

    /// `now` is of the steady clock, and never goes back.
    [[nodiscard]] std::chrono::nanoseconds ahead(Time now);

private:
    [[nodiscard]] std::chrono::nanoseconds compare() const;

    Clocks clocks_;
    std::optional<Time> next_{};
    std::chrono::nanoseconds ahead_{0};
};

}  // namespace servobus::enip::asio
