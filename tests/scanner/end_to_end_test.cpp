// The command line and the example against the real adapter, each test with a drive of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "drive/xenax.hpp"
#include "tests/scanner/run_scanner.hpp"
#include "tests/scanner/running_adapter.hpp"
#include "tests/support/places.hpp"

namespace servobus::scanner::cli {
namespace {

using EndToEnd = test::RunningAdapter;
using namespace test;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

TEST_F(EndToEnd, ReadsAndWrites) {
    EXPECT_THAT(run_scanner({"get", host, "SCurve"}).out, StartsWith("SCurve = 20 %"));
    EXPECT_EQ(run_scanner({"set", host, "SCurve=35"}).code, 0);
    for (const std::vector<std::string>& way : {std::vector<std::string>{}, {"--connected"}, {"--route", "1/0"}}) {
        auto arguments = way;
        arguments.insert(arguments.end(), {"get", host, "scrv"});
        const auto result = run_scanner(arguments);
        EXPECT_EQ(result.code, 0) << result.err;
        EXPECT_THAT(result.out, StartsWith("SCurve = 35 %"));
    }
    EXPECT_EQ(run_scanner({"set", host, "SID=axis 1"}).code, 0);
    EXPECT_THAT(run_scanner({"get", host, "SID"}).out, StartsWith("ServoIdentificationString = axis 1 "));
    EXPECT_EQ(run_scanner({"set", host, "@0x64/1/0=DINT:50"}).code, 0);
    EXPECT_EQ(json::parse(run_scanner({"get", host, "SCurve", "--json"}).out)["values"][0]["value"], 50);
}

TEST_F(EndToEnd, TellsRefusals) {
    const auto limits = run_scanner({"set", host, "SCurve=500"});
    EXPECT_EQ(limits.code, 4);
    EXPECT_THAT(limits.err, AllOf(HasSubstr("0x09 invalid attribute value"), HasSubstr("1 to 100 %")));
    const auto access = run_scanner({"set", host, "Statusword=1"});
    EXPECT_EQ(access.code, 4);
    EXPECT_THAT(access.err, AllOf(HasSubstr("0x0E attribute not settable"), HasSubstr("read only")));
    EXPECT_EQ(run_scanner({"get", host, "DirectCommands"}).code, 4);
    EXPECT_EQ(run_scanner({"set", host, "@0x64/1/0=hex:32 00"}).code, 4);
    EXPECT_EQ(run_scanner({"get", host, "0x99/1/1"}).code, 4);
    EXPECT_EQ(run_scanner({"call", host, "0x4D", "1/1"}).code, 4);
}

TEST_F(EndToEnd, IdentifiesAndFinds) {
    for (const auto& arguments : {std::vector<std::string>{"identity", host}, {"discover", "--host", host}}) {
        const auto result = run_scanner(arguments);
        EXPECT_EQ(result.code, 0) << result.err;
        EXPECT_THAT(result.out, AllOf(HasSubstr("Jenny Science AG"), HasSubstr("XENAX Xvi 75V8S")));
    }
    EXPECT_THAT(run_scanner({"get", host, "0x01/1/7"}).out, HasSubstr("product name XENAX Xvi 75V8S"));
}

TEST_F(EndToEnd, DumpsEverything) {
    for (const std::vector<std::string>& way : {std::vector<std::string>{}, {"--connected"}, {"--route", "1/0"}}) {
        auto arguments = way;
        arguments.insert(arguments.end(), {"dump", host, "--json"});
        const auto result = run_scanner(arguments);
        EXPECT_EQ(result.code, 0) << result.err;
        const auto values = json::parse(result.out)["values"];
        ASSERT_EQ(values.size(), drive::parameters().size());
        for (const auto& value : values) {
            if (value["access"] == "set") continue;
            EXPECT_TRUE(value.contains("value")) << value.dump();
        }
    }
}

TEST_F(EndToEnd, GivesCommands) {
    EXPECT_EQ(run_scanner({"command", host, "REF"}).code, 0);
    EXPECT_EQ(run_scanner({"command", host, "REFERENZ"}).code, 2);
}

TEST_F(EndToEnd, MovesAnAxisAndDrawsIt) {
    const auto early = run_scanner({"axis", host, "move", "1000"});
    EXPECT_EQ(early.code, 6);
    EXPECT_THAT(early.err, HasSubstr("call 'reference' first"));
    EXPECT_EQ(run_scanner({"axis", host, "reference"}).code, 0);
    EXPECT_EQ(run_scanner({"axis", host, "move", "0"}).code, 0);
    const auto picture = file(".svg");
    const auto table = file(".csv");
    const auto move = run_scanner({"axis", host, "move", "100000", "--speed", "400000", "--acceleration", "4000000",
                                   "--scurve", "60", "--trace", picture, "--trace", table});
    EXPECT_EQ(move.code, 0) << move.err;
    EXPECT_THAT(move.out, StartsWith("Moved to 100000 increments in 0."));
    std::ifstream svg(picture);
    EXPECT_THAT(std::string(std::istreambuf_iterator<char>(svg), {}),
                AllOf(HasSubstr("<svg"), HasSubstr("acceleration")));
    std::ifstream csv(table);
    EXPECT_GT(std::count(std::istreambuf_iterator<char>(csv), {}, '\n'), 20);
    std::filesystem::remove(picture);
    std::filesystem::remove(table);
    EXPECT_THAT(run_scanner({"axis", host, "move", "-5000", "--relative"}).out, StartsWith("Moved by -5000 to 9"));
    EXPECT_THAT(run_scanner({"axis", host, "status"}).out,
                AllOf(HasSubstr("Operation enabled"), HasSubstr("referenced")));
}

TEST_F(EndToEnd, ABlockedAxisFailsAndComesBackWithoutAReference) {
    EXPECT_EQ(run_scanner({"axis", host, "reference"}).code, 0);
    EXPECT_EQ(control(R"({"event": "block-axis"})"), R"({"ok":true})");
    const auto blocked = run_scanner({"axis", host, "move", "100000"});
    EXPECT_EQ(blocked.code, 6);
    EXPECT_THAT(blocked.err, AllOf(HasSubstr("'Fault' with error 50: Following error"), HasSubstr("fault-reset")));
    EXPECT_EQ(json::parse(control(R"({"query": "state"})"))["error"], 50);
    EXPECT_EQ(control(R"({"event": "release-axis"})"), R"({"ok":true})");
    EXPECT_THAT(run_scanner({"axis", host, "fault-reset"}).out, HasSubstr("it was error 50"));
    EXPECT_EQ(run_scanner({"axis", host, "enable"}).code, 0);
    EXPECT_THAT(run_scanner({"axis", host, "move", "100000"}).out, StartsWith("Moved to 100000"));
}

TEST_F(EndToEnd, RunsTheExample) {
    auto* pipe = popen((servobus::test::program_path("servobus_example_read_attribute ") + host).c_str(), "r");
    std::array<char, 256> line{};
    ASSERT_NE(fgets(line.data(), line.size(), pipe), nullptr);
    EXPECT_STREQ(line.data(), "SCurve = 20 %\n");
    EXPECT_EQ(pclose(pipe), 0);
}

}  // namespace
}  // namespace servobus::scanner::cli
