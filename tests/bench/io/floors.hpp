// The floors: the least that a program on this machine needs for the same, measured in the same run.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/bench/io/explicit_client.hpp"
#include "tests/bench/io/scenarios.hpp"

namespace servobus::bench {

/// What somebody's datagrams are like at the receiver, and what one costs his process.
struct SenderRun {
    Intervals intervals;
    double cpu_us = 0;       ///< per packet
    std::size_t closed = 0;  ///< how often the connection was lost and opened again
};
[[nodiscard]] SenderRun bare_sender(const Settings& settings, double seconds);

/// The product between two runs of the bare paced sender, and once more beside one that sends at the same time: rows of
/// all, and the ratios to both.
void compare_with_floors(const Settings& settings, const std::string& product, const std::string& condition,
                         const std::function<SenderRun()>& run, Report& report);

/// Round trips of `octets` over UDP, and over TCP, in microseconds.
[[nodiscard]] std::vector<double> udp_round_trips(const Settings& settings, std::size_t count, std::size_t octets);
[[nodiscard]] std::vector<double> tcp_round_trips(const Settings& settings, std::size_t count, std::size_t octets);

/// Calls `action` `count` times, and says how long each took, in microseconds.
[[nodiscard]] std::vector<double> timed(std::size_t count, const auto& action) {
    std::vector<double> result;
    for (std::size_t i = 0; i < count; ++i) {
        const auto begin = monotonic();
        action();
        result.push_back(static_cast<double>(monotonic() - begin) / 1000);
    }
    return result;
}

}  // namespace servobus::bench
