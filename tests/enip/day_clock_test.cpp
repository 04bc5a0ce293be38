// How far the clock of the day is ahead: with clocks that go as the test wants it.
#include "enip/asio/day_clock.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <vector>

namespace servobus::enip::asio {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

/// Both clocks of a machine: each reading takes a while.
struct Machine {
    nanoseconds steady{1h};
    nanoseconds ahead{1'700'000'000s};
    int readings = 0;                 ///< of the clock of the day
    std::vector<nanoseconds> delays;  ///< between the readings of a comparison, the next one first; then 100 ns

    void pass() {
        nanoseconds delay = 100ns;
        if (!delays.empty()) {
            delay = delays.front();
            delays.erase(delays.begin());
        }
        steady += delay;
    }
};

Machine* machine = nullptr;

class DayClockTest : public testing::Test {
protected:
    DayClockTest() { machine = &machine_; }
    ~DayClockTest() override { machine = nullptr; }

    nanoseconds ask() { return clock_.ahead(Time(machine_.steady)); }

    Machine machine_;
    DayClock clock_{{.steady = [] { return Time(machine->steady); },
                     .day =
                         [] {
                             machine->pass();
                             ++machine->readings;
                             const auto day = machine->steady + machine->ahead;
                             machine->pass();
                             return day;
                         }}};
};

TEST_F(DayClockTest, TellsHowFarTheOtherClockIsAhead) { EXPECT_EQ(ask(), 1'700'000'000s); }

TEST_F(DayClockTest, ComparesAgainAfterItsInterval) {
    const auto first = machine_.steady;
    (void)ask();
    machine_.ahead += 5s;  // somebody sets the clock
    machine_.steady = first + 10ms - 1ns;
    EXPECT_EQ(ask(), 1'700'000'000s);
    EXPECT_EQ(machine_.readings, 1);
    machine_.steady = first + 10ms;
    EXPECT_EQ(ask(), 1'700'000'005s);
    machine_.ahead -= 1h;
    machine_.steady += 1h;
    EXPECT_EQ(ask(), 1'700'000'005s - 1h) << "back, too";
    EXPECT_EQ(machine_.readings, 3);
}

TEST_F(DayClockTest, TakesTheNarrowestOfItsReadings) {
    machine_.delays = {3ms, 1ns, 100ns, 9us, 1ns, 2us, 5ms, 5ms};
    EXPECT_EQ(ask(), 1'700'000'000s + (1ns - 2us) / 2) << "its middle is that far from the reading of the day";
    EXPECT_EQ(machine_.readings, 4) << "it does not try for ever";
}

TEST_F(DayClockTest, IsContentWithAGoodReading) {
    machine_.delays = {3ms, 3ms, 1us, 1us, 0ns, 0ns};
    EXPECT_EQ(ask(), 1'700'000'000s);
    EXPECT_EQ(machine_.readings, 2);
}

TEST(DayClock, IsThatOfThisMachine) {
    DayClock clock;
    const auto before = std::chrono::system_clock::now();
    const auto now = std::chrono::steady_clock::now();
    const auto told = now.time_since_epoch() + clock.ahead(now);
    const auto after = std::chrono::system_clock::now();
    EXPECT_GE(told, before.time_since_epoch() - 1ms);
    EXPECT_LE(told, after.time_since_epoch() + 1ms);
}

}  // namespace
}  // namespace servobus::enip::asio
