#include "adapter/multicast_groups.hpp"

#include "adapter/usable_address.hpp"

namespace servobus::adapter {
namespace {

constexpr std::uint32_t base = 0xEFC00100;  // 239.192.1.0
constexpr std::uint32_t hosts = 0x3FF;

}  // namespace

MulticastGroups multicast_groups(const Network& network, std::uint32_t address) {
    const auto& chosen = network.settings.multicast;
    if (chosen.chosen) return {chosen.start, chosen.count};
    if (address == 0) return {};
    const auto known = network.state.place().mask;
    const auto host = address & ~(known != 0 ? known : natural_mask(address));
    return {base + ((host - 1) & hosts) * max_multicast_groups, max_multicast_groups};
}

}  // namespace servobus::adapter
