// Control lines: text in, text out, and what they do to the device.
#include "adapter/control.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/adapter/fake_machine.hpp"
#include "tests/adapter/peers.hpp"

namespace servobus::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

class ControlLines : public testing::Test {
protected:
    std::string answer(std::string_view line) { return control.answer(line, site.now); }
    void set(drive::Key key, drive::Value value) {
        site.device.store().assign(*site.device.find(key), std::move(value));
    }

    Site site{{}, device_with_fake_machine()};
    adapter::Control control{site.adapter, drive::AxisKind{}};
};

TEST_F(ControlLines, AnEventHappensAtOnce) {
    site.adapter.on_timer(site.now);
    site.advance(1500ms);
    EXPECT_EQ(answer(R"({"event": "put-obstacle", "position": 40000, "stiffness": 50})"), R"({"ok":true})");
    ASSERT_EQ(fake_machine().events.size(), 1U);
    EXPECT_EQ(std::get<drive::event::PutObstacle>(fake_machine().events[0]).position, 40000);
    EXPECT_THAT(fake_machine().event_times, ElementsAre(drive::Time(1h) + 1500ms));
    EXPECT_THAT(site.log, ElementsAre("event: put-obstacle position=40000 stiffness=50 from_above=false"));
}

TEST_F(ControlLines, TheDeadlineIsTheMachinesAfterwards) {
    EXPECT_EQ(site.adapter.next_deadline(), std::nullopt);
    fake_machine().on_step = [](drive::Time now) { return std::optional(now + 1ms); };
    EXPECT_EQ(answer(R"({"event": "push-axis", "force": 5})"), R"({"ok":true})");
    EXPECT_EQ(site.adapter.next_deadline(), site.now + 1ms);
}

TEST_F(ControlLines, WhatIsWrongIsSaidAndNothingHappens) {
    EXPECT_EQ(answer(R"({"event": "put-obstacle"})"), R"({"ok":false,"error":"column 1: 'position' is missing"})");
    EXPECT_EQ(answer(R"({"event": "set-input", "number": 13})"),
              R"({"ok":false,"error":"column 24: 'number' must be a whole number from 1 to 12"})");
    EXPECT_EQ(answer(R"({"event": "block-axis", "at": 1})"),
              R"({"ok":false,"error":"column 25: 'at' is not a setting; here may stand: event"})");
    EXPECT_EQ(answer("{}"), R"({"ok":false,"error":"column 1: 'event' is missing"})");
    EXPECT_EQ(answer("[]"), R"({"ok":false,"error":"column 1: the line must hold one object in braces"})");
    EXPECT_EQ(answer(R"({"query": "stat"})"),
              R"({"ok":false,"error":"column 2: 'query' must be one of \"state\", \"axis\""})");
    EXPECT_THAT(answer(R"({"query": "state", "event": "block-axis"})"), HasSubstr("'event' is not a setting"));
    EXPECT_THAT(fake_machine().events, IsEmpty());
}

TEST_F(ControlLines, GarbageGetsOneLineOfSoundJson) {
    for (const auto* line : {"x", "\xff\xfe", "{\"event\": \"\xff\"}", "{\"event\": \"a\\u0000b\"}", "{", "\"", "1e999",
                             "{\"query\": [[[[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]]]]}"}) {
        const auto text = answer(line);
        EXPECT_EQ(text.find('\n'), std::string::npos);
        const auto parsed = json::parse(text, nullptr, false);
        ASSERT_TRUE(parsed.is_object()) << text;
        EXPECT_EQ(parsed["ok"], false);
        EXPECT_FALSE(parsed["error"].get<std::string>().empty());
    }
    EXPECT_EQ(json::parse(answer(std::string(4096, '['))).at("ok"), false);
}

TEST_F(ControlLines, TheStateIsWhatTheTableSays) {
    set({0x66, 0x01}, std::int64_t{0x1237});
    set({0x66, 0x21}, std::int64_t{1});
    set({0x66, 0x24}, std::int64_t{-40000});
    set({0x65, 0x1D}, std::int64_t{2500});
    set({0x66, 0x38}, std::int64_t{-310});
    set({0x64, 0x04}, std::int64_t{0});
    set({0x65, 0x07}, std::int64_t{5});
    set({0x65, 0x06}, std::int64_t{2});
    site.adapter.on_timer(site.now);
    site.now += 2500ms;
    EXPECT_EQ(answer(R"({"query": "state"})"),
              R"({"ok":true,"time":2.5,"statusword":4663,"state":"Operation enabled","power":true,"mode":1,)"
              R"("position":-40000,"velocity":2500,"current":-310,"error":0,"error_text":"no error",)"
              R"("inputs":5,"outputs":2,"output_wires":["open","high","open","open","open","open","open","open"]})");
    EXPECT_EQ(fake_machine().steps.back(), drive::Time(1h) + 2500ms) << "it is the state of now";
}

TEST_F(ControlLines, TheStateOfAFault) {
    set({0x66, 0x01}, std::int64_t{-32760});  // 0x8008: a status word is sixteen bits
    set({0x64, 0x04}, std::int64_t{50});
    set({0x69, 0x01}, std::string("following error"));
    const auto state = json::parse(answer(R"({"query": "state"})"));
    EXPECT_EQ(state["statusword"], 0x8008);
    EXPECT_EQ(state["state"], "Fault");
    EXPECT_EQ(state["power"], false);
    EXPECT_EQ(state["error"], 50);
    EXPECT_EQ(state["error_text"], "following error");
}

TEST_F(ControlLines, TellWhichAxisItIs) {
    EXPECT_THAT(answer(R"({"query": "axis"})"),
                StartsWith(R"({"ok":true,"key":"linax-lxc-230f10","name":"LINAX Lxc 230F10","motion":"linear",)"));
}

TEST_F(ControlLines, APowerCycleEndsTheConnections) {
    auto peer = registered(site);
    EXPECT_EQ(answer(R"({"event": "power-cycle"})"), R"({"ok":true})");
    EXPECT_FALSE(peer.open());
}

TEST(Control, WithoutAMachineNothingCanHappen) {
    Site site;
    adapter::Control control(site.adapter, {});
    EXPECT_EQ(control.answer(R"({"event": "block-axis"})", site.now),
              R"({"ok":false,"error":"this drive has no machine that anything could happen to"})");
    EXPECT_EQ(json::parse(control.answer(R"({"query": "state"})", site.now)).at("ok"), true);
}

}  // namespace
}  // namespace servobus::test
