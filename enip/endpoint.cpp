#include "enip/endpoint.hpp"

#include <fmt/format.h>

namespace servobus::enip {

std::string to_string(Endpoint endpoint) {
    const auto octet = [&](unsigned shift) { return endpoint.address >> shift & 0xFF; };
    return fmt::format("{}.{}.{}.{}:{}", octet(24), octet(16), octet(8), octet(0), endpoint.port);
}

}  // namespace servobus::enip
