// How much of a CPU this process uses.
#pragma once

#include <chrono>
#include <cstdint>

#include "enip/time.hpp"

namespace servobus::enip::asio {

/// What is told is an average over at least this time; who asks more often hears the same again.
inline constexpr std::chrono::milliseconds cpu_load_interval{1000};

class CpuLoad {
public:
    CpuLoad();

    /// Tenths of a percent of one CPU, at most 1000: since the last interval, or since this was made.
    [[nodiscard]] std::uint16_t read();

private:
    Time since_;
    std::chrono::nanoseconds used_;
    std::uint16_t load_ = 0;
};

}  // namespace servobus::enip::asio
