// `io` and `open` without a device: options, the connections that they mean, and what is printed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "enip/asio/scheduling.hpp"
#include "scanner/cli/io_options.hpp"
#include "scanner/cli/io_output.hpp"
#include "scanner/cli/live_table.hpp"
#include "tests/scanner/fake_server.hpp"
#include "tests/scanner/run_scanner.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace std::chrono_literals;
using namespace test;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

ConnectionTask task_of(const ConnectionArguments& arguments) {
    auto task = make_task(arguments, {});
    EXPECT_TRUE(task.has_value()) << (task ? std::string() : task.error().text);
    return task ? std::move(*task) : ConnectionTask{};
}

std::string mistake_of(const ConnectionArguments& arguments) {
    const auto task = make_task(arguments, {});
    return task ? std::string() : task.error().text;
}

ConnectionArguments numbers() {
    ConnectionArguments arguments;
    arguments.o_to_t_point = 150;
    arguments.o_to_t_octets = 8;
    arguments.t_to_o_point = 100;
    arguments.t_to_o_octets = 10;
    return arguments;
}

TEST(IoOptions, StandardIsWhatNobodySays) {
    const auto task = task_of({});
    EXPECT_EQ(task.plan, plan_of(*assemblies::find_connection("standard")));
    EXPECT_EQ(task.outputs.octets, 18U);
    EXPECT_EQ(task.inputs, assemblies::find_layout(100));
    EXPECT_TRUE(task.run);
    EXPECT_FALSE(task.key_of_device);
}

TEST(IoOptions, EveryConnectionOfTheDriveHasItsName) {
    for (const auto* key : {"standard", "iforce", "outputs", "force", "cipsync", "input-only", "listen-only"}) {
        const auto task = task_of({.connection = key});
        const auto* known = assemblies::find_connection(key);
        EXPECT_EQ(task.known, known);
        EXPECT_EQ(task.plan.o_to_t.connection_size(), known->o_to_t_size());
        EXPECT_EQ(task.plan.t_to_o.connection_size(), known->t_to_o_size());
        EXPECT_THAT(connection_keys(), HasSubstr(key));
    }
    EXPECT_THAT(mistake_of({.connection = "norm"}), HasSubstr("'norm' is none of standard, iforce"));
}

TEST(IoOptions, ThoseWhoLookOnChooseTheirInputs) {
    ConnectionArguments arguments{.connection = "input-only"};
    arguments.t_to_o_point = 113;
    EXPECT_EQ(task_of(arguments).inputs, assemblies::find_layout(113));
    arguments.t_to_o_point = 101;
    EXPECT_THAT(mistake_of(arguments), HasSubstr("has no inputs 101"));
    // Only a multicast can be listened to (R-CON-32).
    EXPECT_EQ(task_of({.connection = "listen-only"}).plan.t_to_o.type, cip::ConnectionType::multicast);
    EXPECT_EQ(task_of({.connection = "input-only"}).plan.t_to_o.type, cip::ConnectionType::point_to_point);
}

