// I/O connections from the command line against the real adapter.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "tests/scanner/run_scanner.hpp"
#include "tests/scanner/running_adapter.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace std::chrono_literals;
using namespace test;
using nlohmann::json;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

using IoEndToEnd = test::RunningAdapter;

std::vector<json> lines_of(const std::string& text) {
    std::vector<json> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(json::parse(line));
    return lines;
}

std::string content(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

TEST_F(IoEndToEnd, EveryConnectionOpensRunsAndCloses) {
    for (const auto* key : {"standard", "iforce", "outputs", "force", "cipsync", "input-only"}) {
        const auto result = run_scanner({"io", host, "--connection", key, "--duration", "0.2", "--json"});
        EXPECT_EQ(result.code, 0) << key << result.err;
        const auto lines = lines_of(result.out);
        ASSERT_GE(lines.size(), 4U) << key;
        EXPECT_EQ(lines[0]["event"], "opened");
        EXPECT_EQ(lines[1]["event"], "input");
        EXPECT_EQ(lines[1]["values"]["Statusword"], 0x0250) << "nothing has changed by that it was opened";
        EXPECT_EQ(lines[lines.size() - 2]["reason"], "asked");
        EXPECT_EQ(lines.back()["event"], "end");
        EXPECT_EQ(lines.back()["statistics"]["lost"], 0);
        EXPECT_EQ(lines.back()["statistics"]["received"], lines.size() - 3);
        EXPECT_FALSE(lines.back().contains("error"));
    }
}

TEST_F(IoEndToEnd, OpenSaysThatAllIsWell) {
    for (const auto* key : {"standard", "iforce", "outputs", "force", "cipsync", "input-only"}) {
        const auto result = run_scanner({"open", host, "--connection", key, "--key", "auto", "--rpi", "2"});
        EXPECT_EQ(result.code, 0) << key << result.err;
        EXPECT_THAT(result.out, AllOf(StartsWith("All is well: "), HasSubstr("every 2 ms")));
    }
    const auto document = json::parse(run_scanner({"open", host, "--json", "--multicast"}).out);
    EXPECT_EQ(document["opened"]["t_to_o"]["connection_size"], 30);
    EXPECT_GE(document["first_input_ms"], 0);
    EXPECT_LT(document["first_input_ms"], 5000);
}

TEST_F(IoEndToEnd, AnyDeviceByItsNumbers) {
    const std::vector<std::string> numbers{"--o2t",      "101", "--o2t-size",        "18", "--t2o", "100",
                                           "--t2o-size", "28",  "--config-instance", "1"};
    std::vector<std::string> words{"io", host, "--set", "@12:DINT=35", "--duration", "0.2"};
    words.insert(words.end(), numbers.begin(), numbers.end());
    const auto result = run_scanner(words);
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(result.out, HasSubstr(" s  50 02 00 00 "));
    EXPECT_THAT(run_scanner({"get", host, "SCurve"}).out, StartsWith("SCurve = 35 %"));
}

TEST_F(IoEndToEnd, WhatIsSetArrivesAndTheRestStays) {
    EXPECT_EQ(run_scanner({"set", host, "SCurve=70"}).code, 0);
    const auto result = run_scanner({"io", host, "--set", "TargetPositionOrDistance=-1234", "--duration", "0.1"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(run_scanner({"get", host, "TargetPositionOrDistance"}).out, HasSubstr("= -1234 increment"));
    EXPECT_THAT(run_scanner({"get", host, "SCurve"}).out, HasSubstr("= 70 %"));
    // Idle applies nothing (R-IO-6).
    EXPECT_EQ(run_scanner({"io", host, "--idle", "--set", "SCurve=10", "--duration", "0.1"}).code, 0);
    EXPECT_THAT(run_scanner({"get", host, "SCurve"}).out, HasSubstr("= 70 %"));
}

TEST_F(IoEndToEnd, RefusalsAreExplained) {
    const auto listen = run_scanner({"io", host, "--connection", "listen-only"});
    EXPECT_EQ(listen.code, 4);
    EXPECT_THAT(listen.err, HasSubstr("0x0119"));
    const auto fast = run_scanner({"open", host, "--rpi", "0.5"});
    EXPECT_EQ(fast.code, 4);
    EXPECT_THAT(fast.err, AllOf(HasSubstr("0x0112"), HasSubstr("--rpi 1")));
    const auto size = run_scanner({"open", host, "--o2t", "101", "--o2t-size", "18", "--t2o", "100", "--t2o-size", "32",
                                   "--config-instance", "1"});
    EXPECT_EQ(size.code, 4);
    EXPECT_THAT(size.err, HasSubstr("--connection standard"));
    const auto key = run_scanner({"open", host, "--key", "1/2/3/4.5", "--json"});
    EXPECT_EQ(key.code, 4);
    EXPECT_EQ(json::parse(key.out)["error"]["extended"][0], 0x0114);
}

// Holds UDP 2222 of this machine's first address, or finds that another program does.
class UsualPortInUse {
public:
    UsualPortInUse() : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(2222);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        (void)::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    }
    ~UsualPortInUse() { ::close(socket_); }
    UsualPortInUse(const UsualPortInUse&) = delete;
    UsualPortInUse& operator=(const UsualPortInUse&) = delete;

private:
    int socket_;
};

// The request names the port then (R-CPF-8), and so does the capture.
TEST_F(IoEndToEnd, CapturesOfAnotherPortAreUnderstood) {
    const UsualPortInUse usual_port;
    const auto capture = file(".pcapng");
    EXPECT_EQ(run_scanner({"io", host, "--duration", "0.2", "--pcapng", capture}).code, 0);
    const auto diagnosis = run_scanner({"doctor", capture});
    EXPECT_EQ(diagnosis.code, 0) << diagnosis.out;
    std::filesystem::remove(capture);
}

TEST_F(IoEndToEnd, WritesTablesAndCaptures) {
    const auto table = file(".csv");
    const auto capture = file(".pcapng");
    const auto result = run_scanner({"io", host, "--duration", "0.2", "--csv", table, "--pcapng", capture});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(content(table),
                AllOf(StartsWith("time [s],sequence,fresh,run,Statusword,"), HasSubstr(",1,1,592,0,0,")));
    EXPECT_THAT(run_scanner({"doctor", capture}).code, 0);
    std::filesystem::remove(table);
    std::filesystem::remove(capture);
    const auto out = run_scanner({"io", host, "--duration", "0.1", "--csv", "-"});
    EXPECT_THAT(out.out, AllOf(StartsWith("time [s],"), Not(HasSubstr("granted"))));
    EXPECT_THAT(out.err, HasSubstr("interval, granted 10.000 ms"));
}

TEST_F(IoEndToEnd, CtrlCIsHowItEnds) {
    std::atomic<int> interruptions{0};
    std::jthread presses([&] {
        std::this_thread::sleep_for(300ms);
        interruptions = 1;
    });
    const auto result = run_scanner({"io", host}, {true, &interruptions});
    EXPECT_EQ(result.code, 0);
    EXPECT_THAT(result.err, AllOf(HasSubstr("Statusword"), HasSubstr("Switch on disabled"), EndsWith("A\x1B[J")));
    EXPECT_THAT(result.out, AllOf(HasSubstr("interval, granted 10.000 ms"), Not(HasSubstr("Statusword"))));
}

/// Somebody owns a device as soon as its identity says so.
void wait_for_owner(const std::string& host) {
    for (int i = 0; i < 500 && run_scanner({"identity", host}).out.find("owned") == std::string::npos; ++i) {
        std::this_thread::sleep_for(10ms);
    }
}

TEST_F(IoEndToEnd, OpensAgainAfterALoss) {
    std::atomic<int> interruptions{0};
    test::Run result;
    std::jthread owner([&] { result = run_scanner({"io", host, "--rpi", "5", "--json"}, {false, &interruptions}); });
    wait_for_owner(host);
    crash();
    start();
    wait_for_owner(host);
    interruptions = 1;
    owner.join();
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(result.err, HasSubstr("was lost: no datagram came in time; the next try is in 250 ms"));
    const auto lines = lines_of(result.out);
    const auto count = [&](const char* event) {
        return std::ranges::count_if(lines, [&](const json& line) { return line["event"] == event; });
    };
    EXPECT_EQ(count("opened"), 2);
    const auto& end = lines.back()["statistics"];
    EXPECT_EQ(end["openings"], 2);
    EXPECT_EQ(end["received"], count("input"));
    EXPECT_EQ(end["lost"], 0) << "between two openings nothing is lost";
    // How many it sends in a given time is judged in virtual time (originator_test.cpp): a busy machine skips intervals.
    EXPECT_GE(end["sent"].get<int>(), 2) << "the first of each opening at least";
}

TEST_F(IoEndToEnd, ALossIsTheEndWhenItIsAskedFor) {
    test::Run result;
    std::jthread owner([&] { result = run_scanner({"io", host, "--rpi", "5", "--no-reopen"}); });
    wait_for_owner(host);
    crash();
    owner.join();
    EXPECT_EQ(result.code, 3);
    EXPECT_THAT(result.err, AllOf(HasSubstr("was lost"), Not(HasSubstr("next try"))));
    EXPECT_THAT(result.out, HasSubstr(" s: sent "));
    start();
}

TEST_F(IoEndToEnd, ASecondOwnerIsRefused) {
    std::atomic<int> interruptions{0};
    test::Run first;
    std::jthread owner([&] { first = run_scanner({"io", host}, {false, &interruptions}); });
    wait_for_owner(host);
    const auto second = run_scanner({"open", host});
    EXPECT_EQ(second.code, 4);
    EXPECT_THAT(second.err, AllOf(HasSubstr("0x0106"), Not(HasSubstr("next try"))));
    // Those who look on do not mind.
    EXPECT_EQ(run_scanner({"open", host, "--connection", "input-only"}).code, 0);
    interruptions = 1;
    owner.join();
    EXPECT_EQ(first.code, 0) << first.err;
}

TEST_F(IoEndToEnd, MovesAnAxisOverTheConnection) {
    const auto early = run_scanner({"axis", host, "move", "1000", "--io"});
    EXPECT_EQ(early.code, 6);
    EXPECT_THAT(early.err, HasSubstr("not referenced"));
    EXPECT_EQ(run_scanner({"axis", host, "reference", "--io"}).code, 0);
    const auto table = file(".csv");
    const auto move = run_scanner({"axis", host, "move", "80000", "--io", "--connection", "outputs", "--window", "50",
                                   "--speed", "400000", "--acceleration", "4000000", "--trace", table});
    EXPECT_EQ(move.code, 0) << move.err;
    EXPECT_THAT(move.out, AllOf(StartsWith("Moved to 80000 increments in "),
                                HasSubstr("without the connection the drive is in 'Quick stop active'")));
    EXPECT_THAT(content(table), testing::ContainsRegex(",(79999|80000|80001),0,"));
    std::filesystem::remove(table);
    EXPECT_THAT(run_scanner({"get", host, "TargetPositionWindow"}).out, HasSubstr("= 50 "));
    // Opening leaves a stopped drive stopped.
    EXPECT_EQ(run_scanner({"io", host, "--duration", "0.1"}).code, 0);
    EXPECT_THAT(run_scanner({"axis", host, "status"}).out, HasSubstr("Quick stop active"));
    EXPECT_THAT(run_scanner({"axis", host, "jog", "negative", "--speed", "20000", "--duration", "100ms", "--io"}).out,
                testing::ContainsRegex("^Jogged negative from (79999|8000[01]) to 7"));
    const auto refused = run_scanner({"axis", host, "move", "0", "--io", "--scurve", "500"});
    EXPECT_EQ(refused.code, 4);
    EXPECT_THAT(refused.err, HasSubstr("SCurve: it takes 1 to 100 %"));
}

TEST_F(IoEndToEnd, CtrlCHaltsTheAxisOverTheConnection) {
    EXPECT_EQ(run_scanner({"axis", host, "reference", "--io"}).code, 0);
    EXPECT_EQ(run_scanner({"axis", host, "move", "0", "--io"}).code, 0);
    std::atomic<int> interruptions{0};
    std::jthread presses([&] {
        std::this_thread::sleep_for(500ms);
        interruptions = 1;
    });
    const auto result =
        run_scanner({"axis", host, "move", "100000", "--speed", "20000", "--io"}, {false, &interruptions});
    EXPECT_EQ(result.code, 130) << result.out;
    EXPECT_THAT(result.err, HasSubstr("interrupted; the axis was halted and stands at "));
    EXPECT_THAT(result.out, IsEmpty());
}

}  // namespace
}  // namespace servobus::scanner::cli
