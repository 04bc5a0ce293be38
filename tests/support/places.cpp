#include "tests/support/places.hpp"

namespace servobus::test {

std::string data_path(std::string_view name) { return std::string(SERVOBUS_TEST_DATA "/") += name; }

std::string program_path(std::string_view name) { return std::string(SERVOBUS_BIN_DIR "/") += name; }

}  // namespace servobus::test
