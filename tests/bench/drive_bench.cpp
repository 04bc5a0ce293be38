// What one drive costs: `step` at the control period of 100 us (004 §5.3), with everything that it tells.
#include <benchmark/benchmark.h>

#include "drive/xenax.hpp"
#include "tests/bench/floor.hpp"

namespace servobus::drive {
namespace {

void write(Device& device, Key key, std::int64_t value) { (void)device.write(*device.find(key), value); }

constexpr Key control_word{0x66, 0x00};
constexpr Key status_word{0x66, 0x01};
constexpr Key mode{0x66, 0x20};
constexpr Key target{0x66, 0x3A};
constexpr Key speed{0x66, 0x41};

/// Referenced, in profile position mode, under power.
struct ReadyDrive {
    Device device{xenax_models().front(), Machine{}};
    Time now{0};

    ReadyDrive() {
        device.step(now);
        write(device, mode, 6);
        for (const int word : {0x06, 0x07, 0x0F, 0x1F}) write(device, control_word, word);
        while ((std::get<std::int64_t>(device.store().value(*device.find(status_word))) & 1 << 12) == 0) step();
        write(device, mode, 1);
        write(device, control_word, 0x0F);
    }
    void step() {
        now += control_period;
        device.step(now);
    }
};

void drive_moving(benchmark::State& state) {
    ReadyDrive drive;
    write(drive.device, speed, 20'000);
    std::int64_t end = 200'000;
    std::int64_t periods = 0;
    measure(state, [&] {
        // The way lasts 7 s: there and back for as long as it takes.
        if (periods-- == 0) {
            periods = 75'000;
            end = end == 200'000 ? 60'000 : 200'000;
            write(drive.device, control_word, 0x0F);
            write(drive.device, target, end);
            write(drive.device, control_word, 0x1F);
        }
        drive.step();
    });
}
BENCHMARK(drive_moving);

void drive_standing(benchmark::State& state) {
    ReadyDrive drive;
    measure(state, [&] { drive.step(); });
}
BENCHMARK(drive_standing);

/// A hundred drives that move, one period of each: what a core has 100 us for.
void hundred_drives_moving(benchmark::State& state) {
    std::vector<std::unique_ptr<ReadyDrive>> drives;
    for (int i = 0; i < 100; ++i) drives.push_back(std::make_unique<ReadyDrive>());
    for (auto& drive : drives) {
        write(drive->device, speed, 10);
        write(drive->device, target, 200'000);
        write(drive->device, control_word, 0x1F);
    }
    measure(state, [&] {
        for (auto& drive : drives) drive->step();
    });
    state.counters["of_real_time"] = benchmark::Counter(static_cast<double>(state.iterations()) * control_period_s,
                                                        benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(hundred_drives_moving);

}  // namespace
}  // namespace servobus::drive
