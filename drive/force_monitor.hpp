// Force monitoring (004 §6.1.3, §6.2.3): up to ten rectangles in the diagram of force over way, and whether the curve
// of a motion passed through those that are selected.
//
// Positions are increments. Forces are whatever unit the caller uses for limits and samples alike: 10 mA of I_Force
// with FTM 0, mN with FTM 1 and 2.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace servobus::drive {

/// The four borders of a sector, numbered as in STCX. The manuals here print no numbering: this one is chosen.
enum class SectorBorder : std::uint8_t { start_side = 0, end_side = 1, low_force = 2, high_force = 3 };

/// A rectangle. `start` and `end` are relative to the sector offset and come in either order; a sector without extent
/// (start == end) covers every position, as the drive's own default does.
///
/// `transitions` (STCX): bits 12 to 15 name the borders through which the curve may enter, bits 4 to 7 those through
/// which it may leave, in the order of SectorBorder. The sector passes when
/// - the first entry was through a named border. None named: the curve need not enter, but if, then from a side;
/// - the last exit was through a named border, and the curve ended outside. None named: it need not leave, but if,
///   then to a side;
/// - nowhere between start and end the force was below `low` (above `high`), unless that border is named for one of
///   the two: then it is how the curve comes or goes;
/// - with nothing named at all: the curve went over the whole width, from start to end or back.
struct ForceSector {
    std::int64_t start = 0;         ///< SIFS, SFS
    std::int64_t end = 0;           ///< SIFE, SFE
    std::int64_t low = 0;           ///< IFL, FL
    std::int64_t high = 0;          ///< IFH, FH
    std::uint16_t transitions = 0;  ///< STCX
};

inline constexpr std::size_t force_sectors = 10;

struct ForceMonitorSettings {
    std::array<ForceSector, force_sectors> sectors{};
    std::uint16_t selected = 1;  ///< SSEC, sector 1 in the lowest bit
    std::int64_t offset = 0;     ///< SSO
};

class ForceMonitor {
public:
    ForceMonitor() { configure({}); }

    /// At any time; a curve that is being watched meets the new sectors from its next sample on (TPSO on the way).
    void configure(const ForceMonitorSettings& settings);
    [[nodiscard]] const ForceMonitorSettings& settings() const { return settings_; }

    /// PSR 6: a selected sector covers this position.
    [[nodiscard]] bool in_sector(std::int64_t position) const;

    /// Begins a new curve and forgets the old result (command 0x6000, or the start of a motion).
    void start();
    /// The next point of the curve; between two points the curve is straight. Nothing unless running.
    void sample(std::int64_t position, std::int64_t force);
    /// Evaluates the curve (command 0x6001, or the end of a motion). Nothing unless running.
    void finish();
    [[nodiscard]] bool running() const { return running_; }

    /// PSR 7, after finish(): at least one sector is selected and all that are passed.
    [[nodiscard]] bool passed() const { return passed_; }
    /// SIFF, SFF, after finish(): the selected sectors that failed, sector 1 in the lowest bit. Otherwise 0.
    [[nodiscard]] std::uint16_t failed() const { return failed_; }
    /// IFPK, FPK: the sample farthest from 0 of the curve that runs or ran last, with its sign (positive when both are
    /// equally far); 0 without samples.
    [[nodiscard]] std::int64_t peak() const { return range_.peak(); }
    /// IFPKn, FPKn: the same between start and end of a selected sector, 0 to 9.
    [[nodiscard]] std::int64_t peak(std::size_t sector) const { return tracks_[sector].range.peak(); }

private:
    struct Point {
        std::int64_t position = 0;
        std::int64_t force = 0;
    };
    /// Two points of the curve and the box around them.
    struct Line {
        Line(Point from_point, Point to_point);

        Point from;
        Point to;
        std::int64_t left;
        std::int64_t right;
        std::int64_t lower;
        std::int64_t upper;
    };
    /// A sector in absolute positions, left to right.
    struct Area {
        std::int64_t left = 0;
        std::int64_t right = 0;
        std::int64_t low = 0;
        std::int64_t high = 0;
        bool mirrored = false;  ///< the end side is the left one
    };
    /// The forces seen, with 0 among them.
    struct Range {
        std::int64_t least = 0;
        std::int64_t most = 0;

        void note(std::int64_t force);
        [[nodiscard]] std::int64_t peak() const { return -least > most ? least : most; }
    };
    /// What the curve did in one sector so far.
    struct Track {
        Range range;
        bool entered = false;  ///< through a border: beginning inside is no entry
        bool left = false;
        bool below = false;  ///< it was under `low` between start and end
        bool above = false;
        SectorBorder first_entry{};
        SectorBorder last_exit{};
    };

    [[nodiscard]] static bool covers(const Area& area, std::int64_t position);
    [[nodiscard]] static bool contains(const Area& area, Point point);
    static void note_line(const Area& area, Track& track, const Line& line);
    static void note_crossings(const Area& area, Track& track, Point from, Point to);
    [[nodiscard]] bool crossed_whole_width(std::size_t sector) const;
    [[nodiscard]] bool passes(std::size_t sector) const;

    ForceMonitorSettings settings_;
    std::array<Area, force_sectors> areas_{};
    std::array<Track, force_sectors> tracks_{};
    bool running_ = false;
    bool passed_ = false;
    bool empty_ = true;  ///< no sample yet
    std::uint16_t failed_ = 0;
    Point last_;
    std::int64_t leftmost_ = 0;
    std::int64_t rightmost_ = 0;
    Range range_;
};

}  // namespace servobus::drive
