#include "drive/position_trigger.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace servobus::drive {
namespace {

/// In which periods it fires.
std::vector<bool> fired(PositionTrigger& trigger, const std::vector<std::int64_t>& positions) {
    std::vector<bool> all;
    for (const std::int64_t position : positions) all.push_back(trigger.step(position));
    return all;
}

TEST(PositionTrigger, UnsetItNeverFires) {
    PositionTrigger trigger;
    EXPECT_EQ(fired(trigger, {-10, 10, -10}), (std::vector{false, false, false}));
    EXPECT_FALSE(trigger.active());
}

struct Case {
    bool upward;
    std::vector<std::int64_t> positions;
    std::vector<bool> fires;
};

TEST(PositionTrigger, FiresWhenThePositionIsPassedInItsDirection) {
    for (const auto& [upward, positions, fires] : {
             Case{true, {0, 99, 101, 150}, {false, false, true, false}},
             Case{true, {0, 100, 101}, {false, true, false}},
             Case{true, {100, 150}, {false, false}},  // leaving is not passing
             Case{true, {150, 50}, {false, false}},
             Case{true, {0, 1000, 0, 1000}, {false, true, false, true}},
             Case{true, {99, 100, 99, 100}, {false, true, false, true}},
             Case{true, {200}, {false}},  // the first position is not a motion
             Case{false, {150, 101, 99, 0}, {false, false, true, false}},
             Case{false, {150, 100, 99}, {false, true, false}},
             Case{false, {100, 50}, {false, false}},
             Case{false, {50, 150}, {false, false}},
         }) {
        PositionTrigger trigger;
        upward ? trigger.set_upward(100) : trigger.set_downward(100);
        EXPECT_EQ(fired(trigger, positions), fires) << upward << " " << positions[0] << " " << positions.back();
    }
}

TEST(PositionTrigger, BothDirectionsHaveTheirOwnPosition) {
    PositionTrigger trigger;
    trigger.set_upward(100);
    trigger.set_downward(50);
    EXPECT_EQ(fired(trigger, {0, 75, 150, 75, 25}), (std::vector{false, false, true, false, true}));
    trigger.set_upward(20);
    EXPECT_EQ(fired(trigger, {0, 30}), (std::vector{false, true})) << "the new position replaces the old one";
}

TEST(PositionTrigger, PulseLastsItsPeriods) {
    PositionTrigger trigger;
    trigger.set_upward(10);
    trigger.step(0);
    ASSERT_TRUE(trigger.step(20));
    std::int64_t periods = 0;
    for (; trigger.active(); ++periods) trigger.step(20);
    EXPECT_EQ(periods, PositionTrigger::pulse_periods);
}

TEST(PositionTrigger, FiringAgainBeginsThePulseAnew) {
    PositionTrigger trigger;
    trigger.set_upward(10);
    trigger.step(0);
    trigger.step(20);
    trigger.rest(PositionTrigger::pulse_periods - 1);
    EXPECT_TRUE(trigger.active());
    trigger.rest(0);
    trigger.forget_position();
    trigger.step(0);
    EXPECT_FALSE(trigger.active());
    trigger.step(20);
    trigger.rest(PositionTrigger::pulse_periods - 1);
    EXPECT_TRUE(trigger.active());
    trigger.rest(1'000'000'000'000);
    EXPECT_FALSE(trigger.active());
}

TEST(PositionTrigger, AJumpOfTheCounterIsNoMotion) {
    PositionTrigger trigger;
    trigger.set_upward(100);
    trigger.step(0);
    trigger.forget_position();
    EXPECT_FALSE(trigger.step(1000));
    EXPECT_FALSE(trigger.step(0));
    EXPECT_TRUE(trigger.step(1000));
}

TEST(PositionTrigger, ClearForgetsPositionsAndPulse) {
    PositionTrigger trigger;
    trigger.set_upward(100);
    trigger.step(0);
    trigger.step(200);
    trigger.clear();
    EXPECT_FALSE(trigger.active());
    EXPECT_EQ(fired(trigger, {0, 200}), (std::vector{false, false}));
}

TEST(PositionTrigger, FiresAsOftenAsAWalkPasses) {
    std::mt19937 random(1);
    for (int run = 0; run < 1000; ++run) {
        PositionTrigger trigger;
        trigger.set_upward(0);
        trigger.set_downward(0);
        // Above and below alternate, so passings upward and downward do too.
        bool above = random() % 2 == 0;
        trigger.step(above ? 5 : -5);
        for (int i = 0; i < 50; ++i) {
            const bool next = random() % 2 == 0;
            const auto distance = static_cast<std::int64_t>(1 + random() % 10);
            ASSERT_EQ(trigger.step(next ? distance : -distance), next != above);
            above = next;
        }
    }
}

}  // namespace
}  // namespace servobus::drive
