#include "adapter/multicast_groups.hpp"

namespace servobus::adapter {
namespace {

constexpr std::uint32_t base = 0xEFC00100;  // 239.192.1.0
constexpr std::uint32_t hosts = 0x3FF;

// Without a mask the one of the address's class counts.
std::uint32_t class_mask(std::uint32_t address) {
    if (address >> 31 == 0) return 0xFF000000;
    return address >> 30 == 2 ? 0xFFFF0000 : 0xFFFFFF00;
}

}  // namespace

MulticastGroups multicast_groups(const Network& network, std::uint32_t address) {
    const auto& chosen = network.settings.multicast;
    if (chosen.chosen) return {chosen.start, chosen.count};
    if (address == 0) return {};
    const auto known = network.state.place().mask;
    const auto host = address & ~(known != 0 ? known : class_mask(address));
    return {base + ((host - 1) & hosts) * max_multicast_groups, max_multicast_groups};
}

}  // namespace servobus::adapter
