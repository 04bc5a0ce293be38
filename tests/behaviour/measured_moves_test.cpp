// What a real drive of this family told about itself while it moved: logs of its status messages and of TPSR.
#include <gtest/gtest.h>

#include <vector>

#include "tests/support/drive_bench.hpp"

namespace servobus {
namespace {

using namespace std::chrono_literals;
using test::DriveBench;
namespace psr = test::psr;

/// Seconds from the message that the axis moves to the message that it stands. Where the log has several of a kind,
/// these are the shortest and the longest.
struct Measured {
    std::int64_t way;
    std::int64_t speed;
    std::int64_t acceleration;
    double shortest;
    double longest;
};

const std::vector<Measured> moves{
    {4'000, 20'000, 400'000, 0.254, 0.254},     {39'000, 20'000, 400'000, 2.006, 2.006},
    {4'000, 40'000, 800'000, 0.153, 0.159},     {39'000, 40'000, 800'000, 1.033, 1.035},
    {4'000, 80'000, 1'600'000, 0.105, 0.110},   {4'000, 160'000, 3'200'000, 0.079, 0.080},
    {39'000, 160'000, 3'200'000, 0.299, 0.300}, {4'000, 320'000, 6'400'000, 0.059, 0.060},
};

double seconds(drive::Time time) { return std::chrono::duration<double>(time).count(); }

TEST(MeasuredMoves, TakeTheTimeOfARealDrive) {
    constexpr double tolerance = 0.006;
    DriveBench drive;
    drive.refer();
    drive.go(60'000);
    drive.enter_mode(1);
    for (const auto& move : moves) {
        SCOPED_TRACE(std::to_string(move.way) + " at " + std::to_string(move.speed));
        drive.set("SpeedJogOrProfilePositionMode", move.speed);
        drive.set("AccelerationJogOrProfilePositionMode", move.acceleration);
        for (const std::int64_t way : {move.way, -move.way}) {
            // By command, as in the log: TS 2, then TS 1.
            drive.set("GoImmediately", static_cast<std::int64_t>(60'000 + (way > 0 ? way : 0)));
            auto begin = drive.now();
            EXPECT_TRUE(drive.runs_until([&] { return drive.get("TellStatus") != 2; }, 5s));
            EXPECT_GT(seconds(drive.now() - begin), move.shortest - tolerance);
            EXPECT_LT(seconds(drive.now() - begin), move.longest + tolerance);
            drive.run(200ms);
        }
        for (const std::int64_t way : {move.way, -move.way}) {
            // By control word, up to target reached.
            drive.set("Controlword", 0x06);
            drive.power_on();
            drive.set("TargetPositionOrDistance", way);
            drive.set("Controlword", 0x5F);
            const auto begin = drive.now();
            EXPECT_TRUE(drive.runs_until([&] { return drive.reached(); }, 5s));
            EXPECT_GT(seconds(drive.now() - begin), move.shortest - tolerance);
            EXPECT_LT(seconds(drive.now() - begin), move.longest + tolerance);
            drive.run(200ms);
        }
    }
}

/// The values of TPSR one after the other, each once.
std::vector<std::uint32_t> history(DriveBench& drive, std::chrono::milliseconds time) {
    std::vector<std::uint32_t> seen{drive.tpsr()};
    for (auto left = time; left > 0ms; left -= 1ms) {
        drive.run(1ms);
        if (drive.tpsr() != seen.back()) seen.push_back(drive.tpsr());
    }
    return seen;
}

TEST(MeasuredStatus, OfAReferenceUnderPower) {
    DriveBench drive;
    drive.refer();
    drive.command("REF");
    drive.run(1ms);
    const std::vector<std::uint32_t> real{0x0200'0154, 0x0200'0158, 0x0200'015A};
    EXPECT_EQ(history(drive, 2s), real);
}

TEST(MeasuredStatus, OfAMove) {
    DriveBench drive;
    drive.refer();
    drive.set("GoImmediately", 100'000);
    drive.run(1ms);
    // In motion and in position at once while it settles inside the window.
    const std::vector<std::uint32_t> real{0x0200'0156, 0x0200'015E, 0x0200'015A};
    auto seen = history(drive, 2s);
    if (seen.front() == 0x0200'015E) seen.erase(seen.begin());
    EXPECT_EQ(seen, real);
}

}  // namespace
}  // namespace servobus
