// One line for the terminal that tells how the drives of this process are: lights, owner, connections, state.
//
//     RUN * ERR - ST1 - ST2 - | owner 192.168.2.1 standard run | 2 I/O, 1 class 3 | Operation enabled
//     RUN 3 on, 5 blink | 2 owners | 6 I/O, 4 class 3 | 2 Operation enabled, 6 Switch on disabled
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "adapter/adapter.hpp"

namespace servobus::adapter {

/// Printable ASCII, at most `width` characters: of one drive with its lights as they shine now (`*` lit, `-` dark), of
/// several how many there are of each. Without drives it is empty.
[[nodiscard]] std::string status_line(std::span<const Adapter* const> drives, enip::Time now, std::size_t width);

}  // namespace servobus::adapter
