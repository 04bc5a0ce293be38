// `reset` against the real adapter, with a directory that keeps its state.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/scanner/run_scanner.hpp"
#include "tests/scanner/running_adapter.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace test;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class ResetEndToEnd : public RunningAdapter {
protected:
    ResetEndToEnd() { options = {"--state", file(".state"), "--serial", "4711"}; }
    ~ResetEndToEnd() override { std::filesystem::remove_all(file(".state")); }

    void configure() {
        EXPECT_EQ(run_scanner({"set", host, "SCurve=35", "@0xF5/1/13=UINT:60"}).code, 0);
        EXPECT_EQ(get("SCurve"), 35);
    }
    std::int64_t get(const std::string& what) const {
        const auto document = json::parse(run_scanner({"get", host, what, "--json"}).out);
        return document["values"][0].value("value", std::int64_t{-1});
    }
    std::string octets(const std::string& path) const { return run_scanner({"call", host, "0x0E", path}).out; }
    void expect(std::int64_t s_curve, const std::string& inactivity) const {
        EXPECT_EQ(get("SCurve"), s_curve);
        EXPECT_THAT(octets("0xF5/1/13"), HasSubstr(inactivity));
    }
};

TEST_F(ResetEndToEnd, ARestartKeepsWhatIsStored) {
    configure();
    const auto result = run_scanner({"reset", host, "--yes"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(result.out, AllOf(StartsWith("XENAX Xvi 75V8S is back after "), HasSubstr("serial number 0x00001267"),
                                  HasSubstr("configured")));
    expect(35, "3C 00");
}

TEST_F(ResetEndToEnd, FactoryDefaultsAreThereAlsoInTheNextProcess) {
    configure();
    std::istringstream person("y\n");
    const auto result = run_scanner({"reset", host, "--factory"}, {.person = &person});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(result.err, HasSubstr("serial number 0x00001267, at " + host));
    expect(20, "78 00");
    crash();
    start();
    expect(20, "78 00");
}

TEST_F(ResetEndToEnd, TheNetworkCanBeKept) {
    configure();
    EXPECT_EQ(run_scanner({"reset", host, "--factory-keep-network", "--yes"}).code, 0);
    expect(20, "3C 00");
}

TEST_F(ResetEndToEnd, WhatIsSetIsThereInTheNextProcess) {
    configure();
    crash();
    start();
    expect(35, "3C 00");
    stop();
    start();
    expect(35, "3C 00");
}

TEST_F(ResetEndToEnd, NobodyIsThere) {
    const auto result = run_scanner({"reset", "127.88.0.0:1", "--yes"});
    EXPECT_EQ(result.code, 3);
}

}  // namespace
}  // namespace servobus::scanner::cli
