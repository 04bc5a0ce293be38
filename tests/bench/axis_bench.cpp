// What a control period of the axis alone costs.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdint>

#include "drive/axis.hpp"
#include "drive/time.hpp"
#include "tests/bench/floor.hpp"

namespace servobus::drive {
namespace {

MotionLimits limits() { return {100'000, 1'000'000, jerk_of(1'000'000, 100'000, 20)}; }

Axis standing_axis() {
    Axis axis(AxisKind{}, 1);
    axis.switch_on();
    for (int i = 0; i < 1'000; ++i) {
        axis.step();
    }
    return axis;
}

void floor_of_all(benchmark::State& state) {
    Floor floor;
    measure(state, [&floor] {
        floor.step();
        benchmark::DoNotOptimize(floor);
    });
}
BENCHMARK(floor_of_all);

void axis_moving(benchmark::State& state) {
    Axis axis = standing_axis();
    double target = 100'000;
    measure(state, [&axis, &target] {
        if (!axis.moving()) {
            axis.move_to(target, limits());
            target = 100'000 - target;
        }
        axis.step();
        benchmark::DoNotOptimize(axis);
    });
}
BENCHMARK(axis_moving);

void axis_standing(benchmark::State& state) {
    Axis axis = standing_axis();
    measure(state, [&axis] {
        axis.step();
        benchmark::DoNotOptimize(axis);
    });
}
BENCHMARK(axis_standing);

void axis_pressing(benchmark::State& state) {
    Axis axis = standing_axis();
    axis.plant().set_obstacle(Obstacle{61'000, 50'000, false});
    axis.settings().force_limit = 2;
    axis.settings().cogging_compensation = true;
    axis.move_to(10'000, limits());
    measure(state, [&axis] {
        axis.step();
        benchmark::DoNotOptimize(axis);
    });
}
BENCHMARK(axis_pressing);

void profile_at(benchmark::State& state) {
    const Profile profile = Profile::to_position(0, 100'000, limits());
    std::int64_t period = 0;
    const auto periods = static_cast<std::int64_t>(profile.duration() / control_period_s);
    measure(state, [&profile, &period, periods] {
        benchmark::DoNotOptimize(profile.at(static_cast<double>(period) * control_period_s));
        period = period < periods ? period + 1 : 0;
    });
}
BENCHMARK(profile_at);

}  // namespace
}  // namespace servobus::drive
