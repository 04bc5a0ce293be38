#include "scanner/cli/what.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drive/xenax.hpp"
#include "tests/scanner/fake_server.hpp"

namespace servobus::scanner::cli {
namespace {

using test::hex;
using testing::AllOf;
using testing::HasSubstr;

std::string address_of(std::string_view text) {
    const auto what = parse_what(text);
    if (!what) return what.error().text;
    return what->row() != nullptr ? cip_address(*what->row()) : "raw " + cip_address(std::get<Attribute>(what->target));
}

TEST(What, IsANameAMnemonicOrAnAddress) {
    for (const auto* text :
         {"SCurve", "scurve", "SCRV", "general.SCurve", "0x64.scrv", "@0x64/1/0x00", "0x64/1/0", "100/1/0"}) {
        EXPECT_EQ(address_of(text), "0x64/1/0x00") << text;
    }
    EXPECT_EQ(address_of("drive.Controlword"), "0x66/1/0x00");
    EXPECT_EQ(address_of("TS"), "0x65/1/0x02");
}

TEST(What, MayBeAnyAttribute) {
    EXPECT_EQ(address_of("0x01/1/7"), "raw 0x01/1/0x07");
    EXPECT_EQ(address_of("@0x64/2/0"), "raw 0x64/2/0x00") << "the drive's parameters are in instance 1";
    EXPECT_EQ(address_of("0x64/1/0x10000"), "raw 0x64/1/0x10000");
    EXPECT_EQ(address_of("0xFFFF/0xFFFFFFFF/0xFFFFFFFF"), "raw 0xFFFF/4294967295/0xFFFFFFFF");
}

TEST(What, IsNothingElse) {
    EXPECT_THAT(address_of("SCurv"),
                AllOf(HasSubstr("no parameter is called 'SCurv'"), HasSubstr("did you mean SCurve")));
    EXPECT_THAT(address_of("qqqqqqqqqqqq"), HasSubstr("servobus-scanner list"));
    for (const auto* text : {"0x64/1", "0x64/1/", "/1/1", "0x10000/1/1", "0x64/1/0x100000000", "0x64/1/-1", "1/2/3/4",
                             "@", "@SCurve", "x/1/1"}) {
        EXPECT_THAT(address_of(text), HasSubstr("is no address")) << text;
    }
    EXPECT_THAT(address_of(""), HasSubstr("no parameter"));
}

TEST(What, NamesEveryRow) {
    for (const auto& row : drive::parameters()) {
        const auto what = parse_what(display_name(row));
        ASSERT_TRUE(what) << row.name;
        EXPECT_EQ(what->row(), &row) << row.name;
        EXPECT_EQ(parse_what(cip_address(row))->row(), &row);
    }
}

TEST(What, SaysWhenANameIsAmbiguous) {
    std::size_t ambiguous = 0;
    for (const auto& row : drive::parameters()) {
        if (row.mnemonic.empty()) continue;
        const auto what = parse_what(row.mnemonic);
        if (what) continue;
        ++ambiguous;
        EXPECT_THAT(what.error().text, AllOf(HasSubstr("parameters; write "), HasSubstr(" or "), HasSubstr(".")));
    }
    SUCCEED() << ambiguous;
}

TEST(Assignment, HasAValueOfTheRow) {
    const auto scurve = parse_assignment("SCurve=500");
    ASSERT_TRUE(scurve);
    EXPECT_EQ(std::get<drive::Value>(scurve->value), drive::Value(500)) << "limits are the device's affair";
    EXPECT_EQ(std::get<drive::Value>(parse_assignment("SID=a=b")->value), drive::Value("a=b"));
    EXPECT_EQ(std::get<drive::Value>(parse_assignment("SID=hex:41")->value), drive::Value("hex:41"));
    EXPECT_EQ(std::get<drive::Value>(parse_assignment("0x64/1/0=0x1F")->value), drive::Value(31));
    EXPECT_EQ(std::get<drive::Value>(parse_assignment("SID=")->value), drive::Value(""));
}

TEST(Assignment, HasOctetsByAddress) {
    EXPECT_EQ(std::get<cip::Bytes>(parse_assignment("@0x64/1/0=hex:32 00")->value), hex("32 00"));
    EXPECT_EQ(std::get<cip::Bytes>(parse_assignment("0xF5/1/13=UINT:60")->value), hex("3C 00"));
}

TEST(Assignment, SaysWhatIsWrong) {
    const auto mistake = [](std::string_view text) {
        const auto assignment = parse_assignment(text);
        return assignment ? std::string() : assignment.error().text;
    };
    EXPECT_THAT(mistake("SCurve"), HasSubstr("WHAT=VALUE"));
    EXPECT_THAT(mistake("SCurve="), HasSubstr("is no number"));
    EXPECT_THAT(mistake("SCurve=x"), HasSubstr("SCurve: 'x' is no number"));
    EXPECT_THAT(mistake("SCurve=2147483648"), HasSubstr("does not fit"));
    EXPECT_THAT(mistake("SCurv=1"), HasSubstr("did you mean SCurve"));
    EXPECT_THAT(mistake("0xF5/1/13=60"), HasSubstr("DINT:50"));
    EXPECT_THAT(mistake("0xF5/1/13=UINT:65536"), HasSubstr("UINT"));
}

TEST(Path, IsAnAddressAnEpathOrAName) {
    EXPECT_EQ(parse_path("0x66/1/0x24")->encode(), hex("20 66 24 01 30 24"));
    EXPECT_EQ(parse_path("@0x66/1/0x24")->encode(), hex("20 66 24 01 30 24"));
    EXPECT_EQ(parse_path("1/0")->encode(), hex("20 01 24 00"));
    EXPECT_EQ(parse_path("0x300/0x1234")->encode(), hex("21 00 00 03 25 00 34 12"));
    EXPECT_EQ(parse_path("hex:20 66 24 01")->encode(), hex("20 66 24 01"));
    EXPECT_EQ(parse_path("hex:")->encode(), hex(""));
    EXPECT_EQ(parse_path("SCurve")->encode(), hex("20 64 24 01 30 00"));
    for (const auto* text :
         {"hex:20", "hex:2", "hex:xx", "hex:E0 00", "hex:20 66 25 00", "1/", "/", "1/2/3/4", "Nobody", ""}) {
        EXPECT_FALSE(parse_path(text)) << text;
    }
}

TEST(Limits, AreInTheWordsOfTheRow) {
    EXPECT_EQ(limits_text(*parse_what("SCurve")->row()), "1 to 100 %");
    EXPECT_EQ(limits_text(*parse_what("SID")->row()), "at most 32 characters");
    EXPECT_EQ(limits_text(*parse_what("ReferenceMethods")->row()), "1, 2, 3, 4, 5, 6, 10, 11, 12, 13, 14, 15");
}

}  // namespace
}  // namespace servobus::scanner::cli
