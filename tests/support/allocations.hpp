// How often the program has asked for memory. Counting begins with the executable that links allocations.cpp, which
// replaces the global operator new.
#pragma once

#include <cstddef>

namespace servobus::test {

[[nodiscard]] std::size_t allocations();

}  // namespace servobus::test
