// Interval statistics against the same figures computed exactly, and at the edges of sequence numbers.
#include "scanner/interval_statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace servobus::scanner {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

enip::Time at(nanoseconds since) { return enip::Time(since); }

/// The quantile of sorted values, by its definition.
nanoseconds exact(const std::vector<nanoseconds>& sorted, double share) {
    const auto rank =
        std::max<std::size_t>(static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size()))), 1);
    return sorted[rank - 1];
}

TEST(DurationHistogram, AgreesWithExactQuantiles) {
    std::mt19937_64 random(20261126);
    // From 2 ns to 20 s, as many in each decade.
    std::uniform_real_distribution<double> exponent(0.3, 10.3);
    DurationHistogram histogram;
    std::vector<nanoseconds> values;
    for (int i = 0; i < 50'000; ++i) {
        values.emplace_back(std::llround(std::pow(10.0, exponent(random))));
        histogram.add(values.back());
    }
    std::ranges::sort(values);
    for (const double share : {0.0, 0.001, 0.1, 0.25, 0.5, 0.9, 0.99, 0.999, 1.0}) {
        const auto wanted = exact(values, share);
        const auto found = histogram.quantile(share);
        EXPECT_GE(found, wanted) << share;
        EXPECT_LE(found.count(), wanted.count() + wanted.count() / 1024) << share;
    }
    EXPECT_EQ(histogram.max(), values.back());
    EXPECT_EQ(histogram.count(), values.size());
}

TEST(DurationHistogram, IsExactWhereItIsSmall) {
    for (const auto value : {0ns, 1ns, 1023ns, 1024ns, 2047ns}) {
        DurationHistogram histogram;
        histogram.add(value);
        histogram.add(1h);
        EXPECT_EQ(histogram.quantile(0.5), value);
    }
    // At 1 ms it is still better than 1 us.
    DurationHistogram histogram;
    histogram.add(1ms);
    histogram.add(1h);
    EXPECT_GE(histogram.quantile(0.5), 1ms);
    EXPECT_LT(histogram.quantile(0.5), 1ms + 1us);
}

TEST(DurationHistogram, HoldsTheLongestAndNothingLonger) {
    DurationHistogram histogram;
    histogram.add(DurationHistogram::longest);
    EXPECT_EQ(histogram.quantile(1), DurationHistogram::longest);
    histogram.add(DurationHistogram::longest + 1ns);
    histogram.add(-5ns);
    EXPECT_EQ(histogram.max(), DurationHistogram::longest);
    EXPECT_EQ(histogram.quantile(0), 0ns);
    EXPECT_EQ(histogram.count(), 3U);
    histogram.clear();
    EXPECT_EQ(histogram.count(), 0U);
    EXPECT_EQ(histogram.quantile(0.5), 0ns);
}