TEST(IoOptions, TheSixNumbersOfAnyDevice) {
    auto arguments = numbers();
    arguments.config_instance = "151";
    arguments.rpi = "2.5";
    const auto plan = task_of(arguments).plan;
    // 20 04 24 97 2C 96 2C 64: class 4, configuration 151, points 150 and 100 (R-CON-10).
    EXPECT_EQ(plan.path().encode(), hex("20 04 24 97 2C 96 2C 64"));
    const auto open = plan.forward_open(1, 2, {});
    EXPECT_EQ(open.o_to_t.size, 2 + 4 + 8) << "sequence count, run/idle header, data (R-CON-7)";
    EXPECT_EQ(open.t_to_o.size, 2 + 10);
    EXPECT_EQ(open.o_to_t_rpi, 2'500U);
    EXPECT_EQ(open.t_to_o_rpi, 2'500U);
    EXPECT_EQ(task_of(arguments).known, nullptr);
    EXPECT_EQ(task_of(arguments).inputs, nullptr);
    arguments.config_instance = "none";
    EXPECT_EQ(task_of(arguments).plan.path().encode(), hex("20 04 2C 96 2C 64"));
    EXPECT_EQ(task_of(numbers()).plan.configuration_instance, std::nullopt);
    EXPECT_EQ(task_of(numbers()).plan.o_to_t.rpi, 10ms);
}

TEST(IoOptions, WhatIsMissingIsSaid) {
    auto arguments = numbers();
    arguments.t_to_o_octets.reset();
    EXPECT_THAT(mistake_of(arguments), HasSubstr("also needs --o2t-size, --t2o and --t2o-size"));
    arguments = numbers();
    arguments.connection = "standard";
    EXPECT_THAT(mistake_of(arguments), HasSubstr("either --connection or --o2t"));
    EXPECT_THAT(mistake_of({.t_to_o_octets = 28}), HasSubstr("a --connection has its sizes"));
}

TEST(IoOptions, WhoSendsNothingSendsAHeartbeat) {
    auto arguments = numbers();
    arguments.o_to_t_octets = 0;
    auto task = task_of(arguments);
    EXPECT_EQ(task.plan.o_to_t.format, cip::RealTimeFormat::heartbeat);
    EXPECT_EQ(task.plan.o_to_t.connection_size(), 2U);
    EXPECT_FALSE(task.has_outputs());
    arguments.o_to_t_format = "header32";
    EXPECT_EQ(task_of(arguments).plan.o_to_t.connection_size(), 6U);
}

TEST(IoOptions, FormatsAndManners) {
    auto arguments = numbers();
    arguments.o_to_t_format = "zero-length";
    arguments.t_to_o_format = "header32";
    arguments.o_to_t_rpi = "5";
    arguments.t_to_o_rpi = "500us";
    arguments.multicast = true;
    arguments.multiplier = 512;
    arguments.trigger = "cos";
    arguments.inhibit = "1.5";
    arguments.priority = "urgent";
    arguments.large = true;
    arguments.config = "01 02 03 04";
    arguments.key = "1389/43/0x7509/1.2";
    const auto plan = task_of(arguments).plan;
    EXPECT_EQ(plan.o_to_t.format, cip::RealTimeFormat::zero_length);
    EXPECT_TRUE(plan.o_to_t.variable) << "without data it is shorter than with it";
    EXPECT_FALSE(plan.t_to_o.variable);
    EXPECT_EQ(plan.t_to_o.connection_size(), 16U);
    EXPECT_EQ(plan.o_to_t.rpi, 5ms);
    EXPECT_EQ(plan.t_to_o.rpi, 500us);
    EXPECT_EQ(plan.t_to_o.type, cip::ConnectionType::multicast);
    EXPECT_EQ(plan.o_to_t.type, cip::ConnectionType::point_to_point);
    EXPECT_EQ(plan.multiplier_code, 7);
    EXPECT_EQ(plan.trigger, enip::Trigger::change_of_state);
    EXPECT_EQ(plan.inhibit, 1500us);
    EXPECT_EQ(plan.o_to_t.priority, cip::Priority::urgent);
    EXPECT_EQ(plan.t_to_o.priority, cip::Priority::urgent);
    EXPECT_TRUE(plan.large);
    EXPECT_EQ(plan.configuration, hex("01 02 03 04"));
    ASSERT_TRUE(plan.key);
    EXPECT_EQ(*plan.key, (cip::ElectronicKey{1389, 43, 0x7509, 1, 2, {}}));
    arguments.variable = true;
    EXPECT_TRUE(task_of(arguments).plan.t_to_o.variable);
    arguments.key = "auto";
    EXPECT_TRUE(task_of(arguments).key_of_device);
    arguments.key = "none";
    EXPECT_EQ(task_of(arguments).plan.key, std::nullopt);
}

TEST(IoOptions, NonsenseIsSaid) {
    const auto with = [](auto change) {
        auto arguments = numbers();
        change(arguments);
        return mistake_of(arguments);
    };
    EXPECT_THAT(with([](auto& to) { to.o_to_t_format = "header16"; }),
                HasSubstr("--o2t-format: 'header16' is none of header32, modeless, heartbeat, zero-length"));
    EXPECT_THAT(with([](auto& to) { to.trigger = "never"; }), HasSubstr("cyclic, cos, application"));
    EXPECT_THAT(with([](auto& to) { to.priority = "top"; }), HasSubstr("low, high, scheduled, urgent"));
    EXPECT_THAT(with([](auto& to) { to.multiplier = 5; }), HasSubstr("4, 8, 16"));
    EXPECT_THAT(with([](auto& to) { to.multiplier = 1024; }), HasSubstr("4, 8, 16"));
    EXPECT_THAT(with([](auto& to) { to.multiplier = 2; }), HasSubstr("4, 8, 16"));
    EXPECT_THAT(with([](auto& to) { to.config = "123"; }), HasSubstr("pairs of hex digits"));
    EXPECT_THAT(with([](auto& to) { to.config = "010203"; }), HasSubstr("an even number"));
    EXPECT_THAT(with([](auto& to) { to.config = std::string(4 * 255, '0'); }), HasSubstr("longer than a path"));
    EXPECT_THAT(with([](auto& to) { to.config_instance = "one"; }), HasSubstr("neither a number nor none"));
    for (const auto* key : {"1", "1/2/3", "1/2/3/4", "1/2/3/4.5/6", "65536/2/3/4.5", "1/2/3/4.256", "a/2/3/4.5"}) {
        EXPECT_THAT(with([&](auto& to) { to.key = key; }), HasSubstr("is no key")) << key;
    }
    for (const auto* rpi : {"0", "-1", "x", "4294967.296", "1e9", "2h", "0.0001"}) {
        EXPECT_THAT(with([&](auto& to) { to.rpi = rpi; }), HasSubstr("--rpi: ")) << rpi;
    }
    EXPECT_THAT(with([](auto& to) { to.changes = {"@7:INT=1"}; }), HasSubstr("ends behind the 8 octets"));
    EXPECT_THAT(mistake_of({.connection = "input-only", .changes = {"SCurve=1"}}), HasSubstr("sends no outputs"));
}

TEST(IoOptions, IntervalsAreMilliseconds) {
    EXPECT_EQ(*parse_interval("--rpi", "1"), 1ms);
    EXPECT_EQ(*parse_interval("--rpi", "0.001"), 1us);
    EXPECT_EQ(*parse_interval("--rpi", "4294967.295"), 4'294'967'295us);
    EXPECT_EQ(*parse_interval("--rpi", "2s"), 2s);
    EXPECT_EQ(*parse_interval("--rpi", "20ms"), 20ms);
}

TEST(IoCli, RefusesWrongUsageBeforeItSendsAnything) {
    const std::vector<std::vector<std::string>> mistakes{
        {"io"},
        {"open"},
        {"io", "300.0.0.1"},
        {"io", "127.0.0.1:1", "--connection", "fast"},
        {"io", "127.0.0.1:1", "--o2t", "x"},
        {"io", "127.0.0.1:1", "--o2t", "150"},
        {"io", "127.0.0.1:1", "--o2t", "150", "--o2t-size", "70000", "--t2o", "100", "--t2o-size", "8"},
        {"io", "127.0.0.1:1", "--rpi", "0"},
        {"io", "127.0.0.1:1", "--multiplier", "6"},
        {"io", "127.0.0.1:1", "--set", "SCurve"},
        {"io", "127.0.0.1:1", "--set", "Statusword=1"},
        {"io", "127.0.0.1:1", "--duration", "soon"},
        {"io", "127.0.0.1:1", "--csv", "/no/such/folder/a.csv"},
        {"io", "127.0.0.1:1", "--pcapng", "/no/such/folder/a.pcapng"},
        {"io", "127.0.0.1:1", "--csv", "-", "--json"},
        {"io", "127.0.0.1:1", "--realtime", "0"},
        {"io", "127.0.0.1:1", "--cpu", "-1"},
        {"io", "127.0.0.1:1", "--route", "x"},
        {"open", "127.0.0.1:1", "--csv", "a.csv"},
        {"axis", "127.0.0.1:1", "move", "1", "--io", "--connection", "input-only"},
        {"axis", "127.0.0.1:1", "move", "1", "--io", "--rpi", "0"},
        {"axis", "127.0.0.1:1", "status", "--io"},
    };
    for (const auto& mistake : mistakes) {
        const auto result = run_scanner(mistake);
        EXPECT_EQ(result.code, 2) << testing::PrintToString(mistake) << result.err;
        EXPECT_THAT(result.err, StartsWith("servobus-scanner: "));
    }
}

TEST(IoCli, SaysThatNobodyIsThere) {
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"io", "127.0.0.1:1"},
          {"open", "127.0.0.1:1"},
          {"io", "127.0.0.1:1", "--connection", "input-only"},
          {"io", "127.0.0.1:1", "--o2t", "1", "--o2t-size", "2", "--t2o", "3", "--t2o-size", "4"}}) {
        const auto result = run_scanner(words);
        EXPECT_EQ(result.code, 3) << result.err;
        EXPECT_THAT(result.out, IsEmpty());
        EXPECT_THAT(result.err, HasSubstr("nothing listens there"));
    }
    const auto end = json::parse(run_scanner({"io", "127.0.0.1:1", "--json"}).out);
    EXPECT_EQ(end["event"], "end");
    EXPECT_EQ(end["error"]["kind"], "no_connection");
    EXPECT_EQ(end["error"]["exit_code"], 3);
    EXPECT_EQ(end["statistics"]["received"], 0);
}

