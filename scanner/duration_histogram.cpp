#include "scanner/duration_histogram.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace servobus::scanner {
namespace {

/// Cells in each doubling of the length; below twice as many nanoseconds each has a cell of its own.
constexpr unsigned doubling_bits = 10;
constexpr std::uint64_t cells_per_doubling = std::uint64_t{1} << doubling_bits;

/// How far a length is shifted so that it keeps eleven bits.
unsigned shift_of(std::uint64_t ns) {
    const auto width = static_cast<unsigned>(std::bit_width(ns));
    return width > doubling_bits + 1 ? width - doubling_bits - 1 : 0;
}

std::size_t cell_of(std::uint64_t ns) {
    const auto shift = shift_of(ns);
    return static_cast<std::size_t>(shift * cells_per_doubling + (ns >> shift));
}

/// The longest that falls into a cell.
std::uint64_t end_of(std::size_t cell) {
    const auto shift = cell < 2 * cells_per_doubling ? 0 : cell / cells_per_doubling - 1;
    return ((cell - shift * cells_per_doubling + 1) << shift) - 1;
}

static_assert(DurationHistogram::max_cells == (41 - doubling_bits + 1) * cells_per_doubling);

}  // namespace

void DurationHistogram::add(Duration duration) {
    duration = std::clamp(duration, Duration(0), longest);
    const auto cell = cell_of(static_cast<std::uint64_t>(duration.count()));
    if (cell >= cells_.size()) cells_.resize(cell + 1);
    ++cells_[cell];
    ++count_;
    max_ = std::max(max_, duration);
}

void DurationHistogram::clear() {
    std::ranges::fill(cells_, 0);
    count_ = 0;
    max_ = Duration(0);
}

DurationHistogram::Duration DurationHistogram::quantile(double share) const {
    const auto wanted = std::clamp<std::uint64_t>(
        static_cast<std::uint64_t>(std::ceil(std::clamp(share, 0.0, 1.0) * static_cast<double>(count_))), 1, count_);
    std::uint64_t seen = 0;
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
        seen += cells_[cell];
        if (count_ > 0 && seen >= wanted) return std::min(Duration(static_cast<std::int64_t>(end_of(cell))), max_);
    }
    return Duration(0);
}

}  // namespace servobus::scanner
