// Where the files are that tests read and the programs that they run. Compiled once, so that no other file of the tests
// depends on the directory that it is compiled in and a compiler cache serves every clone.
#pragma once

#include <string>
#include <string_view>

namespace servobus::test {

/// The path of a file below tests/.
[[nodiscard]] std::string data_path(std::string_view name);

/// The path of a program of this build.
[[nodiscard]] std::string program_path(std::string_view name);

}  // namespace servobus::test
