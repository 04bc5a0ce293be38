// The lights of the module: the printed table, what a drive makes of it, and how people see it.
#include "adapter/status_lights.hpp"

#include <nlohmann/json.hpp>

#include "adapter/control.hpp"
#include "adapter/status_line.hpp"
#include "tests/adapter/io_site.hpp"
#include "tests/adapter/peers.hpp"

namespace servobus::test {
namespace {

using adapter::is_lit;
using adapter::Light;
using adapter::LightMode;
using adapter::ModuleState;
using adapter::status_lights;
using testing::ElementsAre;
using testing::HasSubstr;

/// "blink off on off": RUN, ERR, ST1, ST2.
std::string modes(const adapter::StatusLights& lights) {
    std::string text;
    for (const auto& light : lights) text += fmt::format("{}{}", text.empty() ? "" : " ", name(light.mode));
    return text;
}

std::string meaning(const adapter::StatusLights& lights, Light light) {
    return std::string(lights[static_cast<std::size_t>(light)].meaning);
}

// ------------------------------------------------------------------------------------------------------- the table

struct Printed {
    const char* what;
    ModuleState state;
    const char* modes;
};
void PrintTo(const Printed& each, std::ostream* out) { *out << each.what; }

class PrintedLights : public testing::TestWithParam<Printed> {};

TEST_P(PrintedLights, AreThoseOfTheManual) { EXPECT_EQ(modes(status_lights(GetParam().state)), GetParam().modes); }

// 000 §1.3 by cells; R-LED-1.
INSTANTIATE_TEST_SUITE_P(
    Manual, PrintedLights,
    testing::Values(
        Printed{"no power", {.powered = false}, "off off off off"},
        Printed{"no power, whatever was before",
                {.powered = false, .connected = true, .address_conflict = true, .fault = true, .download = true},
                "off off off off"},
        Printed{"init process", {.initialising = true}, "off off off off"},
        Printed{"power on, not connected", {}, "blink off off off"},
        Printed{"power on, connected", {.connected = true}, "on off off off"},
        Printed{"fault state", {.fault = true}, "blink on off off"},
        Printed{"fault state, connected", {.connected = true, .fault = true}, "on on off off"},
        Printed{"address conflict", {.address_conflict = true}, "blink blink off off"},
        Printed{"address conflict and fault", {.address_conflict = true, .fault = true}, "blink blink off off"},
        Printed{"download", {.download = true}, "blink off off blink"},
        Printed{"download, connected", {.connected = true, .download = true}, "on off off blink"},
        Printed{"factory mode, valid bit stream", {.factory_mode = true}, "off off on off"},
        Printed{"factory mode, no valid bit stream",
                {.factory_mode = true, .valid_bit_stream = false},
                "off off blink off"},
        Printed{"download in factory mode",
                {.factory_mode = true, .valid_bit_stream = false, .download = true},
                "off off blink blink"},
        Printed{"a bit stream that is being replaced",
                {.valid_bit_stream = false, .download = true},
                "blink off off blink"}));

// The same rules written once more, over everything that can be.
TEST(StatusLights, AreDefinedForAllStates) {
    for (unsigned bits = 0; bits < 256; ++bits) {
        const auto is = [&](unsigned bit) { return (bits >> bit & 1U) != 0; };
        const ModuleState state{is(0), is(1), is(2), is(3), is(4), is(5), is(6), is(7)};
        const bool runs = state.powered && !state.initialising && !state.factory_mode;
        const auto* run = !runs ? "off" : state.connected ? "on" : "blink";
        const bool tells = state.powered && !state.factory_mode;
        const auto* err = tells && state.address_conflict ? "blink" : tells && state.fault ? "on" : "off";
        const bool factory = state.powered && state.factory_mode;
        const auto* st1 = !factory ? "off" : state.valid_bit_stream ? "on" : "blink";
        const auto* st2 = state.powered && state.download ? "blink" : "off";
        EXPECT_EQ(modes(status_lights(state)), fmt::format("{} {} {} {}", run, err, st1, st2)) << bits;
    }
}

TEST(StatusLights, SayWhatTheyMean) {
    EXPECT_EQ(meaning(status_lights({}), Light::run), "power on, not connected");
    EXPECT_EQ(meaning(status_lights({}), Light::err), "");
    EXPECT_EQ(meaning(status_lights({.address_conflict = true}), Light::err), "IPv4 address conflict detected");
    EXPECT_THAT(meaning(status_lights({.factory_mode = true}), Light::st1), HasSubstr("ready for firmware download"));
}

TEST(StatusLights, BlinkOnceASecondHalfOfIt) {
    std::string shines;
    for (auto time = 0ms; time < 2000ms; time += 125ms) shines += is_lit(LightMode::blink, time) ? '*' : '-';
    EXPECT_EQ(shines, "****----****----");
    EXPECT_TRUE(is_lit(LightMode::blink, 499'999us));
    EXPECT_FALSE(is_lit(LightMode::blink, 500'000us));
    for (const auto time : {0ms, 250ms, 750ms}) {
        EXPECT_TRUE(is_lit(LightMode::on, time));
        EXPECT_FALSE(is_lit(LightMode::off, time));
    }
}

// --------------------------------------------------------------------------------------------------- what a drive does

TEST(LightsOfADrive, RunIsOnWhileThereIsAConnection) {
    IoSite site;
    IoPeer peer(site);
    EXPECT_EQ(modes(site.adapter.lights()), "blink off off off") << "a session is no connection (R-LED-2)";
    const auto link = peer.must_open(io_open(1, 254, 100));
    EXPECT_EQ(modes(site.adapter.lights()), "on off off off");
    EXPECT_EQ(peer.close(link), closed(link.request.triad));
    EXPECT_EQ(modes(site.adapter.lights()), "blink off off off");
    peer.must_open(io_open(2));
    EXPECT_EQ(modes(site.adapter.lights()), "on off off off");
    site.advance(11s);  // no datagram has come: it times out
    EXPECT_EQ(modes(site.adapter.lights()), "blink off off off");
}

TEST(LightsOfADrive, AClass3ConnectionCounts) {
    Site site;
    auto peer = registered(site);
    peer.open_class3();
    EXPECT_EQ(modes(site.adapter.lights()), "on off off off");
    peer.close();
    EXPECT_EQ(modes(site.adapter.lights()), "blink off off off");
}

TEST(LightsOfADrive, ErrIsOnInAFaultAndOffWhenItIsReset) {
    IoSite site(drive::Device(*drive::xenax_model("75v8s"), drive::Machine{}));
    IoPeer peer(site);
    const auto set_controlword = [&](std::string_view value) {
        return peer.call(fmt::format("10 03 20 66 24 01 30 00 {}", value));
    };
    for (const auto* word : {"06 00", "07 00", "0F 00"}) {
        EXPECT_EQ(set_controlword(word), "90 00 00 00");
        site.advance(500ms);
    }
    ASSERT_TRUE(site.adapter.inject(drive::Event(drive::event::LoseEncoder{true}), site.now));
    site.advance(1s);
    EXPECT_EQ(modes(site.adapter.lights()), "blink on off off");
    ASSERT_TRUE(site.adapter.inject(drive::Event(drive::event::LoseEncoder{false}), site.now));
    EXPECT_EQ(set_controlword("80 00"), "90 00 00 00");
    site.advance(100ms);
    EXPECT_EQ(modes(site.adapter.lights()), "blink off off off");
}

// R-LED-2 and 0xF5/1/1.
TEST(LightsOfADrive, FollowTheStatusOfTheAddress) {
    IoSite site;
    auto& address = site.adapter.network().state.address;
    address = {.configured = false};
    EXPECT_EQ(modes(site.adapter.lights()), "off off off off") << "init process: it looks for an address";
    address = {.configured = false, .without_address = true};
    EXPECT_EQ(modes(site.adapter.lights()), "blink blink off off") << "a conflict ends the search";
    address = {.configured = true, .conflict = true};
    EXPECT_EQ(modes(site.adapter.lights()), "blink blink off off");
    address = {};
    EXPECT_EQ(modes(site.adapter.lights()), "blink off off off");
    address.conflict = true;
    site.tick();
    EXPECT_EQ(site.log.back().text, "light ERR: blink, IPv4 address conflict detected");
    EXPECT_EQ(site.log.back().level, adapter::LogLevel::info);
}

TEST(LightsOfADrive, AreDarkWithoutPower) {
    IoSite site;
    ASSERT_TRUE(site.adapter.inject(adapter::NetworkFault(adapter::fault::Restart{2}), site.now));
    EXPECT_EQ(modes(site.adapter.lights()), "off off off off");
    EXPECT_EQ(meaning(site.adapter.lights(), Light::run), "no power");
    site.advance(2s);
    EXPECT_EQ(modes(site.adapter.lights()), "blink off off off");
}

TEST(LightsOfADrive, TheLogTellsOfChangesAndOfNothingElse) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(io_open(1, 254, 100));
    site.advance(1s);
    std::vector<std::string> lines;
    for (const auto& line : site.log) {
        if (!line.text.starts_with("light ")) continue;
        EXPECT_EQ(line.level, adapter::LogLevel::debug);
        lines.push_back(line.text);
    }
    EXPECT_THAT(lines, ElementsAre("light RUN: on, power on, connected"));
    ASSERT_TRUE(site.adapter.inject(drive::Event(drive::event::PowerCycle{}), site.now));
    EXPECT_EQ(site.log.back().text, "light RUN: blink, power on, not connected");
}

TEST(LightsOfADrive, AreToldByQuery) {
    Site site;
    site.adapter.on_timer(site.now);
    site.now += 250ms;
    adapter::Control control(site.adapter, drive::AxisKind{});
    EXPECT_EQ(control.answer(R"({"query": "lights"})", site.now),
              R"({"ok":true,"RUN":{"mode":"blink","lit":true,"meaning":"power on, not connected"},)"
              R"("ERR":{"mode":"off","lit":false,"meaning":""},"ST1":{"mode":"off","lit":false,"meaning":""},)"
              R"("ST2":{"mode":"off","lit":false,"meaning":""}})");
    site.now += 250ms;
    const auto later = nlohmann::json::parse(control.answer(R"({"query": "lights"})", site.now));
    EXPECT_EQ(later["RUN"]["lit"], false);
}

TEST(LightsOfADrive, EachOfManyHasItsOwn) {
    IoSite first;
    IoSite second;
    IoPeer peer(second);
    peer.must_open(io_open(1));
    adapter::Control control(first.adapter, drive::AxisKind{}, "127.0.1.1");
    control.add(second.adapter, "127.0.1.2");
    EXPECT_THAT(control.answer(R"({"query": "lights", "drive": "127.0.1.1"})", first.now), HasSubstr("not connected"));
    EXPECT_THAT(control.answer(R"({"query": "lights", "drive": "127.0.1.2"})", first.now),
                HasSubstr("power on, connected"));
}

// ---------------------------------------------------------------------------------------------------- the status line

std::string line_of(std::vector<const adapter::Adapter*> drives, enip::Time now, std::size_t width = 200) {
    return adapter::status_line(drives, now, width);
}

TEST(StatusLine, OfOneDrive) {
    IoSite site(drive::Device(*drive::xenax_model("75v8s"), drive::Machine{}));
    EXPECT_EQ(line_of({&site.adapter}, site.now),
              "RUN * ERR - ST1 - ST2 - | no owner | 0 I/O, 0 class 3 | Switch on disabled");
    EXPECT_EQ(line_of({&site.adapter}, site.now + 500ms).substr(0, 5), "RUN -");
    IoPeer peer(site);
    const auto link = peer.must_open(io_open(1));
    EXPECT_EQ(line_of({&site.adapter}, site.now + 500ms),
              "RUN * ERR - ST1 - ST2 - | owner 192.168.2.1 standard waiting | 1 I/O, 0 class 3 | Switch on disabled");
    peer.send(o_to_t(link, 1, 1, run, cip::Bytes(18)));
    EXPECT_THAT(line_of({&site.adapter}, site.now), HasSubstr("owner 192.168.2.1 standard run |"));
    EXPECT_EQ(line_of({&site.adapter}, site.now, 20), "RUN * ERR - ST1 - ST");
    EXPECT_EQ(line_of({&site.adapter}, site.now, 0), "");
}

TEST(StatusLine, OfManyDrivesCountsThem) {
    IoSite one(drive::Device(*drive::xenax_model("75v8s"), drive::Machine{}));
    IoSite two(drive::Device(*drive::xenax_model("75v8s"), drive::Machine{}));
    IoSite three(drive::Device(*drive::xenax_model("75v8s"), drive::Machine{}));
    IoPeer peer(two);
    peer.must_open(io_open(1));
    EXPECT_EQ(line_of({&one.adapter, &two.adapter, &three.adapter}, one.now),
              "RUN 1 on, 2 blink | 1 owners | 1 I/O, 0 class 3 | 3 Switch on disabled");
    EXPECT_EQ(line_of({}, one.now), "");
}

}  // namespace
}  // namespace servobus::test
