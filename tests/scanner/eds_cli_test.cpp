// Data sheets on the command line: lint, show, list, get, set and io with the parameters of an unknown device.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mutex>
#include <nlohmann/json.hpp>

#include "cip/hex.hpp"
#include "drive/xenax.hpp"
#include "eds/generate.hpp"
#include "scanner/cli/io_options.hpp"
#include "scanner/cli/io_output.hpp"
#include "tests/scanner/fake_server.hpp"
#include "tests/scanner/run_scanner.hpp"
#include "tests/scanner/sample_sheet.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace std::chrono_literals;
using namespace test;
using cip::GeneralStatus;
using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

// ---------------------------------------------------------------------------------------------------------------- lint

TEST(EdsLint, FindsNothingInOurOwn) {
    const SheetFile file(eds::generate(drive::xenax_models().front()));
    const auto result = run_scanner({"eds", "lint", file.path()});
    EXPECT_EQ(result.code, 0) << result.out;
    EXPECT_EQ(result.out, file.path() + ": nothing found\n");
}

TEST(EdsLint, NamesTheLine) {
    const SheetFile file(altered(std::string(valve_text), "0xC3,2, \"Set Point\"", "0xC3,4, \"Set Point\""));
    const auto result = run_scanner({"eds", "lint", file.path()});
    EXPECT_EQ(result.code, 4);
    EXPECT_THAT(result.out, AllOf(HasSubstr(file.path() + ":10: error: Param1: "), HasSubstr("1 error, ")));
    const auto document = json::parse(run_scanner({"eds", "lint", file.path(), "--json"}).out);
    EXPECT_EQ(document["errors"], 1);
    const auto& findings = document["findings"];
    EXPECT_TRUE(std::ranges::any_of(findings, [](const json& each) {
        return each["line"] == 10 && each["severity"] == "error";
    })) << findings;
}

TEST(EdsLint, OfWhatIsNoSheet) {
    EXPECT_EQ(run_scanner({"eds", "lint", "no-such.eds"}).code, 2);
    EXPECT_EQ(run_scanner({"eds", "lint", "/"}).code, 2);
    EXPECT_EQ(run_scanner({"eds", "lint"}).code, 2);
    const SheetFile file("this is no data sheet");
    EXPECT_EQ(run_scanner({"eds", "lint", file.path()}).code, 4);
    EXPECT_EQ(run_scanner({"eds", "show", "no-such.eds", "--json"}).code, 2);
}

// ------------------------------------------------------------------------------------------------------- show and list

TEST(EdsShow, PrintsTables) {
    const SheetFile file;
    const auto result = run_scanner({"eds", "show", file.path()});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(result.out,
                StartsWith("Valve 5\nvendor 77 Acme, device type 43 Generic Device (keyable), product code 5, "
                           "revision 2.3, file revision 1.2\n"));
    EXPECT_THAT(result.out, testing::ContainsRegex("1 +Set Point +INT +bar +-10.0 to 100.0 bar +25.0 +0x70/1/0x01"));
    EXPECT_THAT(result.out, testing::ContainsRegex("Assem100 +Inputs +100 +8"));
    EXPECT_THAT(result.out, testing::ContainsRegex(" 2.1 +Closed +1"));
    EXPECT_THAT(result.out, testing::ContainsRegex(
                                "Connection1 +Exclusive Owner +exclusive owner +150 +4 octets, 32-bit run/idle header +"
                                "2 to 100 ms +100 +8 octets, modeless +2 to 100 ms"));
    const auto document = json::parse(run_scanner({"eds", "show", file.path(), "--json"}).out);
    EXPECT_EQ(document["device"]["vendor"], 77);
    EXPECT_EQ(document["parameters"][0]["low"], -10.0);
    EXPECT_EQ(document["parameters"][1]["names"][2]["text"], "Auto matic");
    EXPECT_EQ(document["assemblies"][0]["members"][2]["first_bit"], 17);
    EXPECT_EQ(document["connections"][0]["o_to_t"]["rpi_low_us"], 2000);
    EXPECT_EQ(document["connections"][1]["o_to_t"]["format"], "heartbeat");
}

TEST(SheetList, PrintsTheParametersOfTheFile) {
    const SheetFile file;
    const auto all = run_scanner({"list", "--eds", file.path()});
    EXPECT_EQ(all.code, 0) << all.err;
    EXPECT_THAT(all.out,
                testing::ContainsRegex("Mode +Param2 +USINT +get/set +Off \\(0\\), On \\(1\\), Auto matic \\(2\\) "
                                       "+1 \\(On\\) +0x70/1/0x02"));
    EXPECT_THAT(all.out, testing::ContainsRegex("RPI +Param6 +UDINT +us +connection"));
    EXPECT_THAT(run_scanner({"list", "--eds", file.path(), "set*"}).out,
                AllOf(HasSubstr("Set Point"), Not(HasSubstr("Mode"))));
    EXPECT_EQ(run_scanner({"list", "--eds", file.path(), "--names"}).out,
              "Cycles\nFlow\nMode\nSet Point\nStatus\nTag\n");
    EXPECT_EQ(run_scanner({"list", "--eds", file.path(), "nothing"}).code, 2);
    EXPECT_EQ(run_scanner({"list", "--eds", file.path(), "--commands"}).code, 2);
    EXPECT_EQ(json::parse(run_scanner({"list", "--eds", file.path(), "flow", "--json"}).out)["parameters"][0]["param"],
              4);
}

