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
              R"({"ok":false,"error":"column 25: 'at' is not a setting; here may stand: drive, event"})");
    EXPECT_EQ(answer("{}"), R"({"ok":false,"error":"column 1: 'event' is missing"})");
    EXPECT_EQ(answer("[]"), R"({"ok":false,"error":"column 1: the line must hold one object in braces"})");
    EXPECT_EQ(answer(R"({"query": "stat"})"),
              R"({"ok":false,"error":"column 2: 'query' must be one of \"state\", \"axis\", )"
              R"(\"connections\", \"counters\", \"lights\", \"firmware\", \"network\""})");
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

TEST_F(ControlLines, FaultsOfTheNetworkAreEventsToo) {
    EXPECT_EQ(answer(R"({"event": "drop-io", "direction": "o_to_t", "share": 0.3, "seconds": 5})"), R"({"ok":true})");
    EXPECT_THAT(site.log, ElementsAre("event: drop-io direction=o_to_t share=0.3 count=0 seconds=5"));
    EXPECT_EQ(site.adapter.faults().active(), 1U);
    EXPECT_EQ(answer(R"({"event": "restore-network"})"), R"({"ok":true})");
    EXPECT_EQ(site.adapter.faults().active(), 0U);
    EXPECT_EQ(answer(R"({"event": "refuse-open"})"), R"({"ok":false,"error":"column 1: 'extended' is missing"})");
    EXPECT_EQ(answer(R"({"event": "refuse-open", "extended": "0x10000"})"),
              R"({"ok":false,"error":"column 26: 'extended' must be a whole number from 0 to 65535, or a text such as )"
              R"(\"0x0113\""})");
    EXPECT_THAT(fake_machine().events, IsEmpty());
}

TEST_F(ControlLines, TooManyFaultsAreRefused) {
    const auto* line = R"({"event": "drop-io"})";
    for (std::size_t i = 0; i < adapter::NetworkFaults::max_active; ++i) EXPECT_EQ(answer(line), R"({"ok":true})");
    EXPECT_EQ(answer(line), R"({"ok":false,"error":"there are 64 network faults already"})");
}