TEST(IoCli, IsToldWhenTheDeviceIsNoXenax) {
    const FakeServer server(answering([](const cip::Request& request) {
        return cip::Response{request.service, cip::GeneralStatus::path_destination_unknown, {}};
    }));
    const auto result = run_scanner({"io", server.host()});
    EXPECT_EQ(result.code, 4);
    EXPECT_THAT(result.err, AllOf(HasSubstr("TargetPositionOrDistance: refused"), HasSubstr("--o2t and its numbers")));
}

TEST(IoCli, ARefusedOpenHasADiagnosis) {
    // Ownership conflict, which may pass; somebody sits there and is told at once.
    const FakeServer server(answering([](const cip::Request& request) {
        cip::Response response{request.service, cip::Status{cip::GeneralStatus::connection_failure, {0x0106}}, {}};
        response.data = cip::ConnectionRefusal{cip::ForwardOpen::parse(request.data, false)->triad, 0}.encode();
        return response;
    }));
    const std::vector<std::string> connection{"--o2t", "101", "--o2t-size", "18", "--t2o", "100", "--t2o-size", "28"};
    for (const auto* verb : {"io", "open"}) {
        std::vector<std::string> words{verb, server.host()};
        words.insert(words.end(), connection.begin(), connection.end());
        const auto result = run_scanner(words);
        EXPECT_EQ(result.code, 4) << result.err;
        EXPECT_THAT(result.err,
                    AllOf(HasSubstr("refused the connection: 0x01 connection failure, 0x0106"), HasSubstr("owner")));
        words.push_back("--json");
        auto lines = run_scanner(words).out;
        if (verb == std::string("io")) lines = lines.substr(lines.rfind('\n', lines.size() - 2) + 1);
        const auto document = json::parse(lines);
        EXPECT_EQ(document["error"]["general"], 1);
        EXPECT_EQ(document["error"]["extended"], json::array({0x0106}));
        EXPECT_FALSE(document["diagnosis"]["summary"].get<std::string>().empty());
    }
}

