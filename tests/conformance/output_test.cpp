// What the conformance verb prints and writes, for people and for programs; what it refuses; its page.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "scanner/conformance/case.hpp"
#include "tests/conformance/bad_target.hpp"
#include "tests/scanner/run_scanner.hpp"
#include "tests/support/places.hpp"

namespace servobus::scanner::test {
namespace {

using servobus::test::BadServer;
using servobus::test::Vice;
using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;

Vice zeroes_the_context() {
    Vice vice;
    vice.on_reply = [](const enip::Frame&, enip::Frame& reply) { reply.context = {}; };
    return vice;
}

std::string temporary(const std::string& name) {
    return (std::filesystem::temp_directory_path() / ("servobus-conformance-" + std::to_string(getpid()) + name))
        .string();
}

std::string read_file(const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::string output_of(const std::string& command) {
    std::string text;
    auto* pipe = popen(command.c_str(), "r");
    std::array<char, 256> buffer{};
    while (fgets(buffer.data(), buffer.size(), pipe) != nullptr) text += buffer.data();
    EXPECT_EQ(pclose(pipe), 0) << command << '\n' << text;
    return text;
}

TEST(Cases, HaveIdsOfTheirOwn) {
    std::set<std::string_view> ids;
    for (const auto& each : conformance::all_cases()) {
        EXPECT_TRUE(ids.insert(each.id).second) << each.id << " is there twice";
        EXPECT_FALSE(each.title.empty()) << each.id;
        EXPECT_TRUE(each.rule.starts_with("R-")) << each.id;
        EXPECT_TRUE(each.words.ends_with('.')) << each.id;
        EXPECT_NE(each.run, nullptr) << each.id;
    }
    EXPECT_GE(ids.size(), 400U);
}

TEST(Cases, StandInTheOrderOfTheGroups) {
    auto group = conformance::Group::encapsulation;
    for (const auto& each : conformance::all_cases()) {
        EXPECT_GE(each.group, group) << each.id;
        group = each.group;
    }
    for (std::size_t i = 0; i < conformance::groups.size(); ++i) {
        EXPECT_EQ(static_cast<std::size_t>(conformance::groups[i].group), i);
    }
}

TEST(Output, TellsPeopleWhatFailed) {
    const BadServer server(zeroes_the_context());
    const auto run =
        run_scanner({"conformance", server.host(), "--case", "enc-08", "--case", "TCP-17", "--case", "UCM-02"});
    EXPECT_EQ(run.code, 4);
    EXPECT_THAT(run.out, HasSubstr("XENAX"));
    EXPECT_THAT(run.out, HasSubstr("read-only"));
    EXPECT_THAT(run.out, HasSubstr("FAIL      ENC-08  The sender context comes back unchanged\n"
                                   "            R-ENC-9: A reply copies the eight octets of the sender context.\n"
                                   "            - the sender context comes back changed\n"
                                   "            sent  ListServices, 0 octets of data\n"));
    EXPECT_THAT(run.out, HasSubstr("skipped   TCP-17  The status cannot be written: needs --allow-writes\n"));
    EXPECT_THAT(run.out, HasSubstr("3 cases in "));
    EXPECT_THAT(run.err, HasSubstr("fails 2 of 3 cases"));
}

TEST(Output, IsShortOfWhatPasses) {
    const BadServer server(Vice{});
    const auto brief = run_scanner({"conformance", server.host(), "--case", "UCM-01"});
    EXPECT_EQ(brief.code, 0);
    EXPECT_THAT(brief.out, HasSubstr("  pass      UCM-01  "));
    EXPECT_THAT(brief.out, Not(HasSubstr("sent")));
    const auto verbose = run_scanner({"conformance", server.host(), "--case", "UCM-01", "--verbose"});
    EXPECT_THAT(verbose.out,
                HasSubstr("sent  SendRRData: Get_Attribute_Single to class 0x01, instance 0x01, attribute 0x01\n"));
    EXPECT_THAT(verbose.out, HasSubstr("came  SendRRData: reply to service 0x0E: success, 2 octets of data\n"));
}

/// Judged by a parser of XML that is not ours.
TEST(Output, IsJUnit) {
    const BadServer server(zeroes_the_context());
    const auto file = temporary(".xml");
    const auto run = run_scanner({"conformance", server.host(), "--case", "ENC-08", "--case", "TCP-17", "--case",
                                  "MAL-55", "--group", "inactivity", "--junit", file});
    EXPECT_EQ(run.code, 4) << run.err;
    const auto judge = temporary(".py");
    std::ofstream(judge)
        << "import sys, xml.etree.ElementTree as tree\n"
           "suites = tree.parse(sys.argv[1]).getroot()\n"
           "assert suites.tag == 'testsuites', suites.tag\n"
           "cases = suites.findall('testsuite/testcase')\n"
           "assert int(suites.get('tests')) == len(cases) == 8, len(cases)\n"
           "assert int(suites.get('failures')) == len(suites.findall('testsuite/testcase/failure'))\n"
           "assert int(suites.get('skipped')) == len(suites.findall('testsuite/testcase/skipped')) == 6\n"
           "for suite in suites:\n"
           "    assert int(suite.get('tests')) == len(suite.findall('testcase')), suite.get('name')\n"
           "    for key in ('failures', 'errors', 'skipped', 'time', 'hostname'): suite.attrib[key]\n"
           "failure = next(c for c in cases if c.get('name').startswith('ENC-08 ')).find('failure')\n"
           "print(failure.get('type'), '|', failure.get('message'))\n"
           "assert 'sent  ListServices' in failure.text\n";
    EXPECT_EQ(output_of("python3 -B " + judge + " " + file + " 2>&1"),
              "R-ENC-9 | the sender context comes back changed\n");
    EXPECT_THAT(read_file(file), testing::StartsWith("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"));
    std::filesystem::remove(file);
    std::filesystem::remove(judge);
}

/// A product name with all that XML takes for itself.
TEST(Output, IsEscaped) {
    Vice vice = servobus::test::altering(0x01, 0x0E, [](cip::Response& reply) {
        const std::string name = "<&\"'>\x01\x7F\xC3\x28";
        reply.data.assign(name.begin(), name.end());
        reply.data.insert(reply.data.begin(), static_cast<std::uint8_t>(name.size()));
    });
    const BadServer server(vice);
    const auto run =
        run_scanner({"conformance", server.host(), "--case", "IDE-07", "--case", "IDE-09", "--junit", "-"});
    EXPECT_EQ(run.code, 4);
    const auto file = temporary(".escaped.xml");
    std::ofstream(file, std::ios::binary) << run.out;
    EXPECT_EQ(output_of("python3 -B -c 'import sys, xml.etree.ElementTree as t; "
                        "print(len(t.parse(sys.argv[1]).getroot().findall(\".//failure\")))' " +
                        file),
              "2\n");
    std::filesystem::remove(file);
}

TEST(Output, IsJson) {
    const BadServer server(zeroes_the_context());
    const auto file = temporary(".json");
    const auto run =
        run_scanner({"conformance", server.host(), "--case", "ENC-08", "--case", "INA-01", "--json", file});
    EXPECT_EQ(run.code, 4);
    EXPECT_THAT(run.out, HasSubstr("FAIL")) << "people still read something";
    const auto document = Json::parse(read_file(file), nullptr, false);
    ASSERT_FALSE(document.is_discarded());
    EXPECT_EQ(document["host"], server.host());
    EXPECT_EQ(document["identity"]["vendor"], 1389);
    EXPECT_EQ(document["writes"], false);
    EXPECT_EQ(document["counts"], Json({{"cases", 2}, {"pass", 0}, {"advisory", 0}, {"fail", 1}, {"skipped", 1}}));
    const auto& result = document["results"][0];
    EXPECT_EQ(result["group"], "encapsulation");
    EXPECT_EQ(result["rule"], "R-ENC-9");
    EXPECT_EQ(result["findings"][0]["failure"], true);
    EXPECT_EQ(result["exchange"][0]["kind"], "sent");
    EXPECT_EQ(result["exchange"][0]["octets"], 24);
    EXPECT_EQ(result["exchange"][0]["hex"], "04 00 00 00 00 00 00 00 00 00 00 00 FF 00 5A A5 01 FE 80 7F 00 00 00 00");
    EXPECT_EQ(document["results"][1]["reason"], "needs --allow-writes");
    std::filesystem::remove(file);
}

TEST(Output, OfInterruption) {
    const BadServer server(Vice{});
    const std::atomic<int> interruptions{1};
    const auto run =
        run_scanner({"conformance", server.host(), "--group", "sessions"}, {.interruptions = &interruptions});
    EXPECT_EQ(run.code, 130);
    EXPECT_THAT(run.out, HasSubstr("19 skipped"));
}

TEST(Usage, IsChecked) {
    const auto mistake = [](std::vector<std::string> words) {
        words.insert(words.begin(), "conformance");
        const auto run = run_scanner(words);
        EXPECT_EQ(run.code, 2) << run.out;
        return run.err;
    };
    EXPECT_THAT(mistake({}), HasSubstr("HOST is missing"));
    EXPECT_THAT(mistake({"127.0.0.1", "--group", "nonsense"}), HasSubstr("'nonsense' is no group"));
    EXPECT_THAT(mistake({"127.0.0.1", "--case", "ENC-999"}), HasSubstr("'ENC-999' is no case"));
    EXPECT_THAT(mistake({"127.0.0.1", "--junit", "-", "--json", "-"}), HasSubstr("cannot both go to standard output"));
    EXPECT_THAT(mistake({"127.0.0.1", "--junit", "/nowhere/at/all.xml"}), HasSubstr("cannot be written"));
    EXPECT_THAT(mistake({"127.0.0.1", "--eds", "/nowhere/at/all.eds"}), HasSubstr("/nowhere/at/all.eds"));
    EXPECT_THAT(mistake({"127.0.0.1", "--t2o", "100"}), HasSubstr("go with --o2t"));
    EXPECT_THAT(mistake({"127.0.0.1", "--connection", "nonsense"}), HasSubstr("'nonsense' is none of"));
}

TEST(Usage, NobodyThere) {
    const auto run = run_scanner({"conformance", "127.0.0.1:1", "--timeout", "1"});
    EXPECT_EQ(run.code, 3);
    EXPECT_THAT(run.err, HasSubstr("no TCP connection"));
}

TEST(List, NamesEveryCase) {
    const auto run = run_scanner({"conformance", "--list"});
    EXPECT_EQ(run.code, 0);
    for (const auto& each : conformance::all_cases()) EXPECT_THAT(run.out, HasSubstr(std::string(each.id)));
    EXPECT_THAT(run.out, HasSubstr("  OWN-06  writes  R-CON-30  A second owner is refused\n"));
    const auto document = Json::parse(run_scanner({"conformance", "--list", "--group", "keys", "--json", "-"}).out);
    EXPECT_EQ(document["cases"][0]["id"], "KEY-01");
}

/// The page has the list as the program prints it; `scripts/write-docs` puts it there.
TEST(Page, HasTheListOfCases) {
    const auto path = servobus::test::data_path("../docs/conformance.md");
    const auto page = read_file(path);
    const std::string begin = "<!-- cases -->\n```\n";
    const std::string end = "```\n<!-- end of cases -->\n";
    const auto from = page.find(begin);
    const auto to = page.find(end);
    ASSERT_NE(from, std::string::npos);
    ASSERT_NE(to, std::string::npos);
    const auto list = run_scanner({"conformance", "--list"}).out;
    if (std::getenv("SERVOBUS_WRITE_DOCS") != nullptr) {
        std::ofstream(path, std::ios::binary) << page.substr(0, from + begin.size()) << list << page.substr(to);
        return;
    }
    EXPECT_EQ(page.substr(from + begin.size(), to - from - begin.size()), list) << "scripts/write-docs mends it";
}

}  // namespace
}  // namespace servobus::scanner::test
