// The configuration file: what is taken, and what is refused with line and column.
#include "adapter/config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "adapter/file_settings.hpp"
#include "drive/xenax.hpp"
#include "eds/data_sheet.hpp"

namespace servobus::adapter {
namespace {

/// `line:column: reason`, or "accepted".
std::string problem(const std::string& text) {
    const auto parsed = parse_config(text);
    const auto* error = std::get_if<FileError>(&parsed);
    if (error == nullptr) return "accepted";
    return std::to_string(error->line) + ':' + std::to_string(error->column) + ": " + error->reason;
}

Config config(const std::string& text) {
    const auto parsed = parse_config(text);
    const auto* result = std::get_if<Config>(&parsed);
    EXPECT_NE(result, nullptr) << problem(text);
    return result != nullptr ? *result : Config{};
}

TEST(Config, AnEmptyObjectIsTheDefault) {
    const auto result = config("{}");
    EXPECT_EQ(result.variant, "75v8s");
    EXPECT_EQ(result.bind, "127.0.0.1");
    EXPECT_EQ(result.port, 44818);
    EXPECT_EQ(result.log_level, LogLevel::info);
    EXPECT_EQ(result.motor, std::nullopt);
    EXPECT_FALSE(result.axis || result.axis_file);
    EXPECT_EQ(result.seed, 1U);
    EXPECT_EQ(result.scenario, std::nullopt);
    EXPECT_EQ(result.limits.tcp_connections, Limits{}.tcp_connections);
    EXPECT_EQ(result.limits.inactivity, std::chrono::seconds(120));
    EXPECT_EQ(result.allowed.size(), 0U);
    EXPECT_FALSE(result.protection.read_only || result.protection.harden || result.access_log);
    EXPECT_TRUE(result.values.empty());
}

TEST(Config, TakesEverySetting) {
    const auto result = config(R"({
        "variant": "48v8", "bind": "0.0.0.0", "port": 0, "io_port": 2223, "count": 1024, "log_level": "debug", "motor": "linear", "eds": "drive.eds",
        "axis": "linax-lxc-230f10", "seed": 9223372036854775807, "scenario": "night.json",
        "identity": {"serial_number": 4294967295, "major_revision": 127, "minor_revision": 255, "product_name": "Press 7"},
        "lost_controller": {"outputs": "off"},
        "protection": {"allow": ["192.168.2.0/24", "10.0.0.5"], "read_only": true, "harden": true},
        "access_log": "access.jsonl",
        "limits": {"tcp_connections": 1, "sessions": 2, "class3_connections": 0, "listening_connections": 3,
                   "inactivity_seconds": 3600},
        "values": {"SCurve": 50, "drive.Controlword": "0x1F", "ServoIdentificationString": "axis 1"}
    })");
    EXPECT_EQ(result.variant, "48v8");
    EXPECT_EQ(result.bind, "0.0.0.0");
    EXPECT_EQ(result.port, 0);
    EXPECT_EQ(result.io_port, 2223);
    EXPECT_EQ(result.count, 1024U);
    EXPECT_EQ(result.outputs_without_controller, drive::OutputsWithoutController::off);
    EXPECT_EQ(result.log_level, LogLevel::debug);
    EXPECT_EQ(result.motor, drive::Motor::linear);
    EXPECT_EQ(result.eds, "drive.eds");
    ASSERT_TRUE(result.axis);
    EXPECT_EQ(result.axis->key, "linax-lxc-230f10");
    EXPECT_EQ(result.seed, 9223372036854775807U);
    EXPECT_EQ(result.scenario, "night.json");
    EXPECT_TRUE(result.allowed.permits(0x0A000005));
    EXPECT_FALSE(result.allowed.permits(0x7F000001));
    EXPECT_TRUE(result.protection.read_only && result.protection.harden);
    EXPECT_EQ(result.access_log, "access.jsonl");
    EXPECT_EQ(result.serial_number, 4294967295U);
    EXPECT_EQ(result.major_revision, 127);
    EXPECT_EQ(result.minor_revision, 255);
    EXPECT_EQ(result.product_name, "Press 7");
    EXPECT_EQ(result.limits.tcp_connections, 1U);
    EXPECT_EQ(result.limits.sessions, 2U);
    EXPECT_EQ(result.limits.class3_connections, 0U);
    EXPECT_EQ(result.limits.listening_connections, 3U);
    EXPECT_EQ(result.limits.inactivity, std::chrono::seconds(3600));
    EXPECT_EQ(result.values.size(), 3U);
}

TEST(Config, ADriveMayHaveAnInterfaceForItself) {
    const auto result = config(R"({"manage_interface": "eth1", "network": {"address": "192.168.2.100/24",
                                   "gateway": "192.168.2.1", "acd": false}})");
    EXPECT_EQ(result.manage_interface, "eth1");
    EXPECT_EQ(result.network.method, AddressMethod::stored);
    EXPECT_EQ(result.network.configured,
              (InterfaceConfiguration{.address = 0xC0A80264, .mask = 0xFFFFFF00, .gateway = 0xC0A80201}));
    EXPECT_FALSE(result.network.select_acd);
    EXPECT_EQ(make_network({}, result.network).settings.configured.address, 0xC0A80264);
    EXPECT_EQ(config("{}").network.method, AddressMethod::dhcp);
    EXPECT_EQ(config(R"({"network": {"method": "bootp"}})").network.method, AddressMethod::bootp);
    // An address may wait for the day when DHCP is disabled.
    const auto both = config(R"({"network": {"method": "dhcp", "address": "10.0.0.5/8"}})");
    EXPECT_EQ(both.network.method, AddressMethod::dhcp);
    EXPECT_EQ(both.network.configured.mask, 0xFF000000);
}

