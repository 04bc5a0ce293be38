#include "drive/position_capture.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace servobus::drive {
namespace {

/// One edge at each position.
void edges(PositionCapture& capture, const std::vector<std::int64_t>& positions) {
    for (const std::int64_t position : positions) {
        capture.sample(false, -1);
        capture.sample(true, position);
    }
}

std::vector<std::int64_t> captured(const PositionCapture& capture) {
    std::vector<std::int64_t> all;
    for (std::size_t place = 1; place <= PositionCapture::places; ++place) all.push_back(capture.captured(place));
    return all;
}

std::vector<std::int64_t> buffered(const PositionCapture& capture) {
    std::vector<std::int64_t> all;
    for (std::size_t place = 1; place <= PositionCapture::places; ++place) all.push_back(capture.buffered(place));
    return all;
}

TEST(PositionCapture, OffAtFirst) {
    PositionCapture capture;
    EXPECT_FALSE(capture.enabled());
    edges(capture, {100, 200});
    EXPECT_EQ(capture.count(), 0U);
    EXPECT_EQ(captured(capture), std::vector<std::int64_t>(8));
    EXPECT_EQ(buffered(capture), std::vector<std::int64_t>(8));
}

TEST(PositionCapture, StoresAtRisingEdgesOnly) {
    PositionCapture capture;
    capture.enable(true);
    capture.sample(false, 1);
    capture.sample(true, 2);
    capture.sample(true, 3);
    capture.sample(false, 4);
    capture.sample(true, 5);
    EXPECT_EQ(capture.count(), 2U);
    EXPECT_EQ(capture.captured(1), 2);
    EXPECT_EQ(capture.captured(2), 5);
    EXPECT_EQ(capture.buffered(1), 5);
    EXPECT_EQ(capture.buffered(2), 2);
}

TEST(PositionCapture, AnInputThatIsActiveAlreadyHasNoEdge) {
    PositionCapture capture;
    capture.sample(true, 1);
    capture.enable(true);
    capture.sample(true, 2);
    EXPECT_EQ(capture.count(), 0U);
    capture.sample(false, 3);
    capture.sample(true, 4);
    EXPECT_EQ(capture.captured(1), 4);
}

TEST(PositionCapture, FirstEightStayLastEightMove) {
    PositionCapture capture;
    capture.enable(true);
    edges(capture, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
    EXPECT_EQ(captured(capture), (std::vector<std::int64_t>{1, 2, 3, 4, 5, 6, 7, 8}));
    EXPECT_EQ(buffered(capture), (std::vector<std::int64_t>{10, 9, 8, 7, 6, 5, 4, 3}));
    EXPECT_EQ(capture.count(), 10U);
}

TEST(PositionCapture, ClearEmptiesBothAndStaysOn) {
    PositionCapture capture;
    capture.enable(true);
    edges(capture, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
    capture.clear();
    EXPECT_EQ(captured(capture), std::vector<std::int64_t>(8));
    EXPECT_EQ(buffered(capture), std::vector<std::int64_t>(8));
    edges(capture, {11});
    EXPECT_EQ(capture.captured(1), 11);
    EXPECT_EQ(capture.buffered(1), 11);
    EXPECT_EQ(capture.buffered(2), 0);
}

TEST(PositionCapture, SwitchingOffKeepsWhatIsCaptured) {
    PositionCapture capture;
    capture.enable(true);
    edges(capture, {7});
    capture.enable(false);
    edges(capture, {8});
    EXPECT_EQ(capture.captured(1), 7);
    EXPECT_EQ(capture.count(), 1U);
}

TEST(PositionCapture, AnInputFunctionCapturesWithoutTheInput) {
    PositionCapture capture;
    capture.capture(-5);
    EXPECT_EQ(capture.captured(1), -5);
}

TEST(PositionCapture, OtherPlacesAreEmpty) {
    PositionCapture capture;
    for (int i = 0; i < 20; ++i) capture.capture(1);
    for (const std::size_t place : {std::size_t{0}, std::size_t{9}, ~std::size_t{0}}) {
        EXPECT_EQ(capture.captured(place), 0);
        EXPECT_EQ(capture.buffered(place), 0);
    }
}

TEST(PositionCapture, KeepsEndsOfAnyList) {
    std::mt19937 random(1);
    for (int run = 0; run < 1000; ++run) {
        PositionCapture capture;
        std::vector<std::int64_t> all;
        for (auto count = random() % 40; count > 0; --count) {
            all.push_back(static_cast<std::int64_t>(random()) - 0x80000000);
            capture.capture(all.back());
        }
        for (std::size_t place = 1; place <= PositionCapture::places; ++place) {
            const bool there = place <= all.size();
            ASSERT_EQ(capture.captured(place), there ? all[place - 1] : 0);
            ASSERT_EQ(capture.buffered(place), there ? all[all.size() - place] : 0);
        }
    }
}

}  // namespace
}  // namespace servobus::drive
