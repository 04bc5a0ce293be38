// Data sheets: as text, as what they mean, and by the lint.
#include "tests/fuzz/targets.hpp"
#include "tests/support/every_sheet.hpp"

namespace servobus::fuzz {

void eds(cip::ByteView input) { test::read_everything({reinterpret_cast<const char*>(input.data()), input.size()}); }

}  // namespace servobus::fuzz