TEST(Config, AddressesThatNoHostCanHaveAreRefused) {
    const auto with = [](const std::string& address) {
        return problem(R"({"network": {"address": ")" + address + "\"}}");
    };
    for (const auto* text : {"192.168.2.100", "192.168.2/24", "192.168.2.100/33", "192.168.2.100/0", "192.168.2.100/x",
                             "192.168.2.100/24x", ""}) {
        EXPECT_THAT(with(text), testing::HasSubstr("must be an address in its subnet")) << text;
    }
    for (const auto* text :
         {"192.168.2.0/24", "192.168.2.255/24", "127.0.0.1/8", "224.0.0.1/24", "0.0.0.1/8", "192.168.2.100/32"}) {
        EXPECT_THAT(with(text), testing::HasSubstr("is none that a host can have")) << text;
    }
    EXPECT_THAT(problem(R"({"network": {"address": "192.168.2.100/24", "gateway": "10.0.0.1"}})"),
                testing::HasSubstr("another subnet"));
    EXPECT_THAT(problem(R"({"network": {"gateway": "10.0.0.1"}})"), testing::HasSubstr("needs an address beside it"));
    EXPECT_THAT(problem(R"({"network": {"method": "static"}})"),
                testing::HasSubstr(R"(must be one of "stored", "bootp", "dhcp")"));
}

TEST(Config, TheDeviceIsAsConfigured) {
    const auto device = make_device(config(R"({
        "variant": "75v8", "motor": "linear",
        "identity": {"serial_number": 7, "major_revision": 2, "minor_revision": 3, "product_name": "Press 7"},
        "values": {"SCurve": 50, "VersionOfFirmware": 41}
    })"));
    EXPECT_EQ(device.identity().product_code, 0x7508);
    EXPECT_EQ(device.identity().serial_number, 7U);
    EXPECT_EQ(device.identity().major_revision, 2);
    EXPECT_EQ(device.identity().minor_revision, 3);
    EXPECT_EQ(device.identity().product_name, "Press 7");
    EXPECT_EQ(device.motor(), drive::Motor::linear);
    EXPECT_EQ(device.store().value(*device.find({0x64, 0x00})), drive::Value{std::int64_t{50}});
    EXPECT_EQ(device.store().value(*device.find({0x65, 0x13})), drive::Value{std::int64_t{41}})
        << "rows too that tell one value for ever";
    EXPECT_EQ(device.store().value(*device.find({0x64, 0x08})), drive::Value{std::string("230101")});
}

