// Results as text and as JSON.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cip/services.hpp"
#include "drive/xenax.hpp"
#include "scanner/cli/json_output.hpp"
#include "scanner/cli/table.hpp"
#include "scanner/cli/text_output.hpp"
#include "tests/scanner/fake_server.hpp"

namespace servobus::scanner::cli {
namespace {

using nlohmann::json;
using test::hex;
using testing::HasSubstr;
using testing::StartsWith;

Outcome outcome(std::string_view what, decltype(Outcome::result) result, std::size_t surplus = 0) {
    return {*parse_what(what), std::move(result), surplus};
}

const cip::Status out_of_limits = cip::GeneralStatus::invalid_attribute_value;

TEST(Text, ShowsValuesWithUnitAndBothAddresses) {
    EXPECT_EQ(value_text(outcome("SCurve", drive::Value(20))), "SCurve = 20 %  (CIP 0x64/1/0x00, CANopen 0x2000:00)\n");
    EXPECT_EQ(value_text(outcome("MotorType", drive::Value("rotative"))),
              "MotorType = rotative  (CIP 0x64/1/0x08, CANopen 0x2008:00)\n");
    EXPECT_EQ(value_text(outcome("0x6E/1/4", drive::Value(1))),
              "SignateqMeasurementRangeNegative = 1 mN  (CIP 0x6E/1/0x04)\n");
    EXPECT_EQ(value_text(outcome("0x01/1/1", hex("6D 05"))), "0x01/1/0x01 = 6D 05  (vendor 1389 (Jenny Science AG))\n");
    EXPECT_EQ(value_text(outcome("0x99/1/1", hex("6D 05"))), "0x99/1/0x01 = 6D 05\n");
    EXPECT_EQ(value_text(outcome("0x99/1/1", cip::Bytes{})), "0x99/1/0x01 = (no data)\n");
    EXPECT_EQ(value_text(outcome("SCurve", out_of_limits)), "");
}

TEST(Text, SaysWhyThereIsNoValue) {
    EXPECT_EQ(refusal_text(outcome("SCurve", out_of_limits)),
              "SCurve: refused with 0x09 invalid attribute value; it takes 1 to 100 %\n");
    EXPECT_EQ(refusal_text(outcome("Statusword", cip::Status(cip::GeneralStatus::attribute_not_settable))),
              "Statusword: refused with 0x0E attribute not settable; it is read only\n");
    EXPECT_EQ(refusal_text(outcome("DirectCommands", cip::Status(cip::GeneralStatus::attribute_not_gettable))),
              "DirectCommands: refused with 0x2C attribute not gettable; it is write only\n");
    EXPECT_THAT(refusal_text(outcome("LimitForce", cip::Status(cip::GeneralStatus::vendor_specific, {1}))),
                testing::AllOf(HasSubstr("0x1F"), HasSubstr("0x0001"), HasSubstr("Signateq")));
    EXPECT_EQ(refusal_text(outcome("SCurve", make_error_code(Error::missing_data))),
              "SCurve: the value in the reply is shorter than its type\n");
    EXPECT_EQ(refusal_text(outcome("SCurve", NotAsked{"not set"})), "SCurve: not set\n");
    EXPECT_EQ(refusal_text(outcome("SCurve", drive::Value(20))), "");
    EXPECT_THAT(warning_text(outcome("SCurve", drive::Value(20), 2)), HasSubstr("2 surplus octets"));
}

TEST(Text, IsSafeForATerminal) {
    EXPECT_EQ(printable("XENAX \xC3\xA4"), "XENAX \xC3\xA4");
    EXPECT_EQ(printable("\xE4"), "\xC3\xA4") << "ISO 8859-1";
    EXPECT_EQ(printable("a\x1B[31mb\n\x7F"), "a\\x1B[31mb\\x0A\\x7F");
    EXPECT_EQ(printable("\x9B"), "\\x9B");
    EXPECT_EQ(printable("\xC2\x9B"), "\xC3\x82\\x9B") << "a control character in UTF-8";
    EXPECT_EQ(printable("\xE2\x82\xAC\xF0\x9F\x98\x80"), "\xE2\x82\xAC\xF0\x9F\x98\x80");
    EXPECT_EQ(printable("\xE2\x82"), "\xC3\xA2\\x82");
    EXPECT_EQ(printable(std::string_view("\0", 1)), "\\x00");
}

TEST(Text, LinesUp) {
    Table table({"A", "LONG"});
    table.add({"1", ""});
    table.add({"\xC3\xA4\xC3\xA4\xC3\xA4", "x"});
    EXPECT_EQ(table.text(), "A    LONG\n1\n\xC3\xA4\xC3\xA4\xC3\xA4  x\n");
}

TEST(Text, DumpsHex) {
    EXPECT_EQ(hex_dump(hex("00 41 7F")), "0000    00 41 7F                                         .A.\n");
    cip::Bytes octets(17, 0x42);
    EXPECT_EQ(hex_dump(octets),
              "0000    42 42 42 42 42 42 42 42 42 42 42 42 42 42 42 42  BBBBBBBBBBBBBBBB\n"
              "0010    42                                               B\n");
    EXPECT_EQ(hex_dump({}), "");
}

TEST(Text, DumpsByClass) {
    const auto text = dump_text({outcome("SCurve", drive::Value(20)), outcome("DirectCommands", NotAsked{"write only"}),
                                 outcome("LimitForce", cip::Status(cip::GeneralStatus::vendor_specific, {1}))});
    EXPECT_THAT(text, StartsWith("0x64 XENAX General Parameter (general)\nNAME"));
    EXPECT_THAT(text, HasSubstr("\n\n0x65 XENAX Command (command)\n"));
    EXPECT_THAT(text, testing::ContainsRegex("SCurve +SCRV +20 +% +get/set +1 to 100 +0x64/1/0x00 +0x2000:00\n"));
    EXPECT_THAT(text, testing::ContainsRegex("DirectCommands +- +set +0x65/1/0x00 +0x5000:00 +write only\n"));
    EXPECT_THAT(text, testing::ContainsRegex("LimitForce +LF +- +mN .*refused: 0x1F"));
}

TEST(Text, ShowsACallsStatusAndData) {
    CallResult result{{0x0E, cip::Path::to(0x64, 1, 0), {}}, {0x0E, {}, hex("14 00 00 00")}};
    EXPECT_THAT(call_text(result), StartsWith("status  0x00 success\n0000    14 00 00 00 "));
    result.response = {0x0E, cip::GeneralStatus::path_destination_unknown, {}};
    EXPECT_EQ(call_text(result), "status  0x05 path destination unknown\n");
}

TEST(Json, HasTheDocumentedShape) {
    const auto document = json::parse(values_json("drive", {outcome("SCurve", drive::Value(20))}));
    EXPECT_EQ(document, json::parse(R"({"host": "drive", "values": [
        {"name": "SCurve", "qualified": "general.SCurve", "mnemonic": "SCRV", "value": 20, "unit": "%",
         "cip": "0x64/1/0x00", "canopen": "0x2000:00", "type": "DINT"}]})"));
}

TEST(Json, TellsErrorsOfValues) {
    const auto document = json::parse(
        values_json("drive",
                    {outcome("SCurve", cip::Status(cip::GeneralStatus::vendor_specific, {1})),
                     outcome("MotorType", make_error_code(Error::missing_data)), outcome("SID", NotAsked{"not asked"})},
                    Failure{ExitCode::no_connection, "gone"}));
    const auto& values = document["values"];
    EXPECT_EQ(values[0]["error"]["general"], 0x1F);
    EXPECT_EQ(values[0]["error"]["extended"], json::array({1}));
    EXPECT_THAT(values[0]["error"]["text"].get<std::string>(), StartsWith("0x1F vendor specific error"));
    EXPECT_FALSE(values[0].contains("value"));
    EXPECT_EQ(values[1]["error"]["kind"], "nonsense");
    EXPECT_EQ(values[2]["not_asked"], "not asked");
    EXPECT_EQ(document["error"], json::parse(R"({"kind": "no_connection", "text": "gone", "exit_code": 3})"));
}

TEST(Json, TellsRawValues) {
    const auto value = json::parse(values_json("drive", {outcome("0x01/1/7", hex("02 41 42"), 3)}))["values"][0];
    EXPECT_EQ(value["raw"], "02 41 42");
    EXPECT_TRUE(value["value"].is_null());
    EXPECT_TRUE(value["name"].is_null());
    EXPECT_EQ(value["cip"], "0x01/1/0x07");
    EXPECT_EQ(value["text"], "product name AB");
    EXPECT_EQ(value["surplus_octets"], 3);
}

TEST(Json, IsUtf8WhateverADeviceSends) {
    const auto document = values_json("drive", {outcome("MotorType", drive::Value("\xFF\x1B\xC3"))});
    EXPECT_EQ(json::parse(document)["values"][0]["value"], "\xC3\xBF\\x1B\xC3\x83");
}

TEST(Json, TellsDevices) {
    enip::IdentityItem item;
    item.vendor = 1389;
    item.product_name = "XENAX";
    item.major_revision = 1;
    item.minor_revision = 7;
    item.state = 3;
    const auto device = json::parse(devices_json({{"10.0.0.1", 44818, item}}))["devices"][0];
    EXPECT_EQ(device["address"], "10.0.0.1");
    EXPECT_EQ(device["vendor_name"], "Jenny Science AG");
    EXPECT_EQ(device["revision"], "1.7");
    EXPECT_EQ(device["state_text"], "operational");
}

TEST(ExitCodes, AreTheWorstOfAll) {
    const auto value = outcome("SCurve", drive::Value(1));
    const auto refused = outcome("SCurve", out_of_limits);
    const auto nonsense = outcome("SCurve", make_error_code(Error::missing_data));
    const auto lost = outcome("SCurve", make_error_code(Error::closed));
    const auto session = outcome("SCurve", make_error_code(enip::EncapsulationStatus::insufficient_memory));
    EXPECT_EQ(exit_code_of(std::vector<Outcome>{}), ExitCode::done);
    EXPECT_EQ(exit_code_of({value}), ExitCode::done);
    EXPECT_EQ(exit_code_of({value, refused}), ExitCode::refused);
    EXPECT_EQ(exit_code_of({value, session}), ExitCode::refused);
    EXPECT_EQ(exit_code_of({refused, nonsense}), ExitCode::nonsense);
    EXPECT_EQ(exit_code_of({nonsense, lost}), ExitCode::no_connection);
    EXPECT_EQ(dump_exit_code_of({value, refused}), ExitCode::done);
    EXPECT_EQ(dump_exit_code_of({refused, refused}), ExitCode::refused);
    EXPECT_EQ(dump_exit_code_of({value, nonsense}), ExitCode::nonsense);
}

}  // namespace
}  // namespace servobus::scanner::cli
