#include "scanner/interval_statistics.hpp"

#include <algorithm>

namespace servobus::scanner {

void IntervalStatistics::take(std::uint32_t sequence, enip::Time time) {
    if (!begun_) {
        begun_ = true;
        last_ = sequence;
        last_time_ = time;
        // What was sent before the first one that came has not been lost.
        seen_ = ~std::uint64_t{0};
        ++counters_.packets;
        return;
    }
    // The number wraps around, so it is the nearer way that counts (R-IO-4).
    const auto ahead = sequence - last_;
    if (ahead != 0 && ahead < 0x80000000U) {
        take_next(ahead, time);
    } else {
        take_old(last_ - sequence);
    }
}

void IntervalStatistics::take_next(std::uint32_t ahead, enip::Time time) {
    const auto passed = std::chrono::duration_cast<Duration>(time - last_time_);
    ++counters_.packets;
    counters_.lost += ahead - 1;
    longest_silence_ = std::max(longest_silence_, passed);
    if (ahead == 1) {
        intervals_.add(passed);
        errors_.add(passed > granted_ ? passed - granted_ : granted_ - passed);
        if (static_cast<double>(passed.count()) > late_after * static_cast<double>(granted_.count())) {
            ++counters_.late;
        }
    }
    steps_ += ahead;
    time_ns_ += static_cast<double>(passed.count());
    granted_ns_ += static_cast<double>(granted_.count()) * ahead;
    seen_ = ahead < remembered ? (seen_ << ahead) | 1U : 1U;
    last_ += ahead;
    last_time_ = time;
}

void IntervalStatistics::take_old(std::uint32_t behind) {
    if (behind >= remembered || (seen_ >> behind & 1U) != 0) {
        ++counters_.duplicated;
        return;
    }
    seen_ |= std::uint64_t{1} << behind;
    ++counters_.packets;
    ++counters_.reordered;
    --counters_.lost;
}

void IntervalStatistics::restart(Duration granted) {
    granted_ = granted;
    begun_ = false;
}

std::optional<double> IntervalStatistics::mean_interval_ns() const {
    if (steps_ == 0) return std::nullopt;
    return time_ns_ / steps_;
}

std::optional<double> IntervalStatistics::drift_ppm() const {
    if (granted_ns_ == 0) return std::nullopt;
    return (time_ns_ / granted_ns_ - 1) * 1e6;
}

IntervalStatistics::Distribution IntervalStatistics::distribution_of(const DurationHistogram& histogram) {
    return {histogram.quantile(0.5), histogram.quantile(0.99), histogram.quantile(0.999), histogram.max()};
}

}  // namespace servobus::scanner
