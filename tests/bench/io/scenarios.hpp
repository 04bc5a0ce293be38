// What is measured, each beside its floor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/bench/io/report.hpp"

namespace servobus::bench {

struct Settings {
    std::string adapter;  ///< the program
    std::vector<std::string> adapter_options;
    double seconds = 10;
    std::uint32_t interval_us = 1000;
    double load_rate = 80'000;        ///< attributes a second
    std::size_t load_attributes = 1;  ///< with each request
    std::vector<std::size_t> drives{1, 7, 8, 32, 128};
    std::vector<std::uint32_t> many_intervals_us{1000};
    /// Of the first drive; others follow it. The measuring originator has an address beside them.
    std::uint32_t address = 0;
    [[nodiscard]] std::uint32_t own_address() const { return (address & 0xFFFFFF00) | 250; }
};

/// (a) timer, (b) paced sender, (c) UDP echo, (d) TCP ping-pong, alone and beside a busy core.
void measure_floors(const Settings& settings, Report& report);
/// Measured packet interval of T->O, alone and while another client reads attributes.
void measure_target_intervals(const Settings& settings, Report& report);
/// Action and response latency.
void measure_latencies(const Settings& settings, Report& report);
/// Rate, waits and CPU of explicit requests: one session, many, many requests on their way, class 3.
void measure_request_rates(const Settings& settings, Report& report);
/// Resident memory of a drive, a session, a connection, and each further drive.
void measure_memory(const Settings& settings, Report& report);
/// From the start of the process to its first answer.
void measure_start(const Settings& settings, Report& report);
/// Explicit requests and class 1 datagrams, as many as pass without a loss.
void measure_throughput(const Settings& settings, Report& report);
/// Measured packet interval of O->T, as the product's originator sends it.
void measure_originator_intervals(const Settings& settings, Report& report);
/// Many drives of one adapter, all owned by one originator.
void measure_many_drives(const Settings& settings, Report& report);

}  // namespace servobus::bench
