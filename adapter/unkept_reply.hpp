// The reply to a write that was carried out and then could not be made to last.
#pragma once

#include "enip/encapsulation.hpp"

namespace servobus::adapter {

/// The same reply to a SendRRData or SendUnitData, with status 0x19 and without data in place of what it said. A
/// Multiple_Service_Packet or an attribute list fails as a whole, since all that it wrote is taken back.
[[nodiscard]] enip::Frame unkept(const enip::Frame& reply);

}  // namespace servobus::adapter
