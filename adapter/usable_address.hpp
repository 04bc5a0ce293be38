// Which IPv4 addresses a host may have, wherever they come from: a client that sets them, or a server that hands them out.
#pragma once

#include <cstdint>

#include "adapter/network_settings.hpp"

namespace servobus::adapter {

/// Whether a host may have this address in this subnet (R-TCP-6): neither 0.x, 127.x, class D or E, nor the subnet or its
/// broadcast; a mask without gaps; no gateway, or one in the subnet.
[[nodiscard]] bool is_usable(const InterfaceConfiguration& configuration);

/// The mask of the address' class, for a server that names none (RFC 950).
[[nodiscard]] std::uint32_t natural_mask(std::uint32_t address);

/// How many ones the mask begins with: the length of the subnet's prefix.
[[nodiscard]] unsigned prefix_length(std::uint32_t mask);

}  // namespace servobus::adapter
