#include "eds/field_values.hpp"

#include <gtest/gtest.h>

#include "eds/base64.hpp"

namespace servobus::eds {
namespace {

Field word(std::string_view value) { return {Field::Kind::word, std::string(value), 1}; }
Field quoted(std::string_view value) { return {Field::Kind::text, std::string(value), 1}; }

TEST(FieldValues, Integers) {
    EXPECT_EQ(integer(word("29961")), 29961);
    EXPECT_EQ(integer(word("-5")), -5);
    EXPECT_EQ(integer(word("+5")), 5);
    EXPECT_EQ(integer(word("0x04010002")), 0x04010002);
    EXPECT_EQ(integer(word("0X44240405")), 0x44240405) << "as a Schneider sheet writes it";
    EXPECT_EQ(integer(word("0b1010")), 10);
    EXPECT_EQ(integer(word("007")), 7);
    EXPECT_EQ(integer(word("0xFFFFFFFFFFFFFFFF")), -1) << "64 bits of a ULINT";
    EXPECT_EQ(integer(word("-9223372036854775808")), std::numeric_limits<std::int64_t>::min());
    for (const auto* none : {"", "-", "0x", "0b2", "1.5", "12a", "1 2", "0x1G", "18446744073709551616",
                             "-9223372036854775809", "--1", "Param1"}) {
        EXPECT_EQ(integer(word(none)), std::nullopt) << none;
    }
    EXPECT_EQ(integer(quoted("5")), std::nullopt);
    EXPECT_EQ(integer(Field{}), std::nullopt);
}

TEST(FieldValues, IntegersOfAType) {
    EXPECT_EQ(integer_as<std::uint8_t>(word("255")), 255);
    EXPECT_EQ(integer_as<std::uint8_t>(word("256")), std::nullopt);
    EXPECT_EQ(integer_as<std::uint16_t>(word("-1")), std::nullopt);
    EXPECT_EQ(integer_as<std::uint32_t>(word("0xFFFFFFFF")), 0xFFFFFFFF);
    EXPECT_EQ(integer_as<std::uint32_t>(word("0x100000000")), std::nullopt);
}

TEST(FieldValues, Reals) {
    EXPECT_EQ(real(word(".004")), 0.004) << "ConnOverhead";
    EXPECT_EQ(real(word("-1.5")), -1.5);
    EXPECT_EQ(real(word("+2")), 2.0);
    EXPECT_EQ(real(word("1e3")), 1000.0);
    EXPECT_EQ(real(word("0x10")), 16.0);
    for (const auto* none : {"", "nan", "inf", "1.2.3", "x"}) EXPECT_EQ(real(word(none)), std::nullopt) << none;
}

TEST(FieldValues, Revisions) {
    EXPECT_EQ(revision(word("1.0")), (Revision{1, 0}));
    EXPECT_EQ(revision(word("1.12")), (Revision{1, 12}));
    EXPECT_EQ(revision(word("3")), (Revision{3, 0}));
    for (const auto* none : {"", "1.", ".1", "1.0.0", "256.0", "a.b"}) {
        EXPECT_EQ(revision(word(none)), std::nullopt) << none;
    }
}

TEST(FieldValues, Dates) {
    using namespace std::chrono;
    EXPECT_EQ(date(word("11-21-2025")), 2025y / 11 / 21);
    EXPECT_EQ(date(word("06-6-2001")), 2001y / 6 / 6) << "as a Rockwell sheet writes it";
    EXPECT_EQ(date(word("02-29-2024")), 2024y / 2 / 29);
    EXPECT_EQ(date(word("01-02-94")), 1994y / 1 / 2);
    EXPECT_EQ(date(word("01-02-93")), 2093y / 1 / 2);
    for (const auto* none :
         {"", "21-11-2025", "02-29-2025", "11/21/2025", "11-21", "11-21-2025-1", "a-b-c", "257-01-2025", "1-1-99999"}) {
        EXPECT_EQ(date(word(none)), std::nullopt) << none;
    }
}

TEST(FieldValues, Times) {
    EXPECT_EQ(time_of_day(word("12:34:56")), std::chrono::seconds(45'296));
    EXPECT_EQ(time_of_day(word("9:42:00")), std::chrono::seconds(34'920));
    for (const auto* none : {"", "24:00:00", "12:60:00", "12:00:60", "12:00", "noon"}) {
        EXPECT_EQ(time_of_day(word(none)), std::nullopt) << none;
    }
}

TEST(FieldValues, References) {
    EXPECT_EQ(parameter_reference(word("Param12")), 12U);
    EXPECT_EQ(parameter_reference(word("param12")), 12U);
    for (const auto* none : {"Param", "Param1x", "Param-1", "ParamClass", "12", "Param99999999999"}) {
        EXPECT_EQ(parameter_reference(word(none)), std::nullopt) << none;
    }
    EXPECT_EQ(parameter_reference(quoted("Param12")), std::nullopt);
}

// RFC 4648 §10.
TEST(Base64, ThereAndBack) {
    const std::pair<std::string, std::string> vectors[] = {{"", ""},
                                                           {"f", "Zg=="},
                                                           {"fo", "Zm8="},
                                                           {"foo", "Zm9v"},
                                                           {"foob", "Zm9vYg=="},
                                                           {"fooba", "Zm9vYmE="},
                                                           {"foobar", "Zm9vYmFy"}};
    for (const auto& [plain, coded] : vectors) {
        const cip::Bytes octets(plain.begin(), plain.end());
        EXPECT_EQ(to_base64(octets), coded);
        EXPECT_EQ(from_base64(coded), octets);
    }
    EXPECT_EQ(from_base64("Zm9v\r\n YmFy"), (cip::Bytes{'f', 'o', 'o', 'b', 'a', 'r'}));
    EXPECT_EQ(from_base64("Zg"), cip::Bytes{'f'}) << "without padding";
    for (const auto* none : {"Z", "Zm9vY", "Zg==Zg==", "Zm9*", "=Zg"})
        EXPECT_EQ(from_base64(none), std::nullopt) << none;
}

}  // namespace
}  // namespace servobus::eds
