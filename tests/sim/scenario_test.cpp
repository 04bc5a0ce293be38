#include "tests/sim/scenario.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace servobus::sim {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

TEST(Scenario, FollowsFromItsSeed) {
    EXPECT_EQ(draw(7, 60s), draw(7, 60s));
    EXPECT_NE(draw(7, 60s), draw(8, 60s));
}

TEST(Scenario, ComesBackFromItsText) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        const auto scenario = draw(seed, 60s);
        std::string mistake;
        const auto back = from_json(to_json(scenario), mistake);
        ASSERT_TRUE(back) << seed << ": " << mistake;
        EXPECT_EQ(*back, scenario) << seed;
    }
}

// What the tests of all seeds cover: every kind of action and of connection comes up.
TEST(Scenario, DrawsEverythingThereIs) {
    std::set<Action::Kind> kinds;
    std::set<std::pair<unsigned, unsigned>> points;
    bool multicast = false;
    bool change_of_state = false;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        const auto scenario = draw(seed, 20s);
        for (const auto& action : scenario.actions) kinds.insert(action.kind);
        for (const auto& connection : scenario.connections) {
            points.emplace(connection.o_to_t_point, connection.t_to_o_point);
            multicast = multicast || connection.multicast;
            change_of_state = change_of_state || connection.trigger != 0;
        }
    }
    EXPECT_EQ(kinds.size(), static_cast<std::size_t>(Action::Kind::forge) + 1);
    EXPECT_EQ(points.size(), 11U);
    EXPECT_TRUE(multicast);
    EXPECT_TRUE(change_of_state);
}

TEST(Scenario, ActionsStandInTheOrderOfTheirTimes) {
    const auto scenario = draw(3, 60s);
    EXPECT_TRUE(std::ranges::is_sorted(scenario.actions, {}, &Action::at));
    EXPECT_GT(scenario.actions.size(), 5U);
}

std::string mistake_in(const std::string& text) {
    std::string mistake;
    EXPECT_FALSE(from_json(text, mistake));
    return mistake;
}

TEST(Scenario, TellsWhyATextIsNone) {
    const std::string head =
        R"({"seed": 1, "length": 1000, "nodes": 1, "drives": [{"jog": false}], "connections": [], "clients": [], )";
    std::string none;
    EXPECT_TRUE(from_json(head + R"("actions": []})", none)) << none;
    EXPECT_THAT(mistake_in("{"), HasSubstr("parse error"));
    EXPECT_THAT(mistake_in("{}"), HasSubstr("seed"));
    EXPECT_THAT(mistake_in(head + R"("actions": [{"at": 0, "do": "dance", "subject": 0}]})"),
                HasSubstr("unknown word 'dance'"));
    EXPECT_THAT(mistake_in(head + R"("actions": [{"at": 0, "do": "open", "subject": 0}]})"), HasSubstr("names nobody"));
    EXPECT_THAT(mistake_in(head + R"("actions": [{"at": 0, "do": "cut", "subject": 0, "other": 1}]})"),
                HasSubstr("names nobody"));
}

}  // namespace
}  // namespace servobus::sim