IoInput input(const cip::Bytes& data, const enip::IoConsumer::Counters& counters) {
    return {.data = data, .fresh = true, .run = true, .sequence = 7, .time = {}, .counters = counters};
}

const cip::Bytes& standard_inputs() {
    static const auto data = hex("37 06 FB FF 60 79 FE FF 00 00 00 00 0A 00 00 00 00 00 00 00 01 00 01 00 01 00 00 00");
    return data;
}

TEST(IoOutput, InputsByName) {
    const auto fields = fields_of(*assemblies::find_layout(100));
    EXPECT_THAT(inputs_line(fields, standard_inputs()),
                StartsWith("Statusword 0x0637 (1591), MotorCurrentActualValue -5 mA, PositionActualValue -100000 "
                           "increment, "));
    const auto table = inputs_table(fields, standard_inputs());
    ASSERT_EQ(table.size(), 8U);
    EXPECT_EQ(table[0],
              "Statusword                           0x0637 (1591)            Operation enabled; voltage "
              "enabled, remote, bit 10");
    EXPECT_EQ(table[2], "PositionActualValue                        -100000 increment");
}

TEST(IoOutput, OctetsWithoutNames) {
    EXPECT_EQ(inputs_line({}, hex("01 02")), "01 02");
    const cip::Bytes many(16 * 16 + 3, 0xAB);
    const auto table = inputs_table({}, many);
    ASSERT_EQ(table.size(), 17U);
    EXPECT_THAT(table[1], StartsWith("   16  AB AB "));
    EXPECT_EQ(table.back(), "       and 3 more octets");
}