TEST(Config, WithoutSettingsTheDeviceIsThePrintedOne) {
    const auto device = make_device(config("{}"));
    EXPECT_EQ(device.identity().product_name, "XENAX Xvi 75V8S");
    EXPECT_EQ(device.identity().serial_number, 0x00A1B2C3U);
    EXPECT_EQ(device.store().value(*device.find({0x64, 0x00})), drive::Value{std::int64_t{20}});
}

struct Wrong {
    const char* text;
    const char* problem;  ///< exact, or up to an ellipsis
};
void PrintTo(const Wrong& each, std::ostream* out) { *out << each.text; }

class WrongConfig : public testing::TestWithParam<Wrong> {};
TEST_P(WrongConfig, IsRefusedWithItsPlace) {
    const std::string expected = GetParam().problem;
    const auto ellipsis = expected.find("...");
    EXPECT_EQ(problem(GetParam().text).substr(0, ellipsis), expected.substr(0, ellipsis));
}

INSTANTIATE_TEST_SUITE_P(
    Malformed, WrongConfig,
    testing::Values(Wrong{"", "1:1: ..."}, Wrong{"{", "1:2: ..."}, Wrong{"{\"port\": 1,}", "1:12: ..."},
                    Wrong{"{\n  \"port\": 1\n  \"bind\": \"x\"\n}", "3:8: ..."}, Wrong{"{\"port\" 1}", "1:9: ..."},
                    Wrong{"{} {}", "1:4: ..."}, Wrong{"{'port': 1}", "1:2: ..."}, Wrong{"{\"port\": 01}", "1:11: ..."},
                    Wrong{"{\"port\": 1e999}", "1:14: ..."}, Wrong{"{\"bind\": \"\xff\"}", "1:11: ..."},
                    Wrong{"[]", "1:1: the file must hold one object in braces"},
                    Wrong{"3", "1:1: the file must hold one object in braces"}));

INSTANTIATE_TEST_SUITE_P(
    Keys, WrongConfig,
    testing::Values(
        Wrong{
            "{\n  \"prot\": 1}",
            "2:3: 'prot' is not a setting; here may stand: access_log, axis, bind, count, eds, flash, icon, identity, "
            "io_port, "
            "limits, log_level, lost_controller, manage_interface, motor, network, port, profiles, programs, "
            "protection, scenario, seed, state, "
            "values, variant"},
        Wrong{"{\"identity\": {\"serial\": 1}}",
              "1:15: 'serial' is not a setting; here may stand: "
              "major_revision, minor_revision, product_name, serial_number"},
        Wrong{"{\"limits\": {\n\n   \"refusals\": 1}}",
              "3:4: 'refusals' is not a setting; here may stand: "
              "class3_connections, inactivity_seconds, listening_connections, sessions, "
              "tcp_connections"},
        Wrong{"{\"port\": 1,\n \"port\": 1}", "2:2: 'port' stands here a second time"},
        Wrong{"{\"values\": {\"SCurve\": 1, \"SCurve\": 2}}", "1:26: 'SCurve' stands here a second time"},
        Wrong{"{\"values\": {\"SCurve\": 1, \"general.SCurve\": 2}}",
              "1:26: 'general.SCurve' has a value already, under another name"},
        Wrong{"{\"\": 1}", "1:2: '' is not a setting; ..."},
        Wrong{"{\"a/b~c\": 1}", "1:2: 'a/b~c' is not a setting; ..."}));

