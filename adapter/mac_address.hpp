// The address of an Ethernet port.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace servobus::adapter {

using MacAddress = std::array<std::uint8_t, 6>;

/// Everybody on the link.
inline constexpr MacAddress broadcast_mac{0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF};

/// `02:00:00:00:00:64`.
[[nodiscard]] std::string to_string(const MacAddress& mac);

}  // namespace servobus::adapter