// --------------------------------------------------------------------------------------------------------- get and set

/// A valve that keeps what is written to it.
class Valve {
public:
    Valve() {
        values_ = {{1, hex("FA 00")},       {2, hex("02")},          {3, hex("37 06")},
                   {4, hex("00 00 20 40")}, {5, hex("03 61 62 63")}, {9, hex("01 00 00 00 00 00 00 00")}};
    }

    FakeServer::Script script() {
        return answering([this](const cip::Request& request) -> cip::Response {
            const std::lock_guard lock(mutex_);
            const auto path = request.path.encode();
            if (path.size() != 6 || path[1] != 0x70)
                return {request.service, GeneralStatus::path_destination_unknown, {}};
            const auto found = values_.find(path[5]);
            if (found == values_.end()) return {request.service, GeneralStatus::attribute_not_supported, {}};
            if (request.service == 0x0E) return {request.service, {}, found->second};
            if (path[5] == 3) return {request.service, GeneralStatus::attribute_not_settable, {}};
            if (request.data == hex("FF FF")) return {request.service, GeneralStatus::invalid_attribute_value, {}};
            found->second = request.data;
            ++written_;
            return {request.service, {}, {}};
        });
    }
    cip::Bytes value(unsigned id) {
        const std::lock_guard lock(mutex_);
        return values_.at(id);
    }
    int written() {
        const std::lock_guard lock(mutex_);
        return written_;
    }

private:
    std::mutex mutex_;
    std::map<unsigned, cip::Bytes> values_;
    int written_ = 0;
};

class SheetGetSet : public testing::Test {
protected:
    scanner::test::Run ask(std::vector<std::string> words, const std::vector<std::string>& more) {
        words.insert(words.end(), {server_.host(), "--eds", file_.path()});
        words.insert(words.end(), more.begin(), more.end());
        return run_scanner(words);
    }
    Valve valve_;

private:
    FakeServer server_{valve_.script()};
    SheetFile file_;
};