INSTANTIATE_TEST_SUITE_P(
    Values, WrongConfig,
    testing::Values(
        Wrong{"{\"port\": \"1\"}", "1:2: 'port' must be a whole number from 0 to 65535"},
        Wrong{"{\"port\": 65536}", "1:2: 'port' must be a whole number from 0 to 65535"},
        Wrong{"{\"port\": -1}", "1:2: 'port' must be a whole number from 0 to 65535"},
        Wrong{"{\"port\": 1.5}", "1:2: 'port' must be a whole number from 0 to 65535"},
        Wrong{"{\"port\": 1.0}", "1:2: 'port' must be a whole number from 0 to 65535"},
        Wrong{"{\"port\": null}", "1:2: 'port' must be a whole number from 0 to 65535"},
        Wrong{"{\"bind\": 5}", "1:2: 'bind' must be a text"}, Wrong{"{\"bind\": \"\"}", "1:2: 'bind' must be a text"},
        Wrong{"{\"eds\": 5}", "1:2: 'eds' must be a text"},
        Wrong{"{\"axis\": \"linax\"}", "1:2: 'axis' must be the name of a .json file, or one of ..."},
        Wrong{"{\"axis\": 5}", "1:2: 'axis' must be the name of a .json file, or one of ..."},
        Wrong{"{\"seed\": -1}", "1:2: 'seed' must be a whole number from 0 to 9223372036854775807"},
        Wrong{"{\"seed\": 9223372036854775808}", "1:2: 'seed' must be a whole number from 0 to 9223372036854775807"},
        Wrong{"{\"scenario\": \"\"}", "1:2: 'scenario' must be a text"},
        Wrong{"{\"variant\": \"75V8S\"}", "1:2: 'variant' must be one of \"75v8s\", \"75v8\", \"48v8\""},
        Wrong{"{\"log_level\": \"loud\"}",
              "1:2: 'log_level' must be one of \"trace\", \"debug\", \"info\", \"warning\", \"error\""},
        Wrong{"{\"motor\": 1}", "1:2: 'motor' must be one of \"any\", \"linear\", \"rotative\""},
        Wrong{"{\"identity\": []}", "1:2: 'identity' must be an object in braces"},
        Wrong{"{\"limits\": 1}", "1:2: 'limits' must be an object in braces"},
        Wrong{"{\"values\": [{\"SCurve\": 1}, {\"SCurve\": 2}]}", "1:2: 'values' must be an object in braces"},
        Wrong{"{\"identity\": {\"serial_number\": 0}}",
              "1:15: 'serial_number' must be a whole number from 1 to 4294967295"},
        Wrong{"{\"identity\": {\"serial_number\": 4294967296}}",
              "1:15: 'serial_number' must be a whole number from 1 to 4294967295"},
        Wrong{"{\"identity\": {\"major_revision\": 0}}", "1:15: 'major_revision' must be a whole number from 1 to 127"},
        Wrong{"{\"identity\": {\"major_revision\": 128}}",
              "1:15: 'major_revision' must be a whole number from 1 to 127"},
        Wrong{"{\"identity\": {\"minor_revision\": 0}}", "1:15: 'minor_revision' must be a whole number from 1 to 255"},
        Wrong{"{\"identity\": {\"minor_revision\": 256}}",
              "1:15: 'minor_revision' must be a whole number from 1 to 255"},
        Wrong{"{\"identity\": {\"product_name\": \"\"}}", "1:15: 'product_name' must be a text of 1 to 32 characters"},
        Wrong{"{\"identity\": {\"product_name\": \"123456789012345678901234567890123\"}}",
              "1:15: 'product_name' must be a text of 1 to 32 characters"},
        Wrong{"{\"limits\": {\"tcp_connections\": 0}}",
              "1:13: 'tcp_connections' must be a whole number from 1 to 100000"},
        Wrong{"{\"limits\": {\"tcp_connections\": 100001}}",
              "1:13: 'tcp_connections' must be a whole number from 1 to 100000"},
        Wrong{"{\"limits\": {\"sessions\": 0}}", "1:13: 'sessions' must be a whole number from 1 to 100000"},
        Wrong{"{\"limits\": {\"class3_connections\": 65536}}",
              "1:13: 'class3_connections' must be a whole number from 0 to 65535"},
        Wrong{"{\"limits\": {\"inactivity_seconds\": 3601}}",
              "1:13: 'inactivity_seconds' must be a whole number from 0 to 3600"}));

