// Whether a server wakes for each class 0 and 1 datagram, or looks for them when something is due anyway. Waking costs more
// than all the rest that is done for a datagram.
#pragma once

#include <chrono>
#include <cstddef>

#include "enip/time.hpp"

namespace servobus::enip::asio {

/// From so many datagrams a second on a server is busy, and until it is half as many.
inline constexpr std::size_t busy_datagrams_per_second = 4000;
/// They are counted for so long.
inline constexpr std::chrono::milliseconds rhythm_window{20};
/// How long a datagram waits at most to be looked at.
inline constexpr std::chrono::milliseconds longest_io_wait{1};

class IoRhythm {
public:
    /// So many have come since the last call.
    void count(std::size_t datagrams, Time now) {
        count_ += datagrams;
        const auto passed = now - since_;
        if (passed < rhythm_window) return;
        const auto in_window = busy_datagrams_per_second * static_cast<std::size_t>(rhythm_window.count()) / 1000;
        // A window that has become long has had few of them, whatever came at its end.
        const bool on_time = passed < 2 * rhythm_window;
        busy_ = on_time && count_ >= (busy_ ? in_window / 2 : in_window);
        count_ = 0;
        since_ = now;
    }
    [[nodiscard]] bool is_busy() const { return busy_; }

private:
    std::size_t count_ = 0;
    Time since_{};
    bool busy_ = false;
};

}  // namespace servobus::enip::asio
