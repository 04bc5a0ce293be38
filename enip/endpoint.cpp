#include "enip/endpoint.hpp"

#include <fmt/format.h>

namespace servobus::enip {

std::string address_text(std::uint32_t address) {
    const auto octet = [&](unsigned shift) { return address >> shift & 0xFF; };
    return fmt::format("{}.{}.{}.{}", octet(24), octet(16), octet(8), octet(0));
}

std::string to_string(Endpoint endpoint) { return fmt::format("{}:{}", address_text(endpoint.address), endpoint.port); }

}  // namespace servobus::enip
