#include "drive/force_monitor.hpp"

#include <algorithm>
#include <bit>

namespace servobus::drive {
namespace {

/// Farther than any position, and no sum of two of them overflows.
constexpr std::int64_t infinity = std::int64_t{1} << 61;

constexpr unsigned all_sectors = (1U << force_sectors) - 1;

constexpr unsigned bit(SectorBorder border) { return 1U << static_cast<unsigned>(border); }
constexpr unsigned sides = bit(SectorBorder::start_side) | bit(SectorBorder::end_side);

constexpr unsigned entries(std::uint16_t transitions) { return (transitions >> 12U) & 0xFU; }
constexpr unsigned exits(std::uint16_t transitions) { return (transitions >> 4U) & 0xFU; }

/// The border towards which a curve moves.
constexpr SectorBorder side_ahead(bool forward) { return forward ? SectorBorder::end_side : SectorBorder::start_side; }
constexpr SectorBorder force_border_ahead(bool rises) {
    return rises ? SectorBorder::high_force : SectorBorder::low_force;
}

/// A part of the line between two points, from 0 to 1. Empty when it ends before it begins.
struct Part {
    double begin = 0;
    double end = 1;
};

/// The part of the way from `a` to `b` that lies between `low` and `high`. Equal ratios give equal bits, so corners
/// compare exactly.
Part part_between(std::int64_t a, std::int64_t b, std::int64_t low, std::int64_t high) {
    if (a == b) return low <= a && a <= high ? Part{0, 1} : Part{1, 0};
    const auto length = static_cast<double>(b - a);
    const double to_low = static_cast<double>(low - a) / length;
    const double to_high = static_cast<double>(high - a) / length;
    return {std::max(0.0, length > 0 ? to_low : to_high), std::min(1.0, length > 0 ? to_high : to_low)};
}

struct OutsideBand {
    bool below = false;
    bool above = false;
};

/// Whether the force from `a` to `b` is somewhere below `low` or above `high` while the position is between the sides.
OutsideBand outside_band(const Part& sideways, const Part& upright, std::int64_t a, std::int64_t b, std::int64_t low,
                         std::int64_t high) {
    if (a == b) return {.below = a < low, .above = high < a};
    const bool before = sideways.begin < upright.begin;
    const bool after = sideways.end > upright.end;
    return a < b ? OutsideBand{before, after} : OutsideBand{after, before};
}

}  // namespace

ForceMonitor::Line::Line(Point from_point, Point to_point)
    : from(from_point),
      to(to_point),
      left(std::min(from.position, to.position)),
      right(std::max(from.position, to.position)),
      lower(std::min(from.force, to.force)),
      upper(std::max(from.force, to.force)) {}

void ForceMonitor::Range::note(std::int64_t force) {
    if (force > most) most = force;
    if (force < least) least = force;
}

void ForceMonitor::configure(const ForceMonitorSettings& settings) {
    settings_ = settings;
    for (std::size_t i = 0; i < force_sectors; ++i) {
        const ForceSector& sector = settings.sectors[i];
        const auto [left, right] = std::minmax(sector.start, sector.end);
        areas_[i] = {left + settings.offset, right + settings.offset, sector.low, sector.high,
                     sector.start > sector.end};
        if (left == right) {
            areas_[i].left = -infinity;
            areas_[i].right = infinity;
        }
    }
}

bool ForceMonitor::in_sector(std::int64_t position) const {
    for (std::size_t i = 0; i < force_sectors; ++i) {
        if ((settings_.selected >> i & 1U) != 0 && covers(areas_[i], position)) return true;
    }
    return false;
}

void ForceMonitor::start() {
    tracks_ = {};
    range_ = {};
    failed_ = 0;
    passed_ = false;
    empty_ = true;
    running_ = true;
}

void ForceMonitor::sample(std::int64_t position, std::int64_t force) {
    if (!running_) return;
    const Line line(empty_ ? Point{position, force} : last_, {position, force});
    leftmost_ = empty_ ? position : std::min(leftmost_, position);
    rightmost_ = empty_ ? position : std::max(rightmost_, position);
    for (unsigned left = settings_.selected & all_sectors; left != 0; left &= left - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(left));
        note_line(areas_[i], tracks_[i], line);
    }
    range_.note(force);
    last_ = line.to;
    empty_ = false;
}

