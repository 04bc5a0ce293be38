// The command line and the example against the real adapter, each test with a drive of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>

#include "drive/xenax.hpp"
#include "tests/scanner/run_scanner.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace std::chrono_literals;
using namespace test;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class EndToEnd : public testing::Test {
protected:
    void SetUp() override {
        const auto adapter = std::string(SERVOBUS_BIN_DIR) + "/servobus-adapter";
        // A loopback address that no other test has.
        const auto number = static_cast<unsigned>(getpid()) & 0xFFFFU;
        host = "127.88." + std::to_string(number >> 8) + "." + std::to_string(number & 0xFF);
        std::vector<std::string> words{adapter, "--bind", host, "--port", "44818", "--log-level", "error"};
        std::vector<char*> argv;
        for (auto& word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", 1, 0);
        ASSERT_EQ(posix_spawn(&adapter_, adapter.c_str(), &actions, nullptr, argv.data(), environ), 0);
        posix_spawn_file_actions_destroy(&actions);
        for (int i = 0; i < 200; ++i) {
            if (run_scanner({"call", host, "0x0E", "1/1/1"}).code == 0) return;
            std::this_thread::sleep_for(50ms);
        }
        FAIL() << "the adapter does not answer";
    }

    void TearDown() override {
        if (adapter_ <= 0) return;
        kill(adapter_, SIGTERM);
        int status = 0;
        waitpid(adapter_, &status, 0);
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    }

    std::string host;

private:
    pid_t adapter_ = 0;
};

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

TEST_F(EndToEnd, RunsTheExample) {
    auto* pipe = popen((std::string(SERVOBUS_BIN_DIR) + "/servobus_example_read_attribute " + host).c_str(), "r");
    std::array<char, 256> line{};
    ASSERT_NE(fgets(line.data(), line.size(), pipe), nullptr);
    EXPECT_STREQ(line.data(), "SCurve = 20 %\n");
    EXPECT_EQ(pclose(pipe), 0);
}

}  // namespace
}  // namespace servobus::scanner::cli