TEST(IoOutput, LinesForPrograms) {
    const enip::IoConsumer::Counters counters;
    const auto fields = fields_of(*assemblies::find_layout(100));
    const auto line = input_line_json(fields, input(standard_inputs(), counters), 1.5);
    EXPECT_EQ(std::ranges::count(line, '\n'), 1);
    const auto document = json::parse(line);
    EXPECT_EQ(document["event"], "input");
    EXPECT_EQ(document["time"], 1.5);
    EXPECT_EQ(document["sequence"], 7);
    EXPECT_EQ(document["values"]["PositionActualValue"], -100000);
    EXPECT_EQ(json::parse(input_line_json({}, input(standard_inputs(), counters), 0))["data"].get<std::string>().size(),
              28U * 3 - 1);
    EXPECT_THAT(csv_header(fields, 28),
                StartsWith("time [s],sequence,fresh,run,Statusword,MotorCurrentActualValue [mA],"));
    EXPECT_EQ(csv_line(fields, input(standard_inputs(), counters), 0.25),
              "0.250000,7,1,1,1591,-5,-100000,0,10,0,65537,1\n");
    EXPECT_EQ(csv_header({}, 2), "time [s],sequence,fresh,run,data\n");
    EXPECT_EQ(csv_line({}, input(hex("0A 0B"), counters), 0), "0.000000,7,1,1,0A 0B\n");
    EXPECT_EQ(csv_line(fields, input({}, counters), 0), "0.000000,7,1,1,,,,,,,,\n");
}

TEST(IoOutput, StatisticsAtTheEnd) {
    IoReport report(1ms);
    for (std::uint32_t i = 0; i < 5; ++i) {
        if (i != 3) report.received.take(i, enip::Time(i * 1ms + (i == 2 ? 700us : 0us)));
    }
    report.sent = 6;
    report.openings = 1;
    report.open_for = 4ms;
    EXPECT_EQ(report_text(report),
              "0.004 s: sent 6, received 4, lost 1, late 1, duplicated 0, out of order 0\n"
              "interval, granted 1.000 ms: p50 1.000, p99 1.700, p99.9 1.700, max 1.700 ms\n"
              "error of the interval: p50 0.000, p99 0.700, p99.9 0.700, max 0.700 ms; longest silence 1.700 ms\n"
              "drift +0.0 ppm, mean interval 1.000000 ms\n");
    EXPECT_THAT(report_line(report), HasSubstr("4 in, 6 out, 1 lost, 1 late"));
    const auto end = json::parse(end_line_json("h", report, {}, {}))["statistics"];
    EXPECT_EQ(end["lost"], 1);
    EXPECT_EQ(end["interval_us"]["max"], 1700);
    EXPECT_EQ(end["drift_ppm"], 0);
    // Where the sender sends when it likes, there is nothing to drift from.
    report.cyclic = false;
    EXPECT_THAT(report_text(report), Not(HasSubstr("drift")));
    EXPECT_TRUE(json::parse(end_line_json("h", report, {}, {}))["statistics"]["drift_ppm"].is_null());
}

TEST(LiveTable, IsWrittenOverInPlace) {
    std::ostringstream out;
    {
        LiveTable table(out);
        table.show({"one", "two"});
        EXPECT_EQ(out.str(), "\r\x1B[?7lone\x1B[K\ntwo\x1B[K\n\x1B[?7h");
        out.str("");
        table.show({"three"});
        EXPECT_EQ(out.str(), "\r\x1B[2A\x1B[?7lthree\x1B[K\n\x1B[?7h\x1B[J");
        out.str("");
    }
    EXPECT_EQ(out.str(), "\r\x1B[1A\x1B[J");
}

TEST(Scheduling, SaysWhatIsNotThere) {
    EXPECT_EQ(enip::asio::apply({}), std::nullopt);
    const auto refused = enip::asio::apply({.realtime_priority = {}, .lock_memory = false, .cpu = 1 << 20});
    ASSERT_TRUE(refused);
    EXPECT_THAT(*refused, HasSubstr("CPU 1048576 is not there"));
}

}  // namespace
}  // namespace servobus::scanner::cli