INSTANTIATE_TEST_SUITE_P(
    Parameters, WrongConfig,
    testing::Values(
        Wrong{"{\"values\": {\"SCurv\": 1}}", "1:13: 'SCurv' is no parameter; did you mean 'SCurve'?"},
        Wrong{"{\"values\": {\n    \"SCurve\": 101}}",
              "2:5: 'SCurve' the value is above the upper limit: it holds 1 to 100"},
        Wrong{"{\"values\": {\"SCurve\": 0}}", "1:13: 'SCurve' the value is below the lower limit: it holds 1 to 100"},
        Wrong{"{\"values\": {\"SCurve\": 1.5}}", "1:13: 'SCurve' must be a whole number, or a text such as \"0x1F\""},
        Wrong{"{\"values\": {\"SCurve\": true}}", "1:13: 'SCurve' must be a whole number, or a text such as \"0x1F\""},
        Wrong{"{\"values\": {\"SCurve\": \"much\"}}", "1:13: 'SCurve' ..."},
        Wrong{"{\"values\": {\"Statusword\": 1}}",
              "1:13: 'Statusword' is told by the drive itself; a scenario can bring it about"},
        Wrong{"{\"values\": {\"VersionOfFirmware\": 18446744073709551615}}",
              "1:13: 'VersionOfFirmware' the value is above the upper limit..."},
        Wrong{"{\"values\": {\"ServoIdentificationString\": 5}}", "1:13: 'ServoIdentificationString' must be a text"},
        Wrong{"{\"values\": {\"ServoIdentificationString\": \"123456789012345678901234567890123\"}}",
              "1:13: 'ServoIdentificationString' holds at most 32 characters"},
        Wrong{"{\"values\": {\"ReferenceMethods\": 7}}",
              "1:13: 'ReferenceMethods' the value is inside the limits, but not one of the values that exist..."},
        Wrong{"{\"values\": {\"Reserved\": 1}}", "1:13: 'Reserved' is no parameter; ..."},
        Wrong{"{\"protection\": {\"allow\": \"10.0.0.0/8\"}}",
              "1:17: 'allow' must be a list of networks such as \"192.168.2.0/24\""},
        Wrong{"{\"protection\": {\"allow\": [\"10.0.0.1/8\"]}}",
              "1:17: 'allow' is not sound: '10.0.0.1/8' has host bits; the network is 10.0.0.0/8"},
        Wrong{"{\"protection\": {\"allow\": []}}",
              "1:17: 'allow' must be a list of networks such as \"192.168.2.0/24\""},
        Wrong{"{\"protection\": {\"allow\": [5]}}", "1:17: 'allow' is not sound: '5' is no IPv4 network; ..."},
        Wrong{"{\"protection\": {\"readonly\": true}}", "1:17: 'readonly' is not a setting; ..."}));

