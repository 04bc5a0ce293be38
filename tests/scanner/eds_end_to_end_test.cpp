// Data sheets against the real adapter: that it is what its sheet says, and that what differs is found.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "drive/xenax.hpp"
#include "eds/data_sheet.hpp"
#include "eds/generate.hpp"
#include "tests/scanner/run_scanner.hpp"
#include "tests/scanner/running_adapter.hpp"
#include "tests/scanner/sample_sheet.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace test;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

std::string text_of(std::string_view variant) { return eds::generate(*drive::xenax_model(variant)); }

/// The text with the first `from` behind `mark` changed.
std::string altered_behind(std::string text, std::string_view mark, std::string_view from, std::string_view to) {
    const auto begin = text.find(mark);
    EXPECT_NE(begin, std::string::npos) << mark;
    const auto at = text.find(from, begin);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

/// What `eds check` finds, and its counts.
struct Checked {
    int code = 0;
    json document;

    [[nodiscard]] int count(const std::string& group, const std::string& what) const {
        return document["groups"][group][what];
    }
    /// The words about a subject; empty when it is equal.
    [[nodiscard]] std::string about(const std::string& subject) const {
        for (const auto& finding : document["findings"]) {
            if (finding["subject"] == subject)
                return finding["agreement"].get<std::string>() + ": " + finding["text"].get<std::string>();
        }
        return {};
    }
};

class EdsEndToEnd : public RunningAdapter {
protected:
    Checked check(const std::string& text, const std::vector<std::string>& more = {}) {
        const SheetFile file(text);
        std::vector<std::string> words{"eds", "check", host, file.path(), "--json"};
        words.insert(words.end(), more.begin(), more.end());
        const auto result = run_scanner(words);
        return {result.code, json::parse(result.out)};
    }
};

TEST_F(EdsEndToEnd, EachVariantIsWhatItsSheetSays) {
    for (const auto& model : drive::xenax_models()) {
        stop();
        options = {"--variant", std::string(model.key)};
        start();
        const auto text = text_of(model.key);
        const auto sheet = sheet_of(text);
        const auto checked = check(text, {"--open"});
        EXPECT_EQ(checked.code, 0) << model.key << checked.document["findings"];
        EXPECT_EQ(checked.document["counts"]["different"], 0);
        EXPECT_EQ(checked.count("identity", "equal"), 5);
        const auto addressed =
            std::ranges::count_if(sheet.parameters, [](const auto& each) { return each.address().has_value(); });
        EXPECT_EQ(checked.count("parameter", "checked"), addressed);
        EXPECT_GT(checked.count("parameter", "equal"), 9 * addressed / 10)
            << "what can only be written is not compared";
        EXPECT_EQ(checked.count("assembly", "equal"), static_cast<int>(sheet.assemblies.size()));
        EXPECT_EQ(checked.count("connection", "equal"), 2 * static_cast<int>(sheet.connections.size()))
            << "compared, and opened";
        EXPECT_EQ(checked.count("file", "equal"), 1);
    }
}

// Alone it is refused with 0x0119; beside another connection that sends to a group it opens.
TEST_F(EdsEndToEnd, ListenOnlyIsOpenedBesideAnother) {
    const auto text =
        altered_behind(text_of("75v8s"), "[Connection Manager]", "        Connection1 =",
                       "        Connection7 = 0x01010002, 0x44240305, Param251,0,, Param251,28,Assem100, ,, "
                       ",, \"Listen only\", \"\", \"20 04 24 01 2C FF 2C 64\";\n        Connection1 =");
    const auto checked = check(text, {"--open"});
    EXPECT_EQ(checked.about("Connection7 Listen only"), "");
    EXPECT_EQ(checked.about("Connection7 Listen only, opened"), "");
    EXPECT_EQ(checked.count("connection", "equal"), 14);
    const SheetFile sheet(text);
    const auto alone = run_scanner({"open", host, "--eds", sheet.path(), "listen"});
    EXPECT_EQ(alone.code, 4);
    EXPECT_THAT(alone.err, HasSubstr("0x0119"));
}

TEST_F(EdsEndToEnd, TheUploadedSheetIsTheDevices) {
    const auto path = file(".uploaded.eds");
    EXPECT_EQ(run_scanner({"eds", "upload", host, "-o", path, "--force"}).code, 0);
    EXPECT_EQ(run_scanner({"eds", "lint", path}).code, 0);
    const auto result = run_scanner({"eds", "check", host, path});
    EXPECT_EQ(result.code, 0) << result.out << result.err;
    EXPECT_THAT(result.out, AllOf(HasSubstr(" checked: 5 of the identity, "), HasSubstr(" 0 different, ")));
    std::filesystem::remove(path);
    const auto icon = run_scanner({"eds", "upload", host, "--icon", "-o", "-"});
    EXPECT_EQ(icon.out.size(), 766U);
}

TEST_F(EdsEndToEnd, AnotherVariantsSheetIsFound) {
    const auto checked = check(text_of("48v8"));
    EXPECT_EQ(checked.code, 4);
    EXPECT_THAT(checked.about("product code"),
                StartsWith("different: the device says 29961 (XENAX Xvi 75V8S), the file 18440: "));
    EXPECT_THAT(checked.about("product name"), HasSubstr("the file 'XENAX Xvi 48V8'"));
    EXPECT_THAT(checked.about("the file in the device (class 0x37)"), HasSubstr("different from line 1 on"));
    EXPECT_EQ(checked.count("identity", "different"), 2);
    stop();
    options = {"--variant", "48v8"};
    start();
    const auto other = check(text_of("75v8s"));
    EXPECT_EQ(other.code, 4);
    EXPECT_GT(other.document["counts"]["not_compared"], 20) << "the rows that only the 75V8S has";
}

TEST_F(EdsEndToEnd, AlteredLimitsTypesAndSizesAreFound) {
    const auto text = text_of("75v8s");
    const auto limit = check(altered_behind(text, "\"SCurve\"", "1,100,20,", "30,100,30,"));
    EXPECT_EQ(limit.code, 4);
    EXPECT_EQ(limit.about("Param1 SCurve"),
              "different: its value 20 in the device is outside the limits of the file, 30 to 100 %");
    EXPECT_EQ(limit.count("parameter", "different"), 1);
    const auto type = check(altered_behind(text, "Param1 ", "0xC4,4,", "0xC3,2,"));
    EXPECT_EQ(type.code, 4);
    EXPECT_EQ(type.about("Param1 SCurve"), "different: 4 octets in the device, 2 octets by the INT of the file");
    const auto attribute = check(altered_behind(text, "Param1 ", "\"20 64 24 01 30 00\"", "\"20 64 24 01 30 FE\""));
    EXPECT_EQ(attribute.code, 4);
    EXPECT_THAT(attribute.about("Param1 SCurve"), StartsWith("different: the device does not have it: 0x14"));
    const auto assembly = check(altered_behind(text, "Assem100", "28,", "27,"));
    EXPECT_EQ(assembly.about("Assem100 Standard input"), "different: 28 octets in the device, 27 octets in the file");
    const auto connection = check(altered_behind(text, "Connection1 ", "Param251,18,", "Param251,16,"), {"--open"});
    EXPECT_EQ(connection.code, 4);
    EXPECT_EQ(connection.about("Connection1 Standard"),
              "different: O->T: assembly 101 has 18 octets in the device, 16 octets in the file");
    EXPECT_THAT(connection.about("Connection1 Standard, opened"), HasSubstr("0x0127"));
    EXPECT_EQ(connection.about("Connection2 I Force, opened"), "");
}

TEST_F(EdsEndToEnd, TextSaysWhatDiffers) {
    const SheetFile sheet(altered_behind(text_of("75v8s"), "\"SCurve\"", "1,100,20,", "30,100,30,"));
    const auto result = run_scanner({"eds", "check", host, sheet.path()});
    EXPECT_EQ(result.code, 4);
    EXPECT_THAT(result.out, HasSubstr("DIFFERENT  Param1 SCurve: its value 20 in the device is outside the limits"));
    EXPECT_THAT(result.err, HasSubstr("is not what " + sheet.path() + " says: 2 of "));
    EXPECT_EQ(run_scanner({"eds", "check", host, "no-such.eds"}).code, 2);
    EXPECT_EQ(run_scanner({"eds", "check", "127.0.0.1:1", sheet.path()}).code, 3);
}

TEST_F(EdsEndToEnd, ParametersByTheNamesOfTheSheet) {
    const SheetFile sheet(text_of("75v8s"));
    const auto set = run_scanner({"set", host, "--eds", sheet.path(), "SCurve", "35"});
    EXPECT_EQ(set.code, 0) << set.err;
    EXPECT_EQ(run_scanner({"get", host, "--eds", sheet.path(), "scurve"}).out,
              "SCurve = 35 %  (CIP 0x64/1/0x00, Param1)\n");
    EXPECT_EQ(run_scanner({"set", host, "--eds", sheet.path(), "SCurve=101"}).code, 2);
    EXPECT_EQ(run_scanner({"set", host, "--eds", sheet.path(), "SCurve=101", "--force"}).code, 4);
}

std::vector<json> lines_of(const std::string& text) {
    std::vector<json> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(json::parse(line));
    return lines;
}

TEST_F(EdsEndToEnd, ConnectionsFromTheSheet) {
    const SheetFile sheet(text_of("75v8s"));
    EXPECT_EQ(run_scanner({"set", host, "SCurve=70"}).code, 0);
    const auto result = run_scanner({"io", host, "--eds", sheet.path(), "standard", "--rpi", "5", "--set",
                                     "TargetPositionOrDistance=-1234", "--duration", "0.2", "--json"});
    EXPECT_EQ(result.code, 0) << result.err;
    const auto lines = lines_of(result.out);
    ASSERT_GE(lines.size(), 3U);
    EXPECT_EQ(lines[0]["o_to_t"]["point"], 101);
    EXPECT_EQ(lines[0]["o_to_t"]["interval_us"], 5000);
    EXPECT_EQ(lines[1]["values"]["Statusword"], 0x0250);
    EXPECT_THAT(run_scanner({"get", host, "TargetPositionOrDistance"}).out, HasSubstr("= -1234 increment"));
    EXPECT_THAT(run_scanner({"get", host, "SCurve"}).out, HasSubstr("= 70 %"))
        << "the outputs begin as the device has them";
    const auto which = run_scanner({"io", host, "--eds", sheet.path()});
    EXPECT_EQ(which.code, 2);
    EXPECT_THAT(which.err, HasSubstr("write which: 'Standard' (Connection1), 'I Force' (Connection2)"));
    const auto fast = run_scanner({"io", host, "--eds", sheet.path(), "Standard", "--rpi", "0.5"});
    EXPECT_EQ(fast.code, 2);
    EXPECT_THAT(fast.err, HasSubstr("an interval of 0.5 ms; the file allows 1 ms to 3200 ms"));
    const auto open = run_scanner({"open", host, "--eds", sheet.path(), "--connection", "I Force", "--key", "eds"});
    EXPECT_EQ(open.code, 0) << open.err;
    EXPECT_THAT(open.out, HasSubstr("point 102: 20 octets (I Force output)"));
}

// A drive in Quick stop active would start again with the word that it was enabled with.
TEST_F(EdsEndToEnd, OpeningLeavesAStoppedDriveStopped) {
    const SheetFile sheet(text_of("75v8s"));
    EXPECT_EQ(run_scanner({"axis", host, "reference", "--io"}).code, 0);
    EXPECT_THAT(run_scanner({"axis", host, "status"}).out, HasSubstr("Quick stop active"));
    EXPECT_THAT(run_scanner({"get", host, "drive.Controlword"}).out, HasSubstr("0x000F")) << "it would start again";
    const auto result = run_scanner({"io", host, "--eds", sheet.path(), "Standard", "--duration", "0.3", "--json"});
    EXPECT_EQ(result.code, 0) << result.err;
    int inputs = 0;
    for (const auto& line : lines_of(result.out)) {
        if (line["event"] != "input") continue;
        ++inputs;
        EXPECT_EQ(line["values"]["Statusword"].get<int>() & 0x6F, 0x07) << "Quick stop active (004 §4.2.3)";
    }
    EXPECT_GT(inputs, 10);
}

}  // namespace
}  // namespace servobus::scanner::cli
