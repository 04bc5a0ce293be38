// The sheets in tests/eds/sheets, which the fuzzer begins with too.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include "tests/support/places.hpp"

namespace servobus::test {

inline std::string sheet(const std::string& name) {
    std::ifstream file(data_path("eds/sheets/" + name), std::ios::binary);
    EXPECT_TRUE(file) << name;
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace servobus::test
