// How often each length of time has occurred, in bounded memory: runs of days cost what a minute costs.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace servobus::scanner {

/// Log-linear, as HdrHistogram is: exact to the nanosecond below 2 us, and above that to one part in 1024, which is
/// less than 1 us up to 1 ms.
class DurationHistogram {
public:
    using Duration = std::chrono::nanoseconds;

    /// What is longer counts as this: 36 minutes, more than the longest timeout of a connection (R-CON-6).
    static constexpr Duration longest{(std::int64_t{1} << 41) - 1};
    /// Cells for that; they are there only as far as they are used.
    static constexpr std::size_t max_cells = std::size_t{32} * 1024;

    /// What is negative counts as 0.
    void add(Duration duration);
    void clear();

    [[nodiscard]] std::uint64_t count() const { return count_; }
    /// Exact, up to `longest`.
    [[nodiscard]] Duration max() const { return max_; }
    /// The smallest length that at least this share (0 to 1) of all does not exceed, rounded up to the end of its cell
    /// but never beyond max(). 0 when there are none.
    [[nodiscard]] Duration quantile(double share) const;

private:
    std::vector<std::uint64_t> cells_;
    std::uint64_t count_ = 0;
    Duration max_{0};
};

}  // namespace servobus::scanner
