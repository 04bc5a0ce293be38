// `axis HOST VERB` as people meet it, against a drive without mechanics on loopback.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/scanner/fake_axis.hpp"
#include "tests/scanner/fake_server.hpp"
#include "tests/scanner/run_scanner.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace test;
using nlohmann::json;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::MatchesRegex;
using testing::Not;
using testing::StartsWith;

class AxisRun : public testing::Test {
protected:
    /// The axis is used by the server's thread, and by the test before and after.
    test::Run run(std::vector<std::string> words) {
        const FakeServer server(answering([this](const cip::Request& request) { return axis.answer(request); }));
        words.insert(words.begin(), {"axis", server.host()});
        return run_scanner(words, {terminal, &interruptions});
    }

    FakeAxis axis;
    bool terminal = false;
    std::atomic<int> interruptions{0};
};

TEST_F(AxisRun, RefusesWrongUsage) {
    const std::vector<std::vector<std::string>> mistakes{
        {},
        {"fly"},
        {"move"},
        {"move", "x"},
        {"move", "99999999999"},
        {"move", "1", "2"},
        {"move", "1", "--wait", "soon"},
        {"move", "1", "--trace", "a.png"},
        {"move", "1", "--trace", "/no/such/folder/a.svg"},
        {"jog", "positive"},
        {"jog", "up", "--speed", "1"},
        {"jog", "positive", "--speed", "1", "--duration", "0s"},
        {"reference", "--method", "16"},
        {"force-calibrate"},
        {"trace"},
        {"trace", "--out", "a.csv", "status"},
    };
    for (const auto& words : mistakes) {
        const auto result = run(words);
        const auto shown = testing::PrintToString(words);
        EXPECT_EQ(result.code, 2) << shown;
        EXPECT_THAT(result.out, IsEmpty()) << shown;
        EXPECT_THAT(result.err, StartsWith("servobus-scanner: ")) << shown;
    }
    EXPECT_THAT(axis.writes, IsEmpty());
    EXPECT_EQ(run_scanner({"axis", "127.0.0.1"}).code, 2);
    EXPECT_EQ(run_scanner({"axis", "a b", "status"}).code, 2);
}

TEST_F(AxisRun, HelpsWithExamples) {
    EXPECT_THAT(run_scanner({"axis", "--help"}).out, HasSubstr("Ctrl-C halts the axis"));
    for (const std::string verb : {"status", "enable", "disable", "reference", "move", "jog", "halt", "quick-stop",
                                   "fault-reset", "force-calibrate", "trace"}) {
        const auto result = run({verb, "--help"});
        EXPECT_EQ(result.code, 0);
        EXPECT_THAT(result.out, AllOf(HasSubstr("Examples:"), HasSubstr(" " + verb)));
    }
}

