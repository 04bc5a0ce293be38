// The completion scripts, the bash one at work.
#include "scanner/cli/completion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <sstream>

#include "scanner/cli/run.hpp"
#include "tests/support/places.hpp"

namespace servobus::scanner::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string script(const std::string& shell) {
    std::ostringstream out;
    std::ostringstream err;
    EXPECT_EQ(run({"completion", shell}, out, err), 0) << err.str();
    return out.str();
}

/// What bash offers for the last of these words.
std::string offered(const std::string& words) {
    const auto file = testing::TempDir() + "/servobus_completion_" + std::to_string(getpid()) + ".bash";
    std::ofstream(file) << script("bash") << "compopt() { :; }\n"
                        << "PATH=" << servobus::test::program_path("") << ":$PATH\n"
                        << "COMP_WORDS=(" << words << ")\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n"
                        << "_servobus_scanner\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n";
    std::string text;
    auto* pipe = popen(("bash " + file + " 2>&1").c_str(), "r");
    std::array<char, 256> buffer{};
    while (fgets(buffer.data(), buffer.size(), pipe) != nullptr) text += buffer.data();
    EXPECT_EQ(pclose(pipe), 0) << text;
    std::remove(file.c_str());
    return text;
}

TEST(Completion, KnowsEveryVerbInEveryShell) {
    for (const auto* shell : {"bash", "zsh", "fish"}) {
        const auto text = script(shell);
        EXPECT_THAT(text, Not(testing::ContainsRegex("@[A-Z]"))) << "a mark that was not filled in";
        for (const auto* word :
             {"discover", "identity", "get",   "set",       "dump",       "command", "call",
              "axis",     "io",       "open",  "list",      "completion", "upload",  "force-calibrate",
              "json",     "timeout",  "route", "connected", "wait",       "host",    "list --names"}) {
            EXPECT_THAT(text, HasSubstr(word)) << shell;
        }
    }
    EXPECT_EQ(completion_script("tcsh", {}), std::nullopt);
}

TEST(Completion, WorksInBash) {
    EXPECT_EQ(offered("servobus-scanner di"), "discover\n");
    EXPECT_EQ(offered("servobus-scanner get host SCur"), "SCurve\nSCurveProfile\n");
    EXPECT_EQ(offered("servobus-scanner get host drive.Controlw"), "drive.Controlword\n");
    EXPECT_EQ(offered("servobus-scanner set host Controlw"), "Controlword=\n");
    EXPECT_EQ(offered("servobus-scanner command host RE"), "REF\nRES\nRESM\n");
    EXPECT_EQ(offered("servobus-scanner get host --jso"), "--json\n");
    EXPECT_EQ(offered("servobus-scanner --json get host --tim"), "--timeout\n");
    EXPECT_EQ(offered("servobus-scanner completion z"), "zsh\n");
    EXPECT_EQ(offered("servobus-scanner axis host f"), "fault-reset\nforce-calibrate\n");
    EXPECT_EQ(offered("servobus-scanner axis host jog n"), "negative\n");
    EXPECT_EQ(offered("servobus-scanner axis host move --rel"), "--relative\n");
    EXPECT_EQ(offered("servobus-scanner axis host trace --dur"), "--duration\n");
    EXPECT_EQ(offered("servobus-scanner axis host trace --duration 2s m"), "move\n");
    EXPECT_EQ(offered("servobus-scanner io host --connection i"), "iforce\ninput-only\n");
    EXPECT_EQ(offered("servobus-scanner axis host move --connection ou"), "outputs\n");
    EXPECT_EQ(offered("servobus-scanner io host --pcap"), "--pcapng\n");
    EXPECT_EQ(offered("servobus-scanner open host --o2t-f"), "--o2t-format\n");
    EXPECT_EQ(offered("servobus-scanner eds ch"), "check\n");
    const auto file = testing::TempDir() + "servobus-completion.eds";
    std::ofstream(file) << "[File]";
    const auto beginning = file.substr(0, file.size() - 5);
    EXPECT_EQ(offered("servobus-scanner eds lint " + beginning), file + "\n");
    EXPECT_EQ(offered("servobus-scanner eds check host " + beginning), file + "\n");
    EXPECT_EQ(offered("servobus-scanner get host --eds " + beginning), file + "\n");
    std::remove(file.c_str());
    EXPECT_EQ(offered("servobus-scanner eds upload host --fo"), "--force\n");
}

}  // namespace
}  // namespace servobus::scanner::cli
