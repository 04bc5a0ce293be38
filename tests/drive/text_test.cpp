#include "drive/text.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>

#include "drive/xenax.hpp"

namespace servobus::drive {
namespace {

const Parameter& row(std::uint16_t class_id, std::uint16_t attribute) {
    static const Store store(parameters());
    return *store.find({class_id, attribute});
}

const Parameter& scurve() { return row(0x64, 0x00); }        // DINT
const Parameter& controlword() { return row(0x66, 0x00); }   // INT, bits
const Parameter& limit_iforce() { return row(0x66, 0x33); }  // INT
const Parameter& ip_address() { return row(0x65, 0xBB); }    // DINT, IPv4
const Parameter& name() { return row(0x69, 0x02); }          // text

std::string written(const Parameter& parameter, std::int64_t number) { return format(parameter, Value{number}); }

std::int64_t parsed(const Parameter& parameter, std::string_view text) {
    const auto result = parse(parameter, text);
    EXPECT_TRUE(std::holds_alternative<Value>(result)) << text << ": " << std::get<ParseError>(result).reason;
    return std::get<std::int64_t>(std::get<Value>(result));
}

bool refused(const Parameter& parameter, std::string_view text) {
    return std::holds_alternative<ParseError>(parse(parameter, text));
}

TEST(Format, WritesNumbersInDecimal) {
    EXPECT_EQ(written(scurve(), 20), "20");
    EXPECT_EQ(written(scurve(), -20), "-20");
}

TEST(Format, WritesBitsInHexWithTheWidthOfTheirType) {
    EXPECT_EQ(written(row(0x66, 0x01), 0x0250), "0x0250 (592)");
    EXPECT_EQ(written(controlword(), -32753), "0x800F (-32753)");
    EXPECT_EQ(written(row(0x66, 0xBD), 0x00030000), "0x00030000 (196608)");
    EXPECT_EQ(written(row(0x66, 0xC3), 0x000100A1), "0x000100A1 (65697)");
}

TEST(Format, WritesAddressesWithDots) {
    EXPECT_EQ(written(ip_address(), -1062731164), "192.168.2.100");
    EXPECT_EQ(written(row(0x65, 0xBC), -1024), "255.255.252.0");
}

TEST(Format, WritesTextAsItIs) { EXPECT_EQ(format(name(), Value{std::string(" axis 1")}), " axis 1"); }

TEST(Parse, ReadsDecimalHexAndBinary) {
    EXPECT_EQ(parsed(scurve(), "50"), 50);
    EXPECT_EQ(parsed(scurve(), " +50 "), 50);
    EXPECT_EQ(parsed(scurve(), "-50"), -50);
    EXPECT_EQ(parsed(scurve(), "0x32"), 50);
    EXPECT_EQ(parsed(scurve(), "0B110010"), 50);
    EXPECT_EQ(parsed(scurve(), "-0X32"), -50);
}

TEST(Parse, LeavesLimitsToTheDevice) { EXPECT_EQ(parsed(scurve(), "101"), 101); }

TEST(Parse, KeepsNumbersInsideTheTypeOfTheRow) {
    EXPECT_EQ(parsed(limit_iforce(), "32767"), 32767);
    EXPECT_EQ(parsed(limit_iforce(), "-32768"), -32768);
    EXPECT_TRUE(refused(limit_iforce(), "32768"));
    EXPECT_TRUE(refused(limit_iforce(), "-32769"));
    EXPECT_TRUE(refused(limit_iforce(), "0xFFFF"));  // a number, not a bit pattern
    EXPECT_TRUE(refused(row(0x66, 0x5A), "-1"));     // UDINT
    EXPECT_EQ(parsed(row(0x66, 0x5A), "4294967295"), 4294967295);
    EXPECT_TRUE(refused(row(0x66, 0x5A), "4294967296"));
    EXPECT_TRUE(refused(scurve(), "99999999999999999999999999"));
    EXPECT_TRUE(refused(scurve(), "-99999999999999999999999999"));
}

TEST(Parse, TakesBitPatternsUnsigned) {
    EXPECT_EQ(parsed(controlword(), "0x800F"), -32753);
    EXPECT_EQ(parsed(controlword(), "65535"), -1);
    EXPECT_EQ(parsed(controlword(), "-1"), -1);
    EXPECT_EQ(parsed(controlword(), "0b1111"), 15);
    EXPECT_TRUE(refused(controlword(), "0x10000"));
    EXPECT_EQ(parsed(row(0x66, 0xBF), "0xFFFFFFFF"), -1);
}

TEST(Parse, TakesAddresses) {
    EXPECT_EQ(parsed(ip_address(), "192.168.2.100"), -1062731164);
    EXPECT_EQ(parsed(ip_address(), "0.0.0.0"), 0);
    EXPECT_EQ(parsed(ip_address(), "255.255.255.255"), -1);
    EXPECT_EQ(parsed(ip_address(), "0xC0A80264"), -1062731164);
    for (const char* text : {"192.168.2", "192.168.2.100.1", "192.168.2.256", "192.168..1", "192.168.2.", "a.b.c.d",
                             "192.168.2.-1", "192.168.2.1000"}) {
        EXPECT_TRUE(refused(ip_address(), text)) << text;
    }
    EXPECT_TRUE(refused(scurve(), "192.168.2.100"));
}

TEST(Parse, RefusesWhatIsNoNumber) {
    for (const char* text : {"", " ", "-", "+", "0x", "0b", "0b2", "12a", "1.5", "1 2", "--1", "0x-1", "- 1", "x12"}) {
        EXPECT_TRUE(refused(scurve(), text)) << text;
    }
}

TEST(Parse, SaysWhatIsWrong) {
    EXPECT_EQ(std::get<ParseError>(parse(scurve(), "abc")).reason, "'abc' is no number (decimal, 0x hex or 0b binary)");
    EXPECT_EQ(std::get<ParseError>(parse(limit_iforce(), "40000")).reason,
              "'40000' does not fit into 16 bits, which hold -32768 to 32767");
    EXPECT_EQ(std::get<ParseError>(parse(ip_address(), "1.2")).reason, "'1.2' is no address like 192.168.2.100");
}

TEST(Parse, TakesAnyTextForAText) {
    EXPECT_EQ(std::get<Value>(parse(name(), " axis 0x1 ")), Value{std::string(" axis 0x1 ")});
    EXPECT_EQ(std::get<Value>(parse(name(), "")), Value{std::string()});
}

TEST(Parse, ReadsWhatFormatWrote) {
    for (const Parameter& each : parameters()) {
        if (each.is_text()) {
            continue;
        }
        for (const std::int64_t number : {each.low, each.standard, each.high}) {
            const std::string text = written(each, number);
            EXPECT_EQ(parsed(each, text.substr(0, text.find(' '))), number) << each.name;
        }
    }
}

TEST(ParseNumber, HoldsWhat64BitsHold) {
    constexpr auto largest = std::numeric_limits<std::int64_t>::max();
    EXPECT_EQ(parse_number("9223372036854775807"), largest);
    EXPECT_EQ(parse_number("9223372036854775808"), largest);
    EXPECT_EQ(parse_number("-9223372036854775808"), -largest);
    EXPECT_EQ(parse_number("0xFFFFFFFFFFFFFFFFFF"), largest);
    EXPECT_EQ(parse_number("nine"), std::nullopt);
}

}  // namespace
}  // namespace servobus::drive