TEST_F(AxisRun, TellsTheState) {
    axis.make_ready();
    axis.set(AxisValue::inputs, 0x00010002);
    axis.set(AxisValue::target, -4);
    const auto result = run({"status"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(result.out,
              "state            Operation enabled\n"
              "mode             1 profile position mode\n"
              "error            none\n"
              "reference        referenced (TH 0)\n"
              "motor            230101\n"
              "position         1000 increments\n"
              "target           -4 increments\n"
              "following error  0 increments\n"
              "velocity         0 increments/s\n"
              "current          0 mA\n"
              "force current    0 mA\n"
              "temperature      25 °C\n"
              "motor supply     48.0 V\n"
              "control word     0x000F  switch on, enable voltage, no quick stop, enable operation\n"
              "status word      0x0237  ready to switch on, switched on, operation enabled, voltage enabled, no quick "
              "stop, remote\n"
              "process status   0x00000002  reference\n"
              "inputs           0x00010002  positive limit switch, input 1\n"
              "outputs          0x00000000\n");
    const auto document = json::parse(run({"status", "--json"}).out)["axis"];
    EXPECT_EQ(document["state"], "Operation enabled");
    EXPECT_EQ(document["inputs"]["bits"][1], "input 1");
}

TEST_F(AxisRun, TellsAFault) {
    axis.fail_with(50, "following\nerror");
    EXPECT_THAT(run({"status"}).out,
                AllOf(StartsWith("state            Fault\n"), HasSubstr("50: following\\x0Aerror")));
    const auto refused = run({"enable"});
    EXPECT_EQ(refused.code, 6);
    EXPECT_EQ(
        refused.err,
        "servobus-scanner: the drive is in 'Fault' with error 50: following\\x0Aerror; call 'fault-reset' first\n");
    EXPECT_EQ(run({"fault-reset"}).out,
              "The fault is reset; it was error 50: following\\x0Aerror. Next: 'reference'\n");
    EXPECT_EQ(run({"fault-reset"}).out, "There was no fault; the drive is in 'Switch on disabled'\n");
}

TEST_F(AxisRun, IsNoVerbForOtherDevices) {
    const FakeServer server(answering([](const cip::Request& request) {
        return cip::Response{request.service, cip::GeneralStatus::path_destination_unknown, {}};
    }));
    const auto result = run_scanner({"axis", server.host(), "status"});
    EXPECT_EQ(result.code, 4);
    EXPECT_THAT(result.err, AllOf(HasSubstr("Statusword: refused"), HasSubstr("is this a XENAX?")));
}

TEST_F(AxisRun, MovesStepByStep) {
    EXPECT_THAT(run({"move", "5"}).err, HasSubstr("'Switch on disabled'; call 'reference' first"));
    EXPECT_THAT(run({"enable"}).out, Not(IsEmpty()));
    const auto unreferenced = run({"move", "5"});
    EXPECT_EQ(unreferenced.code, 6);
    EXPECT_THAT(unreferenced.err, HasSubstr("not referenced; call 'reference' first"));

    EXPECT_THAT(run({"reference"}).out,
                MatchesRegex("Referenced in [0-9.]+ s by method 1 \\(start positive\\); the axis stands at 500 "
                             "increments\n"));
    const auto moved = run({"move", "-5000"});
    EXPECT_EQ(moved.code, 0);
    EXPECT_THAT(moved.out, MatchesRegex("Moved to -5000 increments in [0-9.]+ s; following error at most 7\n"));
    EXPECT_EQ(moved.err,
              "servobus-scanner: waiting for mode 1, profile position mode\n"
              "servobus-scanner: waiting for the target position\n");
    EXPECT_THAT(run({"move", "--relative", "-10"}).out, StartsWith("Moved by -10 to -5010 increments"));
    EXPECT_THAT(run({"disable"}).out, StartsWith("Disabled; the drive is in 'Ready to switch on'"));
}

TEST_F(AxisRun, TellsProgramsInJson) {
    axis.make_ready();
    const auto document = json::parse(run({"move", "5000", "--json"}).out);
    EXPECT_EQ(document["verb"], "move");
    EXPECT_EQ(document["position"], 5000);
    EXPECT_EQ(document["largest_following_error"], 7);
    axis.fail_with(1, "x");
    EXPECT_EQ(json::parse(run({"move", "5000", "--json"}).out)["error"]["kind"], "axis");
}

TEST_F(AxisRun, WorksWithoutPackets) {
    axis.make_ready();
    axis.takes_packets = false;
    EXPECT_EQ(run({"move", "5000"}).code, 0);
    EXPECT_EQ(run({"status"}).code, 0);
}

TEST_F(AxisRun, TakesTheMethodOfTheMotor) {
    axis.refuses = [](const AxisWrite& write) { return write.to == AxisValue::reference_method && write.value == 1; };
    EXPECT_THAT(run({"reference"}).out, HasSubstr("by method 10 "));
    const auto asked = run({"reference", "--method", "Positive"});
    EXPECT_EQ(asked.code, 4);
    EXPECT_THAT(asked.err, HasSubstr("ReferenceMethods: refused with 0x09"));
    axis.refuses = [](const AxisWrite&) { return false; };
    axis.state.take(AxisValue::motor_type, drive::Value(std::string("rotative")));
    EXPECT_THAT(run({"reference"}).out, HasSubstr("by method 10 "));
    EXPECT_THAT(run({"reference", "--method", "ccw-cw"}).out, HasSubstr("by method 13 "));
}

TEST_F(AxisRun, SaysWhenItStandsElsewhere) {
    axis.make_ready();
    axis.in_motion = [](FakeAxis& self) { self.write({AxisValue::control_word, 0x10F}); };
    const auto result = run({"move", "5000"});
    EXPECT_EQ(result.code, 6);
    EXPECT_THAT(result.err, HasSubstr("the axis stands at 1000 increments and not at 5000"));
}

TEST_F(AxisRun, WaitsNoLongerThanItIsTold) {
    axis.make_ready();
    axis.motion = 1'000'000;
    const auto result = run({"move", "5000", "--wait", "0.2s"});
    EXPECT_EQ(result.code, 6);
    EXPECT_THAT(result.err, EndsWith("waited 0.2 s for the target position; the drive is in 'Operation enabled'; the "
                                     "axis still moves, 'halt' stops it\n"));
    EXPECT_THAT(run({"move", "1"}).err, HasSubstr("the axis is in motion; call 'halt' first"));
    EXPECT_THAT(run({"halt"}).out, StartsWith("Halted at "));
    EXPECT_THAT(run({"halt"}).out, StartsWith("The axis stood still already"));
    EXPECT_THAT(run({"quick-stop"}).out, HasSubstr("'Quick stop active'"));
}

TEST_F(AxisRun, TellsAFaultInMotion) {
    axis.make_ready();
    axis.in_motion = [](FakeAxis& self) { self.fail_with(50, "following error"); };
    const auto result = run({"move", "5000"});
    EXPECT_EQ(result.code, 6);
    EXPECT_THAT(result.err, HasSubstr("in 'Fault' with error 50: following error; 'fault-reset' ends the fault"));
}

TEST_F(AxisRun, HaltsOnCtrlC) {
    axis.make_ready();
    axis.motion = 1'000'000;
    axis.in_motion = [this](FakeAxis&) { interruptions = 1; };
    const auto result = run({"move", "5000"});
    EXPECT_EQ(result.code, 130);
    EXPECT_THAT(result.out, IsEmpty());
    EXPECT_THAT(result.err, HasSubstr("interrupted; the axis was halted and stands at "));
    EXPECT_THAT(axis.control_words(), ElementsAre(0x0F, 0x1F, 0x11F));
}

TEST_F(AxisRun, JogsUntilCtrlC) {
    axis.make_ready();
    axis.motion = 1'000'000;
    int looks = 0;
    axis.in_motion = [&](FakeAxis&) { interruptions = ++looks > 5 ? 1 : 0; };
    const auto result = run({"jog", "NEGATIVE", "--speed", "700"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(result.out, StartsWith("Jogged negative from 1000 to "));
    EXPECT_THAT(axis.control_words(), ElementsAre(0x0F, 0x1F, 0x11F));
}

TEST_F(AxisRun, JogsForATime) {
    axis.make_ready();
    const auto result = run({"jog", "positive", "--speed", "700", "--acceleration", "9000", "--duration", "50ms"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(result.out, StartsWith("Jogged positive from 1000 to "));
    EXPECT_THAT(axis.control_words(), ElementsAre(0x0F, 0x5F, 0x11F));
}

TEST_F(AxisRun, WarnsWhenTheConnectionBreaksInMotion) {
    axis.make_ready();
    axis.motion = 1'000'000;
    int looks = 0;
    axis.in_motion = [&](FakeAxis&) { ++looks; };
    const FakeServer server(after_registration([&](Peer& peer, const enip::Frame& frame) {
        peer.send(reply_with(frame, axis.answer(request_in(frame))));
        if (looks > 2) peer.close();
    }));
    const auto result = run_scanner({"axis", server.host(), "move", "5000"});
    EXPECT_EQ(result.code, 3);
    EXPECT_THAT(result.err, EndsWith("; the axis may still move\n"));
}

TEST_F(AxisRun, ShowsABarOnATerminal) {
    axis.make_ready();
    axis.motion = 30;
    terminal = true;
    const auto result = run({"move", "5000"});
    EXPECT_THAT(result.err, AllOf(HasSubstr("\r["), HasSubstr("increments  waiting for the target position\x1B[K"),
                                  EndsWith("\r\x1B[K")));
    EXPECT_THAT(result.err, Not(HasSubstr("servobus-scanner: ")));
}

TEST_F(AxisRun, CalibratesForce) {
    axis.make_ready();
    EXPECT_THAT(run({"force-calibrate", "--start", "200", "--way", "-100"}).out,
                StartsWith("Force calibrated from 200 to 100 increments in "));
    EXPECT_THAT(axis.writes, Contains(AxisWrite{AxisValue::calibration_way, -100}));
}

std::string content(const std::string& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

TEST_F(AxisRun, RecordsAMotion) {
    axis.make_ready();
    const auto base = testing::TempDir() + "/servobus_axis_" + std::to_string(getpid());
    const auto table = base + ".csv";
    const auto picture = base + ".svg";
    const auto result = run({"move", "5000", "--trace", table, "--trace", picture});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(result.out, AllOf(HasSubstr(table + ": "), HasSubstr(picture + ": "), HasSubstr(" ms apart\n")));
    EXPECT_THAT(content(table), AllOf(StartsWith("time [s],position [increment],"), HasSubstr(",5000,")));
    EXPECT_THAT(content(picture), AllOf(HasSubstr("move: Moved to 5000 increments in"), EndsWith("</svg>\n")));

    EXPECT_EQ(run({"trace", "--duration", "20ms", "--interval", "5ms", "--out", table}).code, 0);
    EXPECT_THAT(content(table), Not(HasSubstr(",1000,")));
    EXPECT_THAT(run({"trace", "--out", picture, "move", "7000"}).out, StartsWith("Moved to 7000 increments"));
    EXPECT_THAT(content(picture), HasSubstr("move: Moved to 7000 increments in"));
    std::remove(table.c_str());
    std::remove(picture.c_str());
}

}  // namespace
}  // namespace servobus::scanner::cli
