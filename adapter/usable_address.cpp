#include "adapter/usable_address.hpp"

#include <bit>

namespace servobus::adapter {
namespace {

bool is_contiguous(std::uint32_t mask) { return std::countl_one(mask) + std::countr_zero(mask) >= 32; }

}  // namespace

// Zero gateway and name servers mean none.
bool is_usable(const InterfaceConfiguration& configuration) {
    const auto address = configuration.address;
    const auto mask = configuration.mask;
    const auto gateway = configuration.gateway;
    const auto first = address >> 24;
    const bool unicast = first != 0 && first != 127 && first < 224;
    if (!unicast || mask == 0 || !is_contiguous(mask)) return false;
    const auto host = address & ~mask;
    if (host == 0 || host == ~mask) return false;
    return gateway == 0 || (gateway & mask) == (address & mask);
}

std::uint32_t natural_mask(std::uint32_t address) {
    if (address >> 31 == 0) return 0xFF000000;
    if (address >> 30 == 2) return 0xFFFF0000;
    return 0xFFFFFF00;
}

unsigned prefix_length(std::uint32_t mask) { return static_cast<unsigned>(std::countl_one(mask)); }

}  // namespace servobus::adapter