TEST(Config, ProgramsAndProfilesAreTheDrives) {
    const auto result = config(R"({"programs": {"7": ["REF", "G -5000", "WT 20"]},
                                   "profiles": {"2": [{"to": 100, "speed": 5000}, {"by": -7}]}})");
    ASSERT_EQ(result.memory.programs.at(7).size(), 3U);
    EXPECT_EQ(result.memory.programs.at(7)[1],
              (drive::ProgramStep{drive::ProgramStep::Kind::write, {0x65, 0x2B}, -5000}));
    const auto& parts = result.memory.profiles.at(2);
    ASSERT_EQ(parts.size(), 2U);
    EXPECT_EQ(parts[0].target, 100);
    EXPECT_EQ(parts[0].speed, 5000);
    EXPECT_FALSE(parts[0].relative);
    EXPECT_EQ(parts[1].target, -7);
    EXPECT_EQ(parts[1].acceleration, 1'000'000);
    EXPECT_TRUE(parts[1].relative);
}

TEST(Config, WrongProgramsAndProfilesHaveTheirPlace) {
    EXPECT_EQ(problem(R"({"programs": {"64": []}})"), "1:15: '64' must be a number from 1 to 63");
    EXPECT_EQ(problem(R"({"programs": {"1": "REF"}})"), "1:15: '1' must be a list in brackets");
    EXPECT_EQ(problem(R"({"programs": {"1": ["REF", "FLY 3"]}})"),
              "1:15: '1' has a wrong step 2: 'FLY' is no command with a number");
    EXPECT_EQ(problem(R"({"programs": {"1": [3]}})"),
              "1:15: '1' has a wrong step 1: it must be a text, such as \"G 10000\"");
    EXPECT_EQ(problem(R"({"profiles": {"6": []}})"), "1:15: '6' must be a number from 1 to 5");
    EXPECT_EQ(problem(R"({"profiles": {"1": [{"to": 1, "by": 2}]}})"),
              "1:21: needs either 'to', a position, or 'by', a distance");
    EXPECT_EQ(problem(R"({"profiles": {"1": [{"to": 1, "speed": 9}]}})"),
              "1:31: 'speed' must be a whole number from 10 to 100000000");
}

TEST(Config, ValuesAtTheirLimitsAreTaken) {
    EXPECT_EQ(problem(R"({"port": 65535, "limits": {"tcp_connections": 100000, "class3_connections": 65535}})"),
              "accepted");
    EXPECT_EQ(problem(R"({"identity": {"product_name": "12345678901234567890123456789012"}})"), "accepted");
    EXPECT_EQ(problem(R"({"values": {"SCurve": 1}})"), "accepted");
    EXPECT_EQ(problem(R"({"values": {"SCurve": 100}})"), "accepted");
    EXPECT_EQ(problem("\xEF\xBB\xBF{\"port\": 1}"), "accepted") << "a byte order mark";
}