TEST_F(ControlLines, TellTheConnections) {
    EXPECT_EQ(answer(R"({"query": "connections"})"), R"({"ok":true,"connections":[]})");
    auto peer = registered(site);
    cip::ForwardOpen open;
    open.t_to_o_id = 0x0A110001;
    open.triad = {7, 0x004D, 0x11223344};
    open.o_to_t_rpi = open.t_to_o_rpi = 10'000;
    open.o_to_t.size = 24;
    open.t_to_o.size = 30;
    open.transport = {false, 0, 1};
    open.path = octets("20 04 24 01 2C 65 2C 64");
    ASSERT_THAT(peer.call(cip::Request{0x54, cip::Path::to(6, 1), open.encode()}.encode()), StartsWith("D4 00 00 00"));
    const auto told = json::parse(answer(R"({"query": "connections"})")).at("connections");
    ASSERT_EQ(told.size(), 1U);
    const auto& connection = told[0];
    EXPECT_EQ(connection["number"], 1);
    EXPECT_EQ(connection["kind"], "exclusive owner");
    EXPECT_EQ(connection["o_to_t_point"], 101);
    EXPECT_EQ(connection["t_to_o_point"], 100);
    EXPECT_EQ(connection["originator"], "192.168.2.1:2222");
    EXPECT_EQ(connection["vendor"], 77);
    EXPECT_EQ(connection["originator_serial"], 0x11223344);
    EXPECT_EQ(connection["serial"], 7);
    EXPECT_EQ(connection["state"], "waiting");
    EXPECT_EQ(connection["run"], false);
    EXPECT_EQ(connection["trigger"], "cyclic");
    EXPECT_EQ(connection["multicast"], false);
    EXPECT_EQ(connection["t_to_o_interval_us"], 10'000);
    EXPECT_EQ(connection["timeout_us"], 40'000);
    EXPECT_EQ(connection["received"], 0);
}

TEST_F(ControlLines, TellTheCounters) {
    auto peer = registered(site);
    site.adapter.on_io({0xC0A80201, 2222}, Site::local, octets("00"), site.now);
    const auto told = json::parse(answer(R"({"query": "counters"})"));
    EXPECT_EQ(told["ok"], true);
    EXPECT_EQ(told["tcp_connections"], 1);
    ASSERT_EQ(told["sessions"].size(), 1U);
    EXPECT_EQ(told["sessions"][0]["session"], peer.session());
    EXPECT_EQ(told["sessions"][0]["peer"], "192.168.2.1:50000");
    EXPECT_EQ(told["open_requests"], 0);
    EXPECT_EQ(told["stray_datagrams"]["malformed"], 1);
    EXPECT_EQ(told["faults"]["active"], 0);
    EXPECT_EQ(told["faults"]["o_to_t"]["dropped"], 0);
    // The handle that is told is the one that is closed.
    EXPECT_EQ(answer(fmt::format(R"({{"event": "close-sessions", "session": {}}})", peer.session())), R"({"ok":true})");
    EXPECT_FALSE(peer.open());
}

TEST_F(ControlLines, TellTheNetwork) {
    auto& network = site.adapter.network();
    network.settings.method = adapter::AddressMethod::bootp;
    network.state.interface = {.address = 0xC0A80264, .mask = 0xFFFFFF00, .gateway = 0xC0A80201};
    network.state.address.conflict = true;
    network.state.ring = {1, 1, 0xC0A80201, {2, 0, 0, 0, 0, 1}};
    network.settings.last_conflict[0] = 2;
    network.settings.last_conflict[6] = 7;
    const auto told = json::parse(answer(R"({"query": "network"})"));
    EXPECT_EQ(told["method"], "bootp");
    EXPECT_EQ(told["address"], "192.168.2.100");
    EXPECT_EQ(told["prefix"], 24);
    EXPECT_EQ(told["gateway"], "192.168.2.1");
    EXPECT_EQ(told["configured"], true);
    EXPECT_EQ(told["conflict"], true);
    EXPECT_EQ(told["without_address"], false);
    EXPECT_EQ(told["last_conflict"]["activity"], "ongoing detection");
    EXPECT_EQ(told["last_conflict"]["mac"], "00:00:00:00:00:07");
    EXPECT_EQ(told["ring"]["status"], 1);
    EXPECT_EQ(told["ring"]["supervisor_mac"], "02:00:00:00:00:01");
    network.state.interface = {};
    network.settings.last_conflict = {};
    const auto without = json::parse(answer(R"({"query": "network"})"));
    EXPECT_TRUE(without["address"].is_null() && without["last_conflict"].is_null());
}

TEST_F(ControlLines, NameADrive) {
    Site second{{}, device_with_fake_machine()};
    adapter::Control both(site.adapter, drive::AxisKind{}, "127.0.1.1");
    both.add(second.adapter, "127.0.1.2");
    EXPECT_EQ(both.answer(R"({"event": "cut-cable", "drive": "127.0.1.2"})", site.now), R"({"ok":true})");
    EXPECT_EQ(site.adapter.faults().active(), 0U);
    EXPECT_EQ(second.adapter.faults().active(), 1U);
    const auto told = json::parse(both.answer(R"({"query": "counters", "drive": "127.0.1.2"})", site.now));
    EXPECT_EQ(told["faults"]["active"], 1);
    EXPECT_EQ(both.answer(R"({"query": "axis", "drive": "127.0.1.3"})", site.now),
              R"({"ok":false,"error":"column 19: 'drive' must be one of \"127.0.1.1\", \"127.0.1.2\""})");
}

TEST_F(ControlLines, StopTheProgram) {
    const auto* line = R"({"command": "stop"})";
    EXPECT_EQ(answer(line), R"({"ok":false,"error":"nothing here can be stopped"})");
    bool stopped = false;
    control.on_stop([&] { stopped = true; });
    EXPECT_EQ(answer(line), R"({"ok":true})");
    EXPECT_TRUE(stopped);
    EXPECT_THAT(answer(R"({"command": "start"})"), HasSubstr("'command' must be one of \\\"stop\\\""));
}

TEST(Control, WithoutAMachineNothingCanHappen) {
    Site site;
    adapter::Control control(site.adapter, {});
    EXPECT_EQ(control.answer(R"({"event": "block-axis"})", site.now),
              R"({"ok":false,"error":"this drive has no machine that anything could happen to"})");
    EXPECT_EQ(json::parse(control.answer(R"({"query": "state"})", site.now)).at("ok"), true);
    EXPECT_EQ(control.answer(R"({"event": "cut-cable"})", site.now), R"({"ok":true})") << "a network it has";
}

}  // namespace
}  // namespace servobus::test
