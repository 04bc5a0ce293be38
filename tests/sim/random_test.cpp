#include "tests/sim/random.hpp"

#include <gtest/gtest.h>

namespace servobus::sim {
namespace {

// The published values of SplitMix64: the same seed has to mean the same on every machine.
TEST(Random, IsSplitMix64) {
    Random random(1234567);
    for (const std::uint64_t value : {6457827717110365317U, 3203168211198807973U, 9817491932198370423U,
                                      4593380528125082431U, 16408922859458223821U}) {
        EXPECT_EQ(random.next(), value);
    }
}

TEST(Random, KeepsToItsBorders) {
    Random random(1);
    bool low = false;
    bool high = false;
    int hits = 0;
    for (int i = 0; i < 10'000; ++i) {
        const auto value = random.between(-2, 3);
        ASSERT_GE(value, -2);
        ASSERT_LE(value, 3);
        low = low || value == -2;
        high = high || value == 3;
        const auto unit = random.unit();
        ASSERT_GE(unit, 0);
        ASSERT_LT(unit, 1);
        hits += random.chance(0.25) ? 1 : 0;
    }
    EXPECT_TRUE(low && high);
    EXPECT_NEAR(hits, 2'500, 200);
    EXPECT_FALSE(random.chance(0));
    EXPECT_TRUE(random.chance(1));
}

TEST(Random, StreamsHaveNothingInCommon) {
    Random one(1, 1);
    Random two(1, 2);
    Random other(2, 1);
    const auto first = one.next();
    EXPECT_NE(first, two.next());
    EXPECT_NE(first, other.next());
    EXPECT_EQ(first, Random(1, 1).next());
}

}  // namespace
}  // namespace servobus::sim