TEST_F(SheetGetSet, ReadsByTheNamesOfTheFile) {
    const auto result = ask({"get"}, {"Set Point", "mode", "Param3", "0x70/1/4", "TAG", "cycles"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(result.out,
              "Set Point = 25.0 bar  (CIP 0x70/1/0x01, Param1)\n"
              "Mode = 2 (Auto matic)  (CIP 0x70/1/0x02, Param2)\n"
              "Status = 0x0637 (1591)  (CIP 0x70/1/0x03, Param3)\n"
              "Flow = 2.50 l/min  (CIP 0x70/1/0x04, Param4)\n"
              "Tag = abc  (CIP 0x70/1/0x05, Param5)\n"
              "Cycles = 1  (CIP 0x70/1/0x09, Param9)\n");
    const auto values = json::parse(ask({"get"}, {"setpoint", "mode", "--json"}).out)["values"];
    EXPECT_EQ(values[0]["value"], 25.0);
    EXPECT_EQ(values[0]["raw"], 250);
    EXPECT_EQ(values[0]["unit"], "bar");
    EXPECT_EQ(values[1]["text"], "Auto matic");
}

TEST_F(SheetGetSet, KnowsNoOtherNames) {
    const auto unknown = ask({"get"}, {"SCurve"});
    EXPECT_EQ(unknown.code, 2);
    EXPECT_THAT(unknown.err, HasSubstr("no parameter of the file is called 'SCurve'"));
    EXPECT_THAT(ask({"get"}, {"poin"}).err, HasSubstr("did you mean Set Point?"));
    EXPECT_THAT(ask({"get"}, {"RPI"}).err, HasSubstr("RPI has no address in the file"));
    EXPECT_EQ(run_scanner({"get", "127.0.0.1", "--eds", "no-such.eds", "Mode"}).code, 2);
}

TEST_F(SheetGetSet, WritesInTheUnitsOfTheFile) {
    const auto result = ask({"set"}, {"Set Point", "12.5"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(result.out, "Set Point = 12.5 bar  (CIP 0x70/1/0x01, Param1)\n");
    EXPECT_EQ(valve_.value(1), hex("7D 00"));
    EXPECT_EQ(ask({"set"}, {"Mode=Auto matic", "Tag=x=y", "setpoint=-10"}).code, 0);
    EXPECT_EQ(valve_.value(2), hex("02"));
    EXPECT_EQ(valve_.value(5), hex("03 78 3D 79"));
    EXPECT_EQ(valve_.value(1), hex("9C FF"));
}

TEST_F(SheetGetSet, RefusesBeforeItSends) {
    for (const auto& [words, why] : std::vector<std::pair<std::vector<std::string>, std::string>>{
             {{"Set Point", "100.1"}, "Set Point: it takes -10.0 to 100.0 bar; --force sends it all the same"},
             {{"Mode", "3"}, "Mode: it takes Off (0), On (1), Auto matic (2); --force"},
             {{"Status", "1"}, "Status: the file says that it is read only; --force"},
             {{"Mode=On", "Set Point=200"}, "Set Point: it takes"},
             {{"Set Point", "1.23"}, "between two steps"},
             {{"Set Point"}, "'Set Point' has no value"}}) {
        const auto result = ask({"set"}, words);
        EXPECT_EQ(result.code, 2) << words[0];
        EXPECT_THAT(result.err, HasSubstr(why));
    }
    EXPECT_EQ(valve_.written(), 0) << "nothing was sent, also of what came before";
    EXPECT_EQ(ask({"set", "--force"}, {"Set Point", "200"}).code, 0);
    EXPECT_EQ(valve_.value(1), hex("D0 07"));
    const auto refused = ask({"set", "--force"}, {"Status", "1"});
    EXPECT_EQ(refused.code, 4);
    EXPECT_THAT(refused.err, HasSubstr("Status: refused with 0x0E"));
    EXPECT_EQ(run_scanner({"set", "127.0.0.1", "SCurve=1", "--force"}).code, 2);
}

TEST_F(SheetGetSet, TheFirstRefusalEndsIt) {
    const auto result = ask({"set"}, {"Set Point=-0.1", "Mode=Off"});
    EXPECT_EQ(result.code, 4);
    EXPECT_THAT(result.err,
                AllOf(HasSubstr("Set Point: refused with 0x09 invalid attribute value; it takes -10.0 to 100.0 bar"),
                      HasSubstr("Mode: not set, since the one before failed")));
    EXPECT_EQ(valve_.written(), 0);
}

// ------------------------------------------------------------------------------------------------------------------ io

class SheetTask : public testing::Test {
protected:
    ConnectionTask task(const std::function<void(ConnectionArguments&)>& change = [](ConnectionArguments&) {}) {
        auto made = make_task(arguments(change), {});
        EXPECT_TRUE(made) << made.error().text;
        return made ? std::move(*made) : ConnectionTask{};
    }
    std::string mistake(const std::function<void(ConnectionArguments&)>& change) {
        const auto made = make_task(arguments(change), {});
        if (made) return "none";
        auto text = made.error().text;
        // Which file it is, is said as well.
        if (text.starts_with(file_.path() + ": ")) text.erase(0, file_.path().size() + 2);
        return text;
    }

private:
    ConnectionArguments arguments(const std::function<void(ConnectionArguments&)>& change) {
        ConnectionArguments made;
        made.eds = file_.path();
        made.connection = "Exclusive Owner";
        change(made);
        return made;
    }
    SheetFile file_;
};

TEST_F(SheetTask, IsMadeFromTheFileAlone) {
    const auto made = task();
    EXPECT_EQ(made.plan.o_to_t.rpi, 20ms) << "the interval that the file proposes";
    EXPECT_EQ(made.plan.configuration, hex("FA 00 01 00"));
    EXPECT_EQ(made.outputs.octets, 4U);
    EXPECT_EQ(made.start, hex("FA 00 01 00")) << "the defaults of the members";
    EXPECT_EQ(made.output_name, "Outputs");
    EXPECT_EQ(made.input_name, "Inputs");
    EXPECT_EQ(made.known, nullptr);
    EXPECT_FALSE(made.plan.key);
}

TEST_F(SheetTask, OptionsOverrideAndAreHeldToTheFile) {
    const auto made = task([](ConnectionArguments& a) {
        a.rpi = "5";
        a.t_to_o_rpi = "50";
        a.config = "0001";
        a.multicast = true;
        a.key = "eds";
    });
    EXPECT_EQ(made.plan.o_to_t.rpi, 5ms);
    EXPECT_EQ(made.plan.t_to_o.rpi, 50ms);
    EXPECT_EQ(made.plan.configuration, hex("00 01"));
    EXPECT_EQ(made.plan.t_to_o.type, cip::ConnectionType::multicast);
    EXPECT_EQ(made.plan.key->vendor, 77);
    EXPECT_EQ(mistake([](ConnectionArguments& a) { a.rpi = "1"; }),
              "O->T: an interval of 1 ms; the file allows 2 ms to 100 ms");
    EXPECT_EQ(mistake([](ConnectionArguments& a) { a.t_to_o_rpi = "200"; }),
              "T->O: an interval of 200 ms; the file allows 2 ms to 100 ms");
    EXPECT_EQ(mistake([](ConnectionArguments& a) { a.o_to_t_octets = 6; }), "O->T: 6 octets; the file allows 4 octets");
    EXPECT_EQ(mistake([](ConnectionArguments& a) { a.o_to_t_format = "modeless"; }),
              "O->T: modeless; the file allows 32-bit run/idle header");
    EXPECT_EQ(mistake([](ConnectionArguments& a) { a.priority = "urgent"; }),
              "O->T: priority urgent; the file allows scheduled");
    EXPECT_THAT(mistake([](ConnectionArguments& a) { a.config_instance = "1"; }), HasSubstr("in the path of the file"));
    EXPECT_THAT(mistake([](ConnectionArguments& a) { a.o_to_t_point = 1; }), HasSubstr("--eds has the points"));
    EXPECT_THAT(mistake([](ConnectionArguments& a) { a.connection = ""; }),
                HasSubstr("write which: 'Exclusive Owner'"));
    EXPECT_THAT(mistake([](ConnectionArguments& a) { a.eds = "no-such.eds"; }), HasSubstr("cannot be read"));
    EXPECT_EQ(task([](ConnectionArguments& a) { a.connection = "input"; }).outputs.octets, 0U);
}

TEST_F(SheetTask, OutputsAreSetByName) {
    const auto image = [&](std::vector<std::string> changes) {
        const auto made = task([&](ConnectionArguments& a) { a.changes = std::move(changes); });
        auto octets = made.start;
        for (const auto& change : made.changes) put(change, octets);
        return cip::to_hex(octets);
    };
    EXPECT_EQ(image({"Set Point=-0.1"}), "FF FF 01 00");
    EXPECT_EQ(image({"set_point=1", "MODE=auto matic"}), "0A 00 02 00");
    EXPECT_EQ(image({"Opened=1"}), "FA 00 01 01");
    EXPECT_EQ(image({"Opened#2=1"}), "FA 00 01 02") << "the second of that name";
    EXPECT_EQ(image({"@2:USINT=9"}), "FA 00 09 00");
    const auto wrong = [&](const std::string& text) {
        return mistake([&](ConnectionArguments& a) { a.changes = {text}; });
    };
    EXPECT_EQ(wrong("Set Point=101"), "Set Point: it takes -10.0 to 100.0 bar; @OFFSET:TYPE=VALUE sends anything");
    EXPECT_EQ(wrong("Mode=Of"), "Mode: 'Of' is none of Off (0), On (1), Auto matic (2)");
    EXPECT_EQ(wrong("Flow=1"), "'Flow' is not in Assem150, which has Set Point, Mode, Opened, Opened#2");
}

TEST_F(SheetTask, InputsAreShownByName) {
    const auto made = task();
    // Status 0x0637, Closed, padding, On, 2.5.
    const auto data = hex("37 06 02 01 00 00 20 40");
    EXPECT_EQ(inputs_line(made.input_fields, data),
              "Status 0x0637 (1591), Opened 0, Closed 1, Mode 1 (On), Flow 2.50 l/min");
    const auto table = inputs_table(made.input_fields, data);
    ASSERT_EQ(table.size(), 5U);
    EXPECT_THAT(table[4], testing::MatchesRegex("Flow +2.50 l/min"));
    const enip::IoConsumer::Counters counters;
    const IoInput input{.data = data, .counters = counters};
    EXPECT_EQ(json::parse(input_line_json(made.input_fields, input, 0))["values"],
              json({{"Status", 0x0637}, {"Opened", 0}, {"Closed", 1}, {"Mode", 1}, {"Flow", 2.5}}));
    EXPECT_EQ(csv_header(made.input_fields, 8), "time [s],sequence,fresh,run,Status,Opened,Closed,Mode,Flow [l/min]\n");
    EXPECT_EQ(csv_line(made.input_fields, input, 0), "0.000000,0,1,1,1591,0,1,1,2.5\n");
}

// --------------------------------------------------------------------------------------------------------- hostile text

TEST(EdsShow, DeviceTextsMoveNoCursor) {
    const SheetFile file(altered(std::string(valve_text), "\"Set Point\"", "\"Set\x1B[2JPoint\""));
    EXPECT_THAT(run_scanner({"eds", "show", file.path()}).out,
                AllOf(HasSubstr("Set\\x1B[2JPoint"), Not(HasSubstr("\x1B"))));
    EXPECT_THAT(run_scanner({"list", "--eds", file.path()}).out, Not(HasSubstr("\x1B")));
}

}  // namespace
}  // namespace servobus::scanner::cli
