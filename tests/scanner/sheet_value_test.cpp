// Values of a data sheet's parameters for people (R-EDS-5).
#include "scanner/sheet_value.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scanner/sample_sheet.hpp"
#include "tests/support/octets.hpp"

namespace servobus::scanner {
namespace {

using servobus::test::hex;
using servobus::test::octets;
using testing::HasSubstr;

class SheetValue : public testing::Test {
protected:
    const eds::Parameter& parameter(std::uint32_t number) { return *sheet_.parameter(number); }
    std::string shown(std::uint32_t number, std::string_view text) {
        const auto value = decode(parameter(number), octets(text));
        return value ? value_text(parameter(number), *value) : "nothing";
    }
    /// The octets that are sent for what a person typed, or why none.
    std::string sent(std::uint32_t number, std::string_view text) {
        const auto value = parse_value(parameter(number), text);
        return value ? hex(*parameter(number).encode(*value)) : value.error().text;
    }
    bool allowed(std::uint32_t number, std::string_view text) {
        return within_limits(parameter(number), *parse_value(parameter(number), text));
    }

private:
    eds::DataSheet sheet_ = test::valve();
};

TEST_F(SheetValue, IsShownInTheUnitsOfTheSheet) {
    EXPECT_EQ(shown(1, "FA 00"), "25.0");
    EXPECT_EQ(shown(1, "FF FF"), "-0.1");
    EXPECT_EQ(shown(2, "02"), "2 (Auto matic)");
    EXPECT_EQ(shown(2, "07"), "7");
    EXPECT_EQ(shown(3, "37 06"), "0x0637 (1591)");
    EXPECT_EQ(shown(4, "00 00 20 40"), "2.50");
    EXPECT_EQ(shown(5, "03 61 62 63"), "abc");
    EXPECT_EQ(shown(7, "01"), "1");
    EXPECT_EQ(shown(9, "FF FF FF FF FF FF FF FF"), "18446744073709551615");
}

TEST_F(SheetValue, OfAnotherSizeIsNone) {
    EXPECT_EQ(shown(1, "FA"), "nothing");
    EXPECT_EQ(shown(1, "FA 00 00"), "nothing");
    EXPECT_EQ(shown(5, "03 61 62"), "nothing");
    EXPECT_EQ(shown(5, ""), "nothing");
    EXPECT_EQ(value_octets(parameter(5), octets("03 61 62 63 64")), 4U);
    EXPECT_EQ(value_octets(parameter(1), {}), 2U);
}

TEST_F(SheetValue, IsReadInTheUnitsOfTheSheet) {
    EXPECT_EQ(sent(1, "25"), "FA 00");
    EXPECT_EQ(sent(1, "2.5"), "19 00");
    EXPECT_EQ(sent(1, "-0.1"), "FF FF");
    EXPECT_EQ(sent(1, "0x19"), "19 00") << "the bits as they are sent";
    EXPECT_EQ(sent(2, "auto MATIC"), "02");
    EXPECT_EQ(sent(2, "1"), "01");
    EXPECT_EQ(sent(3, "0b101"), "05 00");
    EXPECT_EQ(sent(4, "2.5"), "00 00 20 40");
    EXPECT_EQ(sent(4, "1e1"), "00 00 20 41");
    EXPECT_EQ(sent(5, "abc"), "03 61 62 63");
    EXPECT_EQ(sent(9, "18446744073709551615"), "FF FF FF FF FF FF FF FF");
}

TEST_F(SheetValue, WhatItCannotBe) {
    EXPECT_EQ(sent(1, "2.55"), "'2.55' is between two steps; 2.5 and 2.6 are the nearest");
    EXPECT_EQ(sent(1, "4000"), "'4000' does not fit INT");
    EXPECT_EQ(sent(1, "many"), "'many' is no number");
    EXPECT_EQ(sent(1, "nan"), "'nan' is no number");
    EXPECT_EQ(sent(1, "1e300"), "'1e300' is too large");
    EXPECT_EQ(sent(2, "Of"), "'Of' is none of Off (0), On (1), Auto matic (2)");
    EXPECT_EQ(sent(2, "256"), "'256' does not fit USINT");
    EXPECT_EQ(sent(3, "-1"), "'-1' does not fit WORD");
    EXPECT_EQ(sent(3, ""), "'' is no WORD");
    EXPECT_EQ(sent(4, "1,5"), "'1,5' is no REAL");
}

TEST_F(SheetValue, LimitsAreThoseOfTheSheet) {
    EXPECT_TRUE(allowed(1, "-10"));
    EXPECT_FALSE(allowed(1, "-10.1"));
    EXPECT_TRUE(allowed(1, "100"));
    EXPECT_FALSE(allowed(1, "100.1"));
    EXPECT_FALSE(allowed(2, "3"));
    EXPECT_TRUE(allowed(4, "100"));
    EXPECT_FALSE(allowed(4, "100.5"));
    EXPECT_TRUE(allowed(5, std::string(32, 'x')));
    EXPECT_FALSE(allowed(5, std::string(33, 'x')));
    EXPECT_TRUE(allowed(9, "18446744073709551615")) << "a parameter without limits";
    EXPECT_EQ(limits_text(parameter(1)), "-10.0 to 100.0 bar");
    EXPECT_EQ(limits_text(parameter(2)), "Off (0), On (1), Auto matic (2)");
    EXPECT_EQ(limits_text(parameter(3)), "0 to 65535");
    EXPECT_EQ(limits_text(parameter(4)), "0.00 to 100.00 l/min");
    EXPECT_EQ(limits_text(parameter(5)), "at most 32 characters");
    EXPECT_EQ(limits_text(parameter(9)), "");
}

TEST_F(SheetValue, LimitsOfUnsigned64BitsAreUnsigned) {
    auto counter = parameter(9);
    counter.minimum = std::int64_t{1};
    counter.maximum = static_cast<std::int64_t>(0xFFFFFFFFFFFFFFFE);
    EXPECT_TRUE(within_limits(counter, static_cast<std::int64_t>(0xFFFFFFFFFFFFFFFE)));
    EXPECT_FALSE(within_limits(counter, static_cast<std::int64_t>(0xFFFFFFFFFFFFFFFF)));
    EXPECT_FALSE(within_limits(counter, std::int64_t{0}));
}

TEST(SheetTypes, HaveNames) {
    EXPECT_EQ(type_name(cip::DataType::DINT), "DINT");
    EXPECT_EQ(type_name(static_cast<cip::DataType>(0xA0)), "type 0xA0");
}

}  // namespace
}  // namespace servobus::scanner
