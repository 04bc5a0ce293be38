// The floor that a benchmark is compared with: a mass that is integrated and nothing else. Counter `x_floor` says how
// many times as long something takes, measured in the same run, which is what can be compared between machines.
#pragma once

#include <benchmark/benchmark.h>

#include <chrono>

#include "drive/time.hpp"

namespace servobus::drive {

/// Ten multiplications and additions that wait for each other.
struct Floor {
    double position = 0;
    double velocity = 0;

    void step() {
        const double error = 1000 - position;
        const double force = 100 * error - 20 * velocity;
        velocity += control_period_s * (force - 0.8 * velocity);
        position += control_period_s * velocity;
    }
};

inline double floor_ns() {
    static const double result = [] {
        constexpr int steps = 10'000'000;
        Floor floor;
        const auto begin = std::chrono::steady_clock::now();
        for (int i = 0; i < steps; ++i) {
            floor.step();
            benchmark::DoNotOptimize(floor);
        }
        return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count() / steps;
    }();
    return result;
}

/// Runs `step` for as long as the benchmark wants, and sets it in relation to the floor.
template <class Step>
void measure(benchmark::State& state, Step step) {
    const double floor = floor_ns();
    const auto begin = std::chrono::steady_clock::now();
    for (auto _ : state) {
        step();
    }
    const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - begin;
    state.counters["x_floor"] = spent.count() / static_cast<double>(state.iterations()) / floor;
}

}  // namespace servobus::drive
