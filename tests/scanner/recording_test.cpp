// Tables and pictures of a motion, and times as people type them.
#include "scanner/cli/recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "scanner/cli/chart.hpp"
#include "scanner/cli/duration.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(Recording, IsATableWithUnits) {
    EXPECT_EQ(csv({{0.0005, 0x0637, 1000, -5, 120, 3}, {0.0025, 0x1237, -1, 0, 0, -3}}),
              "time [s],position [increment],velocity [increment/s],current [mA],following error [increment],status "
              "word\n"
              "0.000500,1000,-5,120,3,0x0637\n"
              "0.002500,-1,0,0,-3,0x1237\n");
}

/// A ramp up to 1,000 increments/s in a second, looked at every 5 ms.
Samples ramp() {
    Samples samples;
    for (int i = 0; i <= 400; ++i) {
        const double time = i * 0.005;
        samples.push_back({time, 0, i, static_cast<std::int64_t>(std::lround(std::min(time, 1.0) * 1000)), 0, 0});
    }
    return samples;
}

TEST(Recording, FindsTheAcceleration) {
    const auto values = accelerations(ramp());
    ASSERT_EQ(values.size(), 401U);
    EXPECT_NEAR(values[100], 1000, 1);
    EXPECT_NEAR(values[300], 0, 1);
    EXPECT_TRUE(accelerations({}).empty());
    EXPECT_THAT(accelerations({{}}), ElementsAre(0));
    EXPECT_THAT(accelerations({{}, {}}), ElementsAre(0, 0)) << "no time has passed";
}

/// Every element is closed in its order, and nothing but attributes stands in a tag.
void expect_well_formed(const std::string& text) {
    std::vector<std::string> open;
    for (auto at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
        const auto end = text.find('>', at);
        ASSERT_NE(end, std::string::npos);
        const auto tag = text.substr(at + 1, end - at - 1);
        EXPECT_EQ(std::ranges::count(tag, '"') % 2, 0) << tag;
        const auto name = tag.substr(0, tag.find(' '));
        if (name.starts_with('/')) {
            ASSERT_FALSE(open.empty());
            EXPECT_EQ(open.back(), name.substr(1));
            open.pop_back();
        } else if (!tag.ends_with('/')) {
            open.push_back(name);
        }
    }
    EXPECT_TRUE(open.empty());
}

TEST(Recording, IsAPicture) {
    for (const auto& samples : {Samples{}, Samples{{}}, ramp()}) {
        const auto text = picture(samples, "a < b & c");
        expect_well_formed(text);
        EXPECT_THAT(text, HasSubstr("a &lt; b &amp; c"));
        for (const auto* label : {"position [increment]", "velocity [increment/s]", "acceleration [increment/s²]",
                                  "current [mA]", "following error [increment]", "time [s]"}) {
            EXPECT_THAT(text, HasSubstr(label));
        }
        EXPECT_EQ(text.find("nan"), std::string::npos);
        EXPECT_EQ(text.find("inf"), std::string::npos);
    }
}

TEST(Chart, DrawsALineWithItsNumbers) {
    Chart chart;
    chart.x_label = "x";
    chart.x = {0, 1, 2};
    chart.panels = {{"y", "m", {0, 1000, 0}}};
    const auto text = svg(chart);
    EXPECT_THAT(text, HasSubstr(R"(points="120.00,180.93 525.00,63.07 930.00,180.93")"));
    EXPECT_THAT(text, HasSubstr(">1 000<"));
    EXPECT_THAT(text, HasSubstr(">1.4<"));
}

TEST(Chart, KeepsThePeaksOfALongRecording) {
    Chart chart;
    for (int i = 0; i < 100'000; ++i) chart.x.push_back(i);
    chart.panels = {{"y", "m", std::vector<double>(chart.x.size())}};
    chart.panels[0].y[77'777] = 5;
    const auto text = svg(chart);
    EXPECT_LT(text.size(), 100'000U);
    EXPECT_THAT(text, HasSubstr(" 750.00,63.07 "));
}

TEST(Chart, TakesRoundNumbers) {
    EXPECT_THAT(ticks(0, 10, 5), ElementsAre(0, 2, 4, 6, 8, 10));
    EXPECT_THAT(ticks(-1300, 260, 4), ElementsAre(-1000, -500, 0));
    EXPECT_THAT(ticks(0.101, 0.149, 5), ElementsAre(testing::DoubleEq(0.11), testing::DoubleEq(0.12),
                                                    testing::DoubleEq(0.13), testing::DoubleEq(0.14)));
}

TEST(Duration, ReadsUnits) {
    EXPECT_EQ(*parse_duration("2s"), 2s);
    EXPECT_EQ(*parse_duration("500ms"), 500ms);
    EXPECT_EQ(*parse_duration("0.5s"), 500ms);
    EXPECT_EQ(*parse_duration("3"), 3s);
    EXPECT_EQ(*parse_duration("250us"), 250us);
    EXPECT_EQ(*parse_duration("2min"), 2min);
    for (const auto* wrong : {"", "s", "2h", "-1s", "0s", "nan", "inf", "1e9s", "2 s", "2ss"}) {
        EXPECT_FALSE(parse_duration(wrong)) << wrong;
    }
}

}  // namespace
}  // namespace servobus::scanner::cli