TEST(IntervalStatistics, AgreesWithExactFigures) {
    std::mt19937_64 random(4);
    std::normal_distribution<double> jitter(0, 20'000);
    IntervalStatistics statistics(1ms);
    std::vector<nanoseconds> intervals;
    std::vector<nanoseconds> errors;
    nanoseconds time = 5s;
    nanoseconds before{};
    for (std::uint32_t i = 0; i < 10'000; ++i) {
        const auto arrival = time + nanoseconds(std::llround(jitter(random)));
        statistics.take(i, at(arrival));
        if (i > 0) {
            intervals.push_back(arrival - before);
            errors.push_back(std::chrono::abs(arrival - before - 1ms));
        }
        before = arrival;
        time += 1ms;
    }
    std::ranges::sort(intervals);
    std::ranges::sort(errors);
    const auto near = [](nanoseconds found, nanoseconds wanted) {
        return found >= wanted && found.count() <= wanted.count() + wanted.count() / 1024;
    };
    EXPECT_TRUE(near(statistics.intervals().p50, exact(intervals, 0.5)));
    EXPECT_TRUE(near(statistics.intervals().p99, exact(intervals, 0.99)));
    EXPECT_TRUE(near(statistics.intervals().p999, exact(intervals, 0.999)));
    EXPECT_EQ(statistics.intervals().max, intervals.back());
    EXPECT_TRUE(near(statistics.errors().p50, exact(errors, 0.5)));
    EXPECT_TRUE(near(statistics.errors().p99, exact(errors, 0.99)));
    EXPECT_TRUE(near(statistics.errors().p999, exact(errors, 0.999)));
    EXPECT_EQ(statistics.errors().max, errors.back());
    EXPECT_EQ(statistics.interval_count(), 9'999U);
    EXPECT_EQ(statistics.counters().packets, 10'000U);
    EXPECT_EQ(statistics.counters().lost, 0U);
    // The jitter of the two ends over 10 s.
    EXPECT_LT(std::abs(*statistics.drift_ppm()), 20.0);
}

TEST(IntervalStatistics, DriftDoesNotComeFromLosses) {
    // 40 ppm slow, and every seventh datagram is lost.
    IntervalStatistics statistics(10ms);
    for (std::uint32_t i = 0; i < 7'000; ++i) {
        if (i % 7 == 3) continue;
        statistics.take(i, at(i * nanoseconds(10'000'400)));
    }
    EXPECT_NEAR(*statistics.drift_ppm(), 40, 1e-6);
    EXPECT_NEAR(*statistics.mean_interval_ns(), 10'000'400, 1e-3);
    EXPECT_EQ(statistics.counters().lost, 1'000U);
    EXPECT_EQ(statistics.counters().late, 0U);
    EXPECT_EQ(statistics.counters().packets, 6'000U);
    // A loss makes no interval, but it is a silence.
    EXPECT_EQ(statistics.intervals().max, 10'000'400ns);
    EXPECT_EQ(statistics.longest_silence(), 20'000'800ns);
}

TEST(IntervalStatistics, LateIsOneAndAHalfIntervals) {
    IntervalStatistics statistics(10ms);
    statistics.take(1, at(0ms));
    statistics.take(2, at(15ms));
    EXPECT_EQ(statistics.counters().late, 0U);
    statistics.take(3, at(30ms + 1ns));
    EXPECT_EQ(statistics.counters().late, 1U);
    EXPECT_EQ(statistics.errors().max, 5ms + 1ns);
}

TEST(IntervalStatistics, TellsCopiesFromLatecomers) {
    IntervalStatistics statistics(10ms);
    statistics.take(10, at(0ms));
    statistics.take(10, at(1ms));
    EXPECT_EQ(statistics.counters().duplicated, 1U);
    statistics.take(13, at(30ms));
    EXPECT_EQ(statistics.counters().lost, 2U);
    statistics.take(11, at(31ms));
    EXPECT_EQ(statistics.counters().lost, 1U);
    EXPECT_EQ(statistics.counters().reordered, 1U);
    statistics.take(11, at(32ms));
    statistics.take(9, at(33ms));
    EXPECT_EQ(statistics.counters().duplicated, 3U) << "nobody waited for what came before the first";
    EXPECT_EQ(statistics.counters().packets, 3U);
    EXPECT_EQ(statistics.counters().lost, 1U);
}

TEST(IntervalStatistics, RemembersSoFarAndNoFurther) {
    IntervalStatistics statistics(10ms);
    statistics.take(0, at(0ms));
    statistics.take(IntervalStatistics::remembered + 1, at(650ms));
    statistics.take(2, at(651ms));
    EXPECT_EQ(statistics.counters().reordered, 1U);
    statistics.take(1, at(652ms));
    EXPECT_EQ(statistics.counters().reordered, 1U);
    EXPECT_EQ(statistics.counters().duplicated, 1U);
}

TEST(IntervalStatistics, NumbersWrapAround) {
    IntervalStatistics statistics(10ms);
    statistics.take(0xFFFFFFFF, at(0ms));
    statistics.take(0, at(10ms));
    statistics.take(0xFFFFFFFF, at(11ms));
    statistics.take(1, at(20ms));
    EXPECT_EQ(statistics.counters().packets, 3U);
    EXPECT_EQ(statistics.counters().lost, 0U);
    EXPECT_EQ(statistics.counters().duplicated, 1U);
    EXPECT_NEAR(*statistics.drift_ppm(), 0, 1e-9);
}

TEST(IntervalStatistics, ARestartIsNoInterval) {
    IntervalStatistics statistics(10ms);
    EXPECT_EQ(statistics.drift_ppm(), std::nullopt);
    statistics.take(5, at(0ms));
    EXPECT_EQ(statistics.drift_ppm(), std::nullopt);
    statistics.take(6, at(10ms));
    statistics.restart(20ms);
    statistics.take(900, at(5s));
    statistics.take(901, at(5s + 20ms));
    EXPECT_EQ(statistics.counters().lost, 0U);
    EXPECT_EQ(statistics.counters().packets, 4U);
    EXPECT_EQ(statistics.longest_silence(), 20ms);
    EXPECT_NEAR(*statistics.drift_ppm(), 0, 1e-9);
    EXPECT_EQ(statistics.granted(), 20ms);
}

}  // namespace
}  // namespace servobus::scanner