void ForceMonitor::finish() {
    if (!running_) return;
    running_ = false;
    const unsigned selected = settings_.selected & all_sectors;
    unsigned failed = 0;
    for (std::size_t i = 0; i < force_sectors; ++i) {
        if ((selected >> i & 1U) != 0 && !passes(i)) failed |= 1U << i;
    }
    failed_ = static_cast<std::uint16_t>(failed);
    passed_ = selected != 0 && failed == 0;
}

bool ForceMonitor::covers(const Area& area, std::int64_t position) {
    return area.left <= position && position <= area.right;
}

bool ForceMonitor::contains(const Area& area, Point point) {
    return covers(area, point.position) && area.low <= point.force && point.force <= area.high;
}

void ForceMonitor::note_line(const Area& area, Track& track, const Line& line) {
    if (line.right < area.left || line.left > area.right) return;
    if (covers(area, line.to.position)) track.range.note(line.to.force);
    // Most lines meet no border of the rectangle.
    if (line.lower > area.high) {
        track.above = true;
    } else if (line.upper < area.low) {
        track.below = true;
    } else if (line.left < area.left || line.right > area.right || line.lower < area.low || line.upper > area.high) {
        note_crossings(area, track, line.from, line.to);
    }
}

void ForceMonitor::note_crossings(const Area& area, Track& track, Point from, Point to) {
    const Part sideways = part_between(from.position, to.position, area.left, area.right);
    const Part upright = part_between(from.force, to.force, area.low, area.high);
    const auto [below, above] = outside_band(sideways, upright, from.force, to.force, area.low, area.high);
    track.below |= below;
    track.above |= above;
    if (std::max(sideways.begin, upright.begin) > std::min(sideways.end, upright.end)) return;

    const bool forward = (to.position > from.position) != area.mirrored;
    const bool rises = to.force > from.force;
    // At a corner the side counts.
    if (!contains(area, from) && !track.entered) {
        const bool over_side = sideways.begin >= upright.begin;
        track.first_entry = over_side ? side_ahead(!forward) : force_border_ahead(!rises);
        track.entered = true;
    }
    if (!contains(area, to)) {
        const bool over_side = sideways.end <= upright.end;
        track.last_exit = over_side ? side_ahead(forward) : force_border_ahead(rises);
        track.left = true;
    }
}

bool ForceMonitor::crossed_whole_width(std::size_t sector) const {
    const ForceSector& set = settings_.sectors[sector];
    const Area& area = areas_[sector];
    return set.start == set.end || (leftmost_ <= area.left && area.right <= rightmost_);
}

bool ForceMonitor::passes(std::size_t sector) const {
    if (empty_) return false;
    const Track& track = tracks_[sector];
    const unsigned entry = entries(settings_.sectors[sector].transitions);
    const unsigned exit = exits(settings_.sectors[sector].transitions);
    const unsigned named = entry | exit;

    if (track.below && (named & bit(SectorBorder::low_force)) == 0) return false;
    if (track.above && (named & bit(SectorBorder::high_force)) == 0) return false;
    if (entry != 0 && !track.entered) return false;
    if (track.entered && (bit(track.first_entry) & (entry != 0 ? entry : sides)) == 0) return false;
    if (exit != 0 && (!track.left || contains(areas_[sector], last_))) return false;
    if (track.left && (bit(track.last_exit) & (exit != 0 ? exit : sides)) == 0) return false;
    return named != 0 || crossed_whole_width(sector);
}

}  // namespace servobus::drive
