#include "eds/path_pattern.hpp"

#include <gtest/gtest.h>

namespace servobus::eds {
namespace {

std::optional<PathPattern> pattern(std::string_view text) {
    return path_pattern({Field::Kind::text, std::string(text), 1});
}

TEST(PathPattern, Octets) {
    EXPECT_EQ(pattern("20 66 24 01 30 00")->octets(), (cip::Bytes{0x20, 0x66, 0x24, 0x01, 0x30, 0x00}));
    EXPECT_EQ(pattern("2066 2401")->octets(), (cip::Bytes{0x20, 0x66, 0x24, 0x01}));
    EXPECT_TRUE(pattern("")->empty());
    EXPECT_EQ(pattern("")->octets(), cip::Bytes{});
    EXPECT_EQ(pattern("20 6"), std::nullopt);
    EXPECT_EQ(pattern("20 xx"), std::nullopt);
}

TEST(PathPattern, ParamsAndSymbols) {
    const auto both = pattern("20 04 24 01 2C [Param6] 2C [Param5]");
    ASSERT_TRUE(both);
    EXPECT_EQ(both->parts,
              (std::vector<PathPattern::Part>{cip::Bytes{0x20, 0x04, 0x24, 0x01, 0x2C}, PathPattern::Parameter{6},
                                              cip::Bytes{0x2C}, PathPattern::Parameter{5}}));
    EXPECT_EQ(both->octets(), std::nullopt);
    EXPECT_EQ(pattern("2C[Param6]2C[Param5]")->parts.size(), 4U);
    EXPECT_EQ(path_pattern({Field::Kind::word, "SYMBOL_ANSI", 1})->parts,
              std::vector<PathPattern::Part>{PathPattern::Symbol{}});
}

TEST(PathPattern, Address) {
    EXPECT_EQ(attribute_address(*pattern("20 66 24 01 30 24")), (AttributeAddress{0x66, 1, 0x24}));
    EXPECT_EQ(attribute_address(*pattern("21 00 64 03 24 01 30 05")), (AttributeAddress{0x364, 1, 5})) << "padded";
    EXPECT_EQ(attribute_address(*pattern("21 64 03 24 01 30 05")), (AttributeAddress{0x364, 1, 5})) << "packed";
    EXPECT_EQ(attribute_address(*pattern("21 04 00 25 02 00 30 03")), (AttributeAddress{4, 2, 3}))
        << "packed, and as long as a padded one";
    EXPECT_EQ(attribute_address(*pattern("20 66 24 01")), std::nullopt);
    EXPECT_EQ(attribute_address(*pattern("20 04 2C 64 30 03")), std::nullopt) << "a connection point";
    EXPECT_EQ(attribute_address(*pattern("20 66 24 01 30")), std::nullopt);
    EXPECT_EQ(attribute_address(*pattern("20 66 24 01 [Param1]")), std::nullopt);
    EXPECT_EQ(attribute_address(PathPattern{}), std::nullopt);
}

}  // namespace
}  // namespace servobus::eds
