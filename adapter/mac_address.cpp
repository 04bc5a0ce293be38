#include "adapter/mac_address.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace servobus::adapter {

std::string to_string(const MacAddress& mac) { return fmt::format("{:02x}", fmt::join(mac, ":")); }

}  // namespace servobus::adapter
