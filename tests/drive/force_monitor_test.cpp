#include "drive/force_monitor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace servobus::drive {
namespace {

using Curve = std::vector<std::pair<std::int64_t, std::int64_t>>;

constexpr std::uint16_t enter(SectorBorder border) {
    return static_cast<std::uint16_t>(0x1000U << static_cast<unsigned>(border));
}
constexpr std::uint16_t leave(SectorBorder border) {
    return static_cast<std::uint16_t>(0x10U << static_cast<unsigned>(border));
}

constexpr auto start_side = SectorBorder::start_side;
constexpr auto end_side = SectorBorder::end_side;
constexpr auto low_force = SectorBorder::low_force;
constexpr auto high_force = SectorBorder::high_force;

constexpr std::uint16_t both(std::uint16_t a, std::uint16_t b) { return static_cast<std::uint16_t>(a | b); }

/// From 1000 to 2000, from 10 to 20.
constexpr ForceSector box(std::uint16_t transitions = 0) { return {1000, 2000, 10, 20, transitions}; }

ForceMonitorSettings only(const ForceSector& sector) {
    ForceMonitorSettings settings;
    settings.sectors[0] = sector;
    return settings;
}

ForceMonitor after(const ForceMonitorSettings& settings, const Curve& curve) {
    ForceMonitor monitor;
    monitor.configure(settings);
    monitor.start();
    for (const auto& [position, force] : curve) monitor.sample(position, force);
    monitor.finish();
    return monitor;
}

Curve reversed(Curve curve) {
    std::ranges::reverse(curve);
    return curve;
}

TEST(ForceMonitor, MasksAreThoseOfTheManual) {
    // The maker's example: entry transition 1 and exit transition 2 are 0x1020, 4128.
    EXPECT_EQ(both(enter(start_side), leave(end_side)), 0x1020);
}

struct Case {
    std::string name;
    ForceSector sector;
    Curve curve;
    bool passes;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class ForceCurve : public testing::TestWithParam<Case> {};

TEST_P(ForceCurve, IsJudged) {
    const Case& c = GetParam();
    const ForceMonitor monitor = after(only(c.sector), c.curve);
    EXPECT_EQ(monitor.passed(), c.passes);
    EXPECT_EQ(monitor.failed(), c.passes ? 0 : 1);
}

const Case cases[] = {
    {"AcrossInBand", box(), {{0, 15}, {3000, 15}}, true},
    {"AcrossBackwards", box(), {{3000, 15}, {0, 15}}, true},
    {"FromBorderToBorder", box(), {{1000, 10}, {2000, 20}}, true},
    {"AboveInTheMiddle", box(), {{0, 15}, {1500, 21}, {3000, 15}}, false},
    {"BelowInTheMiddle", box(), {{0, 15}, {1500, 9}, {3000, 15}}, false},
    {"AboveOnlyOutside", box(), {{0, 100}, {900, 15}, {2100, 15}, {3000, 100}}, true},
    {"OutsideTheBandBetweenTwoSamples", box(), {{0, 0}, {3000, 15}}, false},
    {"EndsInside", box(), {{0, 15}, {1999, 15}}, false},
    {"BeginsInside", box(), {{1001, 15}, {3000, 15}}, false},
    {"TurnsInside", box(), {{0, 15}, {1500, 15}, {0, 15}}, false},
    {"NeverReached", box(), {{0, 15}, {999, 15}}, false},
    {"NoSample", box(), {}, false},
    {"StandsInside", box(), {{1500, 15}}, false},
    {"UnusedBitsNameNothing", box(0x0F0F), {{0, 15}, {3000, 15}}, true},
    {"LimitsExchanged", {1000, 2000, 20, 10, 0}, {{0, 15}, {3000, 15}}, false},

    {"StartToEnd", box(0x1020), {{0, 15}, {3000, 15}}, true},
    {"EndToStartIsTheWrongWay", box(0x1020), {{3000, 15}, {0, 15}}, false},
    {"StartToEndButEndsInside", box(0x1020), {{0, 15}, {1500, 15}}, false},
    {"StartToEndButEndsOnTheBorder", box(0x1020), {{0, 15}, {2000, 15}}, false},
    {"StartToEndButOutThroughTheTop", box(0x1020), {{0, 15}, {1500, 15}, {1600, 30}, {3000, 30}}, false},
    {"StartToEndWithAnExcursion", box(0x1020), {{0, 15}, {1400, 15}, {1500, 21}, {1600, 15}, {3000, 15}}, false},
    {"StartToEndWithTrembleAtTheBorder", box(0x1020), {{0, 15}, {1001, 15}, {999, 15}, {1001, 15}, {3000, 15}}, true},
    {"BeginningInsideIsNoEntry", box(0x1020), {{1500, 15}, {3000, 15}}, false},
    {"SectorFromRightToLeft", {2000, 1000, 10, 20, 0x1020}, {{3000, 15}, {0, 15}}, true},
    {"SectorFromRightToLeftTheWrongWay", {2000, 1000, 10, 20, 0x1020}, {{0, 15}, {3000, 15}}, false},

    {"EntryAlone", box(enter(start_side)), {{0, 15}, {1500, 15}}, true},
    {"EntryAloneMayLeaveByASide", box(enter(start_side)), {{0, 15}, {3000, 15}}, true},
    {"EntryAloneMustStayInBand", box(enter(start_side)), {{0, 15}, {1500, 21}}, false},
    {"EntryMissing", box(enter(start_side)), {{0, 15}, {999, 15}}, false},
    {"EntryThroughTheOtherSide", box(enter(start_side)), {{3000, 15}, {1500, 15}}, false},
    {"ExitAlone", box(leave(end_side)), {{1500, 15}, {3000, 15}}, true},
    {"ExitMissing", box(leave(end_side)), {{0, 15}, {1500, 15}}, false},

    {"RisesThroughTheFloor",
     box(both(enter(low_force), leave(end_side))),
     {{0, 0}, {1500, 0}, {1600, 15}, {3000, 15}},
     true},
    {"RisesTooLate", box(both(enter(low_force), leave(end_side))), {{0, 0}, {2500, 0}, {3000, 15}}, false},
    {"ComesFromTheSideInsteadOfTheFloor", box(both(enter(low_force), leave(end_side))), {{0, 15}, {3000, 15}}, false},
    {"TremblesAtTheFloor",
     box(both(enter(low_force), leave(end_side))),
     {{0, 0}, {1500, 11}, {1510, 9}, {1520, 11}, {1600, 15}, {3000, 15}},
     true},
    {"FloorIsNamedTheTopIsNot",
     box(both(enter(low_force), leave(end_side))),
     {{0, 0}, {1500, 0}, {1600, 25}, {1700, 15}, {3000, 15}},
     false},
    {"FallsThroughTheFloor",
     box(both(enter(start_side), leave(low_force))),
     {{0, 15}, {1500, 15}, {1600, 0}, {3000, 0}},
     true},
    {"ShootsThroughTheTop", box(both(enter(low_force), leave(high_force))), {{1500, 0}, {1500, 30}}, true},
    {"ShootsThroughTheTopDownwards", box(both(enter(high_force), leave(low_force))), {{1500, 30}, {1500, 0}}, true},
    {"OneOfTwoNamedEntries",
     box(both(both(enter(start_side), enter(low_force)), leave(end_side))),
     {{0, 15}, {3000, 15}},
     true},
    {"TheOtherOfTwoNamedEntries",
     box(both(both(enter(start_side), enter(low_force)), leave(end_side))),
     {{0, 0}, {1500, 0}, {1600, 15}, {3000, 15}},
     true},
    {"ACornerIsASide", box(0x1020), {{0, 0}, {1000, 10}, {2000, 20}, {3000, 30}}, true},
    {"ThroughTheSectorBetweenTwoSamples", box(0x1020), {{0, 15}, {1'000'000, 15}}, true},

    {"WithoutExtentEveryPositionCounts", {0, 0, 10, 20, 0}, {{-5, 15}, {-5, 15}}, true},
    {"WithoutExtentAboveFails", {0, 0, 10, 20, 0}, {{-5, 15}, {70, 21}}, false},
    {"WithoutExtentHasNoSides", {0, 0, 10, 20, 0x1020}, {{-5, 15}, {70, 15}}, false},
    {"WithoutExtentHasForceBorders",
     {0, 0, 10, 20, both(enter(low_force), leave(low_force))},
     {{0, 0}, {5, 15}, {10, 0}},
     true},
    {"WithoutExtentNoSample", {0, 0, 10, 20, 0}, {}, false},
    {"NegativeForces", {1000, 2000, -20, -10, 0x1020}, {{0, -15}, {3000, -15}}, true},
};

INSTANTIATE_TEST_SUITE_P(ForceMonitor, ForceCurve, testing::ValuesIn(cases),
                         [](const auto& each) { return each.param.name; });

TEST(ForceMonitor, TheDefaultCoversEveryPositionAndPassesOnlyWithoutForce) {
    ForceMonitor monitor;
    EXPECT_TRUE(monitor.in_sector(0));
    EXPECT_TRUE(monitor.in_sector(39'000));
    EXPECT_FALSE(monitor.passed());
    EXPECT_TRUE(after({}, {{0, 0}, {8000, 0}}).passed());
    EXPECT_FALSE(after({}, {{0, 0}, {8000, 1}}).passed());
}

TEST(ForceMonitor, InSectorMeansASelectedOne) {
    ForceMonitorSettings settings = only(box());
    settings.sectors[3] = {-50, -100, 0, 0, 0};
    settings.selected = 0b1001;
    ForceMonitor monitor;
    monitor.configure(settings);
    for (const std::int64_t inside : {1000, 2000, -100, -50}) EXPECT_TRUE(monitor.in_sector(inside)) << inside;
    for (const std::int64_t outside : {999, 2001, -101, -49, 0}) EXPECT_FALSE(monitor.in_sector(outside)) << outside;
    settings.selected = 0;
    monitor.configure(settings);
    EXPECT_FALSE(monitor.in_sector(1500));
}

TEST(ForceMonitor, OffsetShiftsTheSectors) {
    ForceMonitorSettings settings = only(box());
    settings.offset = -700;
    ForceMonitor monitor = after(settings, {{300, 15}, {1300, 15}});
    EXPECT_TRUE(monitor.passed());
    EXPECT_TRUE(monitor.in_sector(300));
    EXPECT_FALSE(monitor.in_sector(1301));
}

TEST(ForceMonitor, OffsetTakenOnTheWayCountsFromTheNextSample) {
    ForceMonitorSettings settings = only({100, 200, 10, 20, 0x1020});
    ForceMonitor monitor;
    monitor.configure(settings);
    monitor.start();
    monitor.sample(300, 0);
    monitor.sample(5000, 5);
    settings.offset = 5000;  // touched
    monitor.configure(settings);
    monitor.sample(5090, 15);
    monitor.sample(5300, 15);
    monitor.finish();
    EXPECT_TRUE(monitor.passed());
}

TEST(ForceMonitor, NamesTheFailedSectors) {
    ForceMonitorSettings settings;
    settings.selected = 0x3FF;
    for (std::size_t i = 0; i < force_sectors; ++i) {
        const auto start = static_cast<std::int64_t>(1000 * i);
        settings.sectors[i] = {start, start + 500, 0, i % 3 == 0 ? 5 : 50, 0};
    }
    const ForceMonitor monitor = after(settings, {{0, 10}, {7200, 10}});
    // Sectors 1, 4 and 7 allow only 5; 8 is left in its middle, 9 and 10 are never reached.
    EXPECT_EQ(monitor.failed(), 0b11'1100'1001);
    EXPECT_FALSE(monitor.passed());
}

TEST(ForceMonitor, SectorsThatAreNotSelectedDoNotFail) {
    ForceMonitorSettings settings = only(box());
    settings.sectors[1] = {0, 100, 99, 99, 0};
    EXPECT_TRUE(after(settings, {{0, 15}, {3000, 15}}).passed());
    settings.selected = 0b10;
    EXPECT_EQ(after(settings, {{0, 15}, {3000, 15}}).failed(), 0b10);
    settings.selected = 0xFC00;  // there are ten
    EXPECT_EQ(after(settings, {{0, 15}, {3000, 15}}).failed(), 0);
}

TEST(ForceMonitor, NothingSelectedIsNoSuccess) {
    ForceMonitorSettings settings = only(box());
    settings.selected = 0;
    const ForceMonitor monitor = after(settings, {{0, 15}, {3000, 15}});
    EXPECT_FALSE(monitor.passed());
    EXPECT_EQ(monitor.failed(), 0);
}

TEST(ForceMonitor, ResultBelongsToTheLastCurve) {
    ForceMonitor monitor = after(only(box()), {{0, 15}, {3000, 15}});
    monitor.sample(0, 1000);  // not running: nothing
    EXPECT_TRUE(monitor.passed());
    EXPECT_EQ(monitor.peak(), 15);
    monitor.start();
    EXPECT_TRUE(monitor.running());
    EXPECT_FALSE(monitor.passed());
    EXPECT_EQ(monitor.failed(), 0);
    EXPECT_EQ(monitor.peak(), 0);
    monitor.finish();
    EXPECT_FALSE(monitor.running());
    EXPECT_EQ(monitor.failed(), 1);
}

TEST(ForceMonitor, FinishWithoutStartChangesNothing) {
    ForceMonitor monitor = after(only(box()), {{0, 15}, {3000, 15}});
    monitor.finish();
    EXPECT_TRUE(monitor.passed());
}

TEST(ForceMonitor, PeakIsTheSampleFarthestFromZero) {
    ForceMonitorSettings settings = only(box());
    settings.sectors[1] = {2500, 2600, 0, 0, 0};
    settings.sectors[2] = {7000, 7100, 0, 0, 0};
    settings.selected = 0b1111;
    const ForceMonitor monitor = after(settings, {{0, 30}, {1000, -12}, {1500, 11}, {2550, -40}, {3000, 39}});
    EXPECT_EQ(monitor.peak(), -40);
    EXPECT_EQ(monitor.peak(0), -12);
    EXPECT_EQ(monitor.peak(1), -40);
    EXPECT_EQ(monitor.peak(2), 0);
    EXPECT_EQ(monitor.peak(3), -40) << "a sector without extent sees all samples";
    EXPECT_EQ(monitor.peak(4), 0) << "not selected";
    EXPECT_EQ(after(settings, {{0, -7}, {0, 7}}).peak(), 7);
}

TEST(ForceMonitor, ExtremeNumbersAreNumbers) {
    constexpr std::int64_t far = 4'147'483'648;
    const ForceMonitor monitor =
        after(only({-2'000'000'000, 2'000'000'000, -200'000, 200'000, 0x1020}), {{-far, 0}, {far, 2'147'483'647}});
    EXPECT_FALSE(monitor.passed());
    EXPECT_EQ(monitor.peak(), 2'147'483'647);
}

// What the header says, computed the slow way: every single increment of a curve is looked at.
class Oracle {
public:
    Oracle(const ForceSector& sector, const Curve& curve) : sector_(sector) {
        for (const auto& [position, force] : curve) look(position, force);
    }
    [[nodiscard]] bool passes() const {
        const unsigned entry = sector_.transitions >> 12 & 0xF;
        const unsigned exit = sector_.transitions >> 4 & 0xF;
        const unsigned named = entry | exit;
        if ((below_ && (named & 4) == 0) || (above_ && (named & 8) == 0)) return false;
        if (entered_ < 0 ? entry != 0 : ((1U << entered_) & (entry != 0 ? entry : 3)) == 0) return false;
        if (exit != 0 && inside_) return false;
        if (left_ < 0 ? exit != 0 : ((1U << left_) & (exit != 0 ? exit : 3)) == 0) return false;
        return named != 0 || (was_left_ && was_right_);
    }

private:
    void look(std::int64_t position, std::int64_t force) {
        const auto [left, right] = std::minmax(sector_.start, sector_.end);
        const bool covered = left <= position && position <= right;
        const bool inside = covered && sector_.low <= force && force <= sector_.high;
        was_left_ |= position <= left;
        was_right_ |= position >= right;
        below_ |= covered && force < sector_.low;
        above_ |= covered && force > sector_.high;
        if (!first_ && inside && !inside_ && entered_ < 0) entered_ = border(position_, force_);
        if (!first_ && !inside && inside_) left_ = border(position, force);
        first_ = false;
        inside_ = inside;
        position_ = position;
        force_ = force;
    }
    /// The border next to a point outside. Curves move in one direction at a time, so it is only one.
    [[nodiscard]] int border(std::int64_t position, std::int64_t force) const {
        if (position < std::min(sector_.start, sector_.end)) return sector_.start < sector_.end ? 0 : 1;
        if (position > std::max(sector_.start, sector_.end)) return sector_.start < sector_.end ? 1 : 0;
        return force < sector_.low ? 2 : 3;
    }

    ForceSector sector_;
    bool first_ = true;
    bool inside_ = false;
    bool below_ = false;
    bool above_ = false;
    bool was_left_ = false;
    bool was_right_ = false;
    int entered_ = -1;
    int left_ = -1;
    std::int64_t position_ = 0;
    std::int64_t force_ = 0;
};

/// Horizontal and vertical strokes, as corners and as all the points on them.
std::pair<Curve, Curve> random_strokes(std::mt19937& random) {
    const auto pick = [&](int low, int high) { return low + static_cast<int>(random() % unsigned(high - low + 1)); };
    Curve corners{{pick(0, 40), pick(0, 40)}};
    Curve points = corners;
    for (int strokes = pick(0, 8); strokes > 0; --strokes) {
        auto target = corners.back();
        (pick(0, 1) == 0 ? target.first : target.second) = pick(0, 40);
        while (points.back() != target) {
            auto next = points.back();
            next.first += (target.first > next.first) - (target.first < next.first);
            next.second += (target.second > next.second) - (target.second < next.second);
            points.push_back(next);
        }
        corners.push_back(target);
    }
    return {corners, points};
}

/// Often nothing or one border each, sometimes any mask.
std::uint16_t random_mask(std::mt19937& random) {
    if (random() % 4 == 0) return static_cast<std::uint16_t>(random());
    std::uint16_t mask = 0;
    if (random() % 2 == 0) mask = enter(static_cast<SectorBorder>(random() % 4));
    if (random() % 2 == 0) mask = both(mask, leave(static_cast<SectorBorder>(random() % 4)));
    return mask;
}

TEST(ForceMonitor, AgreesWithLookingAtEveryPoint) {
    std::mt19937 random(1);
    int passed = 0;
    for (int run = 0; run < 50'000; ++run) {
        const auto start = static_cast<std::int64_t>(random() % 41);
        const auto end = static_cast<std::int64_t>(random() % 41);
        if (start == end) continue;
        const auto low = static_cast<std::int64_t>(random() % 30);
        const ForceSector sector{start, end, low, low + static_cast<std::int64_t>(random() % 30), random_mask(random)};
        const auto [corners, points] = random_strokes(random);
        const bool expected = Oracle(sector, points).passes();
        passed += expected;
        ASSERT_EQ(after(only(sector), corners).passed(), expected) << "run " << run;
        ASSERT_EQ(after(only(sector), points).passed(), expected) << "run " << run;
    }
    EXPECT_GT(passed, 2000) << "the curves are too wild to tell anything";
}

std::int64_t number(std::mt19937& random, int limit) {
    return static_cast<std::int64_t>(random() % static_cast<unsigned>(2 * limit + 1)) - limit;
}

/// Six points around the sectors of random_sector(), all coordinates even.
Curve random_curve(std::mt19937& random) {
    Curve curve;
    for (int i = 0; i < 6; ++i) curve.push_back({2 * number(random, 1000), 2 * number(random, 50)});
    return curve;
}

ForceSector random_sector(std::mt19937& random) {
    return {number(random, 1000), number(random, 1000), -50, 50, random_mask(random)};
}

TEST(ForceMonitor, MoreSamplesOnTheSameCurveChangeNothing) {
    std::mt19937 random(2);
    int passed = 0;
    for (int run = 0; run < 20'000; ++run) {
        const ForceSector sector = random_sector(random);
        const Curve coarse = random_curve(random);
        Curve fine{coarse.front()};
        for (std::size_t i = 1; i < coarse.size(); ++i) {
            const auto [p, f] = coarse[i - 1];
            const auto [q, g] = coarse[i];
            fine.push_back({(p + q) / 2, (f + g) / 2});
            fine.push_back(coarse[i]);
        }
        const bool expected = after(only(sector), coarse).passed();
        ASSERT_EQ(after(only(sector), fine).passed(), expected) << "run " << run;
        passed += expected;
    }
    EXPECT_GT(passed, 500);
}

TEST(ForceMonitor, AMirroredWorldGivesTheSameResult) {
    std::mt19937 random(3);
    for (int run = 0; run < 20'000; ++run) {
        const ForceSector sector = random_sector(random);
        const ForceSector mirrored{-sector.start, -sector.end, sector.low, sector.high, sector.transitions};
        const Curve curve = random_curve(random);
        Curve mirrored_curve = curve;
        for (auto& point : mirrored_curve) point.first = -point.first;
        const ForceMonitor one = after(only(sector), curve);
        const ForceMonitor other = after(only(mirrored), mirrored_curve);
        ASSERT_EQ(one.passed(), other.passed()) << "run " << run;
        ASSERT_EQ(one.peak(0), other.peak(0)) << "run " << run;
    }
}

TEST(ForceMonitor, ACurveBackwardsPassesWithEntryAndExitExchanged) {
    std::mt19937 random(4);
    for (int run = 0; run < 20'000; ++run) {
        const ForceSector sector = random_sector(random);
        ForceSector exchanged = sector;
        exchanged.transitions = both(static_cast<std::uint16_t>(sector.transitions << 8),
                                     static_cast<std::uint16_t>(sector.transitions >> 8));
        Curve curve = random_curve(random);
        curve.front() = {-5000, 0};
        curve.back() = {run % 2 == 0 ? 5000 : -5000, 0};
        ASSERT_EQ(after(only(sector), curve).passed(), after(only(exchanged), reversed(curve)).passed())
            << "run " << run;
    }
}

}  // namespace
}  // namespace servobus::drive
