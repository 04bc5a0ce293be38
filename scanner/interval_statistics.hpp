// How steadily datagrams come, against the interval that was granted.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "enip/time.hpp"
#include "scanner/duration_histogram.hpp"

namespace servobus::scanner {

/// One stream of datagrams, by their sequence numbers (of the encapsulation) and the times at which they came.
class IntervalStatistics {
public:
    using Duration = std::chrono::nanoseconds;

    /// A datagram is late when it comes later than this many intervals after the one with the number before it.
    static constexpr double late_after = 1.5;
    /// As many numbers back a datagram can be told from a second copy of one that has come.
    static constexpr std::uint32_t remembered = 64;

    struct Counters {
        std::uint64_t packets = 0;     ///< that came, but for the second copies
        std::uint64_t lost = 0;        ///< numbers that were left out, and did not come after all
        std::uint64_t late = 0;        ///< after their predecessor; what follows a loss is not late
        std::uint64_t duplicated = 0;  ///< second copies, and numbers from before all that is remembered
        std::uint64_t reordered = 0;   ///< came after a higher number; part of `packets`
    };
    struct Distribution {
        Duration p50{}, p99{}, p999{}, max{};
    };

    explicit IntervalStatistics(Duration granted) : granted_(granted) {}

    void take(std::uint32_t sequence, enip::Time time);
    /// The stream begins anew, with another first number, as after a re-open: the gap is no interval. What was granted
    /// may have changed.
    void restart(Duration granted);

    [[nodiscard]] const Counters& counters() const { return counters_; }
    [[nodiscard]] Duration granted() const { return granted_; }
    /// Between datagrams whose numbers follow each other; a loss makes no interval.
    [[nodiscard]] Distribution intervals() const { return distribution_of(intervals_); }
    /// |interval - granted|.
    [[nodiscard]] Distribution errors() const { return distribution_of(errors_); }
    [[nodiscard]] std::uint64_t interval_count() const { return intervals_.count(); }
    /// The longest time without a datagram, lost ones included.
    [[nodiscard]] Duration longest_silence() const { return longest_silence_; }

    /// Time from first to last datagram, by how far the numbers went on meanwhile: a loss does not count, and the jitter
    /// only at both ends. Nullopt before the second datagram.
    [[nodiscard]] std::optional<double> mean_interval_ns() const;
    /// How much slower (+) than granted, in parts per million.
    [[nodiscard]] std::optional<double> drift_ppm() const;

private:
    [[nodiscard]] static Distribution distribution_of(const DurationHistogram& histogram);
    void take_next(std::uint32_t ahead, enip::Time time);
    void take_old(std::uint32_t behind);

    Duration granted_;
    Counters counters_{};
    DurationHistogram intervals_;
    DurationHistogram errors_;
    Duration longest_silence_{0};

    bool begun_ = false;
    std::uint32_t last_ = 0;
    enip::Time last_time_{};
    std::uint64_t seen_ = 0;  ///< bit n: the number `last_ - n` has come
    double steps_ = 0;        ///< how far the numbers went on
    double time_ns_ = 0;      ///< while this time passed
    double granted_ns_ = 0;   ///< and this was granted for it
};

}  // namespace servobus::scanner