TEST(Config, DeepNestingIsRefusedInBoundedTime) {
    std::string text = "{\"values\": ";
    for (int i = 0; i < 100'000; ++i) text += "{\"a\":";
    text += "1";
    text.append(100'001, '}');
    EXPECT_EQ(problem(text), "1:47: objects and arrays stand too deep in each other here");
    EXPECT_NE(problem(std::string(100'000, '[')), "accepted");
    EXPECT_EQ(problem(R"({"values": {"SCurve": {"a": {"b": [[1]]}}}})").substr(0, 5), "1:13:");
}

TEST(Config, TheWordsOfLogLevels) {
    EXPECT_EQ(log_level("trace"), LogLevel::trace);
    EXPECT_EQ(log_level("error"), LogLevel::error);
    EXPECT_EQ(log_level("Error"), std::nullopt);
    EXPECT_EQ(log_level(""), std::nullopt);
}

TEST(Config, ErrorsNameTheFile) {
    EXPECT_EQ(describe("drive.json", {3, 15, "'port' is wrong"}), "drive.json:3:15: 'port' is wrong");
    EXPECT_EQ(describe("drive.json", {0, 0, "cannot be read"}), "drive.json: cannot be read");
}

class ConfigFile : public testing::Test {
protected:
    void SetUp() override { std::filesystem::create_directories(directory_); }
    void TearDown() override { std::filesystem::remove_all(directory_); }

    std::filesystem::path file(const std::string& content) const {
        const auto path = directory_ / "drive.json";
        std::ofstream(path, std::ios::binary) << content;
        return path;
    }
    static std::string reason(const std::filesystem::path& path) {
        const auto loaded = load_config(path);
        const auto* error = std::get_if<FileError>(&loaded);
        if (error == nullptr) return "accepted";
        EXPECT_EQ(error->line, 0U);
        return error->reason;
    }

    const std::filesystem::path directory_ =
        std::filesystem::path(testing::TempDir()) /
        ("servobus_config_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
};

TEST_F(ConfigFile, IsLoaded) {
    const auto loaded = load_config(file(R"({"port": 5})"));
    ASSERT_TRUE(std::holds_alternative<Config>(loaded));
    EXPECT_EQ(std::get<Config>(loaded).port, 5);
}

TEST_F(ConfigFile, ThatIsMissing) { EXPECT_EQ(reason(directory_ / "none.json"), "cannot be read"); }

TEST_F(ConfigFile, ThatIsADirectory) { EXPECT_EQ(reason(directory_), "is a directory, not a file"); }

TEST_F(ConfigFile, ThatIsTooLarge) {
    constexpr std::size_t limit = std::size_t{1} << 20;
    EXPECT_EQ(reason(file("{}" + std::string(limit - 2, ' '))), "accepted");
    EXPECT_EQ(reason(file("{}" + std::string(limit - 1, ' '))), "is larger than 1048576 octets");
}

TEST_F(ConfigFile, TheEdsIsReadWhole) {
    const auto loaded = load_device_file(file("$ an EDS\r\n"));
    ASSERT_TRUE(std::holds_alternative<DeviceFile>(loaded));
    const auto& eds = std::get<DeviceFile>(loaded);
    EXPECT_EQ(eds.name, "drive.json");
    EXPECT_EQ(eds.content->size(), 10U);
    EXPECT_EQ(eds.major_revision, 1);
    EXPECT_EQ(eds.minor_revision, 0);
    EXPECT_TRUE(std::holds_alternative<FileError>(load_device_file(directory_ / "none.eds")));
}

// Tools compare attribute 5 of the File object with it before they upload.
TEST_F(ConfigFile, TheEdsSaysItsRevisionItself) {
    const auto loaded = load_device_file(file("[File]\r\nRevision = 3.7;\r\n"));
    EXPECT_EQ(std::get<DeviceFile>(loaded).major_revision, 3);
    EXPECT_EQ(std::get<DeviceFile>(loaded).minor_revision, 7);
}

TEST(GeneratedFiles, DescribeTheConfiguredDrive) {
    auto settings = config(R"({"variant": "48v8", "identity": {"minor_revision": 4, "product_name": "Press 7"},
                               "limits": {"listening_connections": 3, "class3_connections": 5}})");
    const auto files = generated_files(settings);
    EXPECT_EQ(files.eds->name, "XENAX_XVI_48V8_EtherNetIP.eds");
    const auto sheet =
        eds::read({reinterpret_cast<const char*>(files.eds->content->data()), files.eds->content->size()});
    ASSERT_TRUE(sheet);
    EXPECT_EQ(sheet->device.product_code, 0x4808);
    EXPECT_EQ(sheet->device.minor_revision, 4);
    EXPECT_EQ(sheet->device.product_name, "Press 7");
    EXPECT_EQ(sheet->capacity.io_connections, 4U);
    EXPECT_EQ(sheet->capacity.message_connections, 5U);
    EXPECT_EQ(sheet->file.revision, (eds::Revision{files.eds->major_revision, files.eds->minor_revision}));
    EXPECT_EQ(files.icon->name, sheet->device.icon);
    EXPECT_EQ(*files.icon->content, sheet->device.icon_content);
}

}  // namespace
}  // namespace servobus::adapter
