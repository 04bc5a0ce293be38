// Data sheets: as text, as what they mean, and by the lint.
#include <cstddef>
#include <cstdint>

#include "tests/support/every_sheet.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    servobus::test::read_everything({reinterpret_cast<const char*>(data), size});
    return 0;
}
