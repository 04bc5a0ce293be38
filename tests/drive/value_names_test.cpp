#include "drive/value_names.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "drive/xenax.hpp"

namespace servobus::drive {
namespace {

// Whoever lists the legal values of a row has a name for each, and none for a value that is not legal.
TEST(ValueNames, AreThoseOfTheListedValues) {
    const auto model = xenax_models()[0];
    std::size_t rows = 0;
    for (const auto& row : model.parameters) {
        const auto names = value_names(model, row);
        EXPECT_EQ(names.empty(), row.allowed.empty()) << row.name;
        if (names.empty()) continue;
        ++rows;
        EXPECT_TRUE(std::ranges::equal(names, row.allowed, {}, &ValueName::value)) << row.name;
        for (const auto& [value, name] : names) EXPECT_FALSE(name.empty()) << row.name << ' ' << value;
    }
    EXPECT_EQ(rows, 4U);
}

TEST(ValueNames, ByNumber) {
    EXPECT_EQ(name_of(mode_names(), -1), "jog mode");
    EXPECT_EQ(name_of(mode_names(), 3), "");
    EXPECT_EQ(name_of(reference_method_names(), 15), "start counter clockwise, then the shortest way to the Z-mark");
    EXPECT_EQ(name_of(reference_method_names(), 7), "");
}

}  // namespace
}  // namespace servobus::drive
