// One target as libFuzzer wants it; the build says which. The input is in a heap buffer of exactly its size, so that the
// address sanitizer sees whoever reads past its end.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    servobus::fuzz::SERVOBUS_FUZZ_TARGET({data, size});
    return 0;
}
