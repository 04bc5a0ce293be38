// The sheets in tests/eds/sheets, which the fuzzer begins with too.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

namespace servobus::test {

inline std::string sheet(const std::string& name) {
    std::ifstream file(std::string(SERVOBUS_TEST_DATA) + "/eds/sheets/" + name, std::ios::binary);
    EXPECT_TRUE(file) << name;
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace servobus::test
