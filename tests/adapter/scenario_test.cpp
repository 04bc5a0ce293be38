// Scenario files: what they say, and what is refused with line and column.
#include "adapter/scenario.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "adapter/event_words.hpp"
#include "tests/support/places.hpp"

namespace servobus::adapter {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

/// `line:column: reason`, or "accepted".
std::string problem(const std::string& text) {
    const auto parsed = parse_scenario(text);
    const auto* error = std::get_if<FileError>(&parsed);
    if (error == nullptr) return "accepted";
    return fmt::format("{}:{}: {}", error->line, error->column, error->reason);
}

/// Each entry as `seconds event field=value ...`.
std::vector<std::string> entries(const std::variant<Timetable, FileError>& parsed) {
    const auto* timetable = std::get_if<Timetable>(&parsed);
    if (timetable == nullptr) return {std::get<FileError>(parsed).reason};
    std::vector<std::string> lines;
    for (const auto& [at, event] : timetable->entries) {
        lines.push_back(fmt::format("{} {}", static_cast<double>(at.count()) / 1e6, describe(event)));
    }
    return lines;
}
std::vector<std::string> events(const std::string& list) {
    return entries(parse_scenario("{\"events\": [" + list + "]}"));
}

TEST(Scenario, TakesEveryEventWithEveryField) {
    EXPECT_THAT(events(R"(
        {"at": 0, "event": "put-obstacle", "position": 40000, "stiffness": 12.5, "from_above": true},
        {"at": 1, "event": "remove-obstacle"},
        {"at": 2, "event": "block-axis"},
        {"at": 3, "event": "release-axis"},
        {"at": 4, "event": "set-payload", "mass": 0.5},
        {"at": 5, "event": "push-axis", "force": -7},
        {"at": 6, "event": "set-input", "number": 12, "high": false},
        {"at": 7, "event": "limit-switch", "direction": "positive", "active": false},
        {"at": 8, "event": "emergency-exit", "active": false, "keep_power": true},
        {"at": 9, "event": "safety-stop", "function": "ss2", "active": false},
        {"at": 10, "event": "lose-encoder"},
        {"at": 11, "event": "restore-encoder"},
        {"at": 12, "event": "set-supply", "volts": 24},
        {"at": 13, "event": "cut-supply"},
        {"at": 14, "event": "set-temperature", "celsius": -10},
        {"at": 15, "event": "turn-master", "speed": -2000},
        {"at": 16, "event": "cut-power-stage"},
        {"at": 17, "event": "lose-controller"},
        {"at": 17.5, "event": "power-cycle"})"),
                ElementsAre("0 put-obstacle position=40000 stiffness=12.5 from_above=true", "1 remove-obstacle",
                            "2 block-axis", "3 release-axis", "4 set-payload mass=0.5", "5 push-axis force=-7",
                            "6 set-input number=12 high=false", "7 limit-switch direction=positive active=false",
                            "8 emergency-exit active=false keep_power=true", "9 safety-stop function=ss2 active=false",
                            "10 lose-encoder", "11 restore-encoder", "12 set-supply volts=24", "13 cut-supply",
                            "14 set-temperature celsius=-10", "15 turn-master speed=-2000", "16 cut-power-stage",
                            "17 lose-controller", "17.5 power-cycle"));
}

TEST(Scenario, TakesEveryFaultWithEveryField) {
    EXPECT_THAT(events(R"(
        {"at": 0, "event": "drop-io", "direction": "o_to_t", "share": 0.3, "count": 4, "seconds": 5},
        {"at": 1, "event": "delay-io", "direction": "t_to_o", "milliseconds": 2.5, "jitter": 1},
        {"at": 2, "event": "duplicate-io"},
        {"at": 3, "event": "reorder-io", "count": 1},
        {"at": 4, "event": "cut-cable", "seconds": 0.5},
        {"at": 5, "event": "delay-replies", "milliseconds": 300, "count": 2},
        {"at": 6, "event": "withhold-replies", "seconds": 1},
        {"at": 7, "event": "refuse-open", "general": 1, "extended": "0x0113", "count": 3},
        {"at": 7, "event": "refuse-open", "general": 2, "extended": 0},
        {"at": 8, "event": "close-sessions", "session": "0x12345678"},
        {"at": 9, "event": "freeze", "seconds": 2},
        {"at": 10, "event": "restart"},
        {"at": 11, "event": "restore-network"})"),
                ElementsAre("0 drop-io direction=o_to_t share=0.3 count=4 seconds=5",
                            "1 delay-io direction=t_to_o milliseconds=2.5 jitter=1 share=1 count=0 seconds=0",
                            "2 duplicate-io direction=both share=1 count=0 seconds=0",
                            "3 reorder-io direction=both share=1 count=1 seconds=0", "4 cut-cable seconds=0.5",
                            "5 delay-replies milliseconds=300 count=2 seconds=0",
                            "6 withhold-replies count=0 seconds=1", "7 refuse-open general=0x01 extended=0x113 count=3",
                            "7 refuse-open general=0x02 extended=0x00 count=1", "8 close-sessions session=0x12345678",
                            "9 freeze seconds=2", "10 restart seconds=1", "11 restore-network"));
}

template <class Event>
void every_one_has_a_name() {
    for (std::size_t i = 0; i < std::variant_size_v<Event>; ++i) {
        const auto named = std::ranges::count_if(event_kinds(), [&](const EventKind& kind) {
            const auto* event = std::get_if<Event>(&kind.event);
            return event != nullptr && event->index() == i;
        });
        EXPECT_GT(named, 0) << "event " << i;
    }
}

TEST(Scenario, EveryEventHasAName) {
    every_one_has_a_name<drive::Event>();
    every_one_has_a_name<NetworkFault>();
    for (const auto& kind : event_kinds()) EXPECT_EQ(find_event_kind(kind.name), &kind);
}

TEST(Scenario, WhatIsLeftOutIsTheDefault) {
    EXPECT_THAT(events(R"({"at": 0, "event": "put-obstacle", "position": -1},
                          {"at": 0, "event": "set-input", "number": 1},
                          {"at": 0, "event": "limit-switch", "direction": "negative"},
                          {"at": 0, "event": "emergency-exit"},
                          {"at": 0, "event": "safety-stop"})"),
                ElementsAre("0 put-obstacle position=-1 stiffness=50 from_above=false",
                            "0 set-input number=1 high=true", "0 limit-switch direction=negative active=true",
                            "0 emergency-exit active=true keep_power=false", "0 safety-stop function=sto active=true"));
}

TEST(Scenario, IsOrderedByTimeAndKeepsTheOrderOfOneTime) {
    EXPECT_THAT(events(R"({"at": 2, "event": "block-axis"}, {"at": 1, "event": "cut-supply"},
                          {"at": 2, "event": "release-axis"}, {"at": 0.000001, "event": "power-cycle"})"),
                ElementsAre("1e-06 power-cycle", "1 cut-supply", "2 block-axis", "2 release-axis"));
    EXPECT_TRUE(events("").empty());
}

TEST(Scenario, MayRepeat) {
    const auto parsed = parse_scenario(R"({"repeat_every": 2.5, "events": [{"at": 2.5, "event": "block-axis"}]})");
    ASSERT_TRUE(std::holds_alternative<Timetable>(parsed));
    EXPECT_EQ(std::get<Timetable>(parsed).repeat_every, 2500ms);
    EXPECT_EQ(problem("{\"repeat_every\": 2.4,\n\"events\": [{\"at\": 2.5, \"event\": \"block-axis\"}]}"),
              "1:2: 'repeat_every' must not be less than the time of the last event");
    EXPECT_EQ(problem(R"({"events": [], "repeat_every": 0.1})"), "accepted");
    EXPECT_EQ(problem(R"({"events": [], "repeat_every": 0.09})"),
              "1:16: 'repeat_every' must be a number from 0.1 to 2678400");
}

TEST(Scenario, ErrorsHaveTheirPlace) {
    EXPECT_EQ(problem("{}"), "1:1: 'events' is missing");
    EXPECT_EQ(problem("[]"), "1:1: the file must hold one object in braces");
    EXPECT_EQ(problem("{\"events\": 5}"), "1:2: 'events' must be a list of events in square brackets");
    EXPECT_EQ(problem("{\"events\": [5]}"), "1:2: 'events' holds no event at place 1");
    EXPECT_EQ(problem("{\"events\": [], \"evnts\": 1}"),
              "1:16: 'evnts' is not a setting; here may stand: events, repeat_every");
    EXPECT_EQ(problem("{\"events\": [\n  {\"at\": 1}]}"), "2:3: 'event' is missing");
    EXPECT_EQ(problem("{\"events\": [\n  {\"at\": 1, \"event\": \"block-axis\"},\n  {\"event\": \"block-axis\"}]}"),
              "3:3: 'at' is missing");
    EXPECT_EQ(problem("{\"events\": [\n  {\"at\": 1, \"event\": \"put-obstacle\"}]}"), "2:3: 'position' is missing");
    EXPECT_THAT(problem("{\"events\": [\n  {\"at\": 1, \"event\": \"explode\"}]}"),
                HasSubstr("2:13: 'event' must be one of put-obstacle, remove-obstacle, "));
    EXPECT_EQ(problem("{\"events\": [\n  {\"at\": 1, \"event\": \"block-axis\", \"position\": 1}]}"),
              "2:36: 'position' is not a setting; here may stand: at, event");
    EXPECT_EQ(problem("{\"events\": [{\"at\": 1, \"event\": \"cut-supply\", \"volts\": 1}]}"),
              "1:46: 'volts' is not a setting; here may stand: at, event");
    EXPECT_EQ(problem("{\"events\": [{\"at\": 1, \"at\": 2}]}"), "1:23: 'at' stands here a second time");
    EXPECT_EQ(problem("{\"events\": [[{\"at\": 1}], 2,\n {\"at\": 1, \"at\": 2}]}"),
              "2:12: 'at' stands here a second time");
}

struct Limit {
    const char* event;
    const char* below;  ///< text of the last value that is taken, and of the first that is not
    const char* past;
};
void PrintTo(const Limit& each, std::ostream* out) { *out << each.event; }

class ScenarioLimit : public testing::TestWithParam<Limit> {
protected:
    static std::string with(const char* value) {
        return problem(fmt::format("{{\"events\": [{{{}: {}}}]}}", GetParam().event, value));
    }
};
TEST_P(ScenarioLimit, IsTakenAndOnePastItIsNot) {
    EXPECT_EQ(with(GetParam().below), "accepted");
    EXPECT_THAT(with(GetParam().past), HasSubstr("' must be a "));
}

INSTANTIATE_TEST_SUITE_P(
    All, ScenarioLimit,
    testing::Values(Limit{R"("event": "block-axis", "at")", "0", "-0.1"},
                    Limit{R"("event": "block-axis", "at")", "2678400", "2678400.1"},
                    Limit{R"("event": "block-axis", "at")", "1", "\"1\""},
                    Limit{R"("at": 1, "event": "put-obstacle", "position")", "2147483647", "2147483648"},
                    Limit{R"("at": 1, "event": "put-obstacle", "position")", "-2147483647", "-2147483648"},
                    Limit{R"("at": 1, "event": "put-obstacle", "position")", "1", "1.5"},
                    Limit{R"("at": 1, "event": "put-obstacle", "position")", "1", "18446744073709551615"},
                    Limit{R"("at": 1, "event": "put-obstacle", "position": 1, "stiffness")", "1e6", "1000001"},
                    Limit{R"("at": 1, "event": "set-payload", "mass")", "1e4", "10001"},
                    Limit{R"("at": 1, "event": "set-payload", "mass")", "0", "-1"},
                    Limit{R"("at": 1, "event": "push-axis", "force")", "-1e5", "-100001"},
                    Limit{R"("at": 1, "event": "set-input", "number")", "12", "13"},
                    Limit{R"("at": 1, "event": "set-input", "number")", "1", "0"},
                    Limit{R"("at": 1, "event": "drop-io", "share")", "1", "1.1"},
                    Limit{R"("at": 1, "event": "drop-io", "count")", "1000000", "1000001"},
                    Limit{R"("at": 1, "event": "drop-io", "seconds")", "86400", "86401"},
                    Limit{R"("at": 1, "event": "delay-io", "milliseconds")", "60000", "60001"},
                    Limit{R"("at": 1, "event": "refuse-open", "extended")", "65535", "65536"},
                    Limit{R"("at": 1, "event": "refuse-open", "extended")", "\"0xFFFF\"", "\"0x10000\""},
                    Limit{R"("at": 1, "event": "refuse-open", "extended")", "\"0\"", "\"0x\""},
                    Limit{R"("at": 1, "event": "refuse-open", "extended": 1, "general")", "1", "0"},
                    Limit{R"("at": 1, "event": "refuse-open", "extended": 1, "count")", "1", "0"},
                    Limit{R"("at": 1, "event": "set-supply", "volts")", "100", "100.5"},
                    Limit{R"("at": 1, "event": "turn-master", "speed")", "-1e7", "-10000001"},
                    Limit{R"("at": 1, "event": "set-temperature", "celsius")", "150", "151"},
                    Limit{R"("at": 1, "event": "set-temperature", "celsius")", "-40", "-41"}));

std::string many(std::size_t count) {
    std::string text = "{\"events\": [";
    for (std::size_t i = 0; i < count; ++i)
        text += fmt::format("{}{{\"at\": 1, \"event\": \"block-axis\"}}", i ? "," : "");
    return text + "]}";
}

TEST(Scenario, HoldsSoManyEvents) {
    EXPECT_EQ(problem(many(max_scenario_events)), "accepted");
    EXPECT_EQ(problem(many(max_scenario_events + 1)), "1:2: 'events' holds at most 10000 events");
}

TEST(Scenario, TheExampleOfTheManualIsSound) {
    EXPECT_THAT(entries(load_scenario(test::data_path("../docs/examples/blocked-axis.json"))),
                ElementsAre("2 put-obstacle position=120000 stiffness=50 from_above=false", "6 remove-obstacle",
                            "8 block-axis", "10 release-axis"));
}

}  // namespace
}  // namespace servobus::adapter
