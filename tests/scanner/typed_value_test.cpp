#include "scanner/cli/typed_value.hpp"

#include <gtest/gtest.h>

#include "tests/scanner/fake_server.hpp"

namespace servobus::scanner::cli {
namespace {

using test::hex;

TEST(TypedValue, BecomesOctets) {
    const std::vector<std::pair<std::string, std::string_view>> values{
        {"hex:32 00", "32 00"},
        {"hex:", ""},
        {"HEX:3200", "32 00"},
        {"DINT:50", "32 00 00 00"},
        {"dint:-1", "FF FF FF FF"},
        {"DINT:0x10", "10 00 00 00"},
        {"DINT:-2147483648", "00 00 00 80"},
        {"SINT:-128", "80"},
        {"USINT:255", "FF"},
        {"INT:-2", "FE FF"},
        {"UINT:0b11", "03 00"},
        {"UDINT:4294967295", "FF FF FF FF"},
        {"LINT:-1", "FF FF FF FF FF FF FF FF"},
        {"ULINT:1", "01 00 00 00 00 00 00 00"},
        {"WORD:0x1234", "34 12"},
        {"BOOL:true", "01"},
        {"BOOL:0", "00"},
        {"REAL:1.5", "00 00 C0 3F"},
        {"LREAL:-2", "00 00 00 00 00 00 00 C0"},
        {"STRING:abc", "03 00 61 62 63"},
        {"STRING:", "00 00"},
        {"STRING:a:b", "03 00 61 3A 62"},
        {"SHORT_STRING:abc", "03 61 62 63"},
    };
    for (const auto& [text, octets] : values) {
        ASSERT_TRUE(has_type(text)) << text;
        const auto value = parse_typed(text);
        ASSERT_TRUE(value) << text;
        EXPECT_EQ(*value, hex(octets)) << text;
    }
}

TEST(TypedValue, FitsItsType) {
    for (const auto* text :
         {"hex:3", "hex:zz", "DINT:", "DINT:x", "DINT:2147483648", "DINT:-2147483649", "USINT:256", "USINT:-1",
          "SINT:128", "SINT:-129", "UINT:65536", "UDINT:4294967296", "BOOL:2", "REAL:", "REAL:1x"}) {
        ASSERT_TRUE(has_type(text)) << text;
        EXPECT_FALSE(parse_typed(text)) << text;
    }
    EXPECT_TRUE(parse_typed("STRING:" + std::string(65535, 'x')));
    EXPECT_FALSE(parse_typed("STRING:" + std::string(65536, 'x')));
    EXPECT_TRUE(parse_typed("SHORT_STRING:" + std::string(255, 'x')));
    EXPECT_FALSE(parse_typed("SHORT_STRING:" + std::string(256, 'x')));
}

TEST(TypedValue, HasAKnownType) {
    for (const auto* text : {"", "50", "FLOAT:1", ":1", "DINT 50"}) EXPECT_FALSE(has_type(text)) << text;
    EXPECT_FALSE(parse_typed("FLOAT:1"));
}

}  // namespace
}  // namespace servobus::scanner::cli
