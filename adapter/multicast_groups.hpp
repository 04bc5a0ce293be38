// The IPv4 groups that the device produces to (R-MC-1, R-MC-2).
#pragma once

#include <cstddef>
#include <cstdint>

#include "adapter/network_state.hpp"

namespace servobus::adapter {

/// The groups from `first` on, in host order. 0: the device has no address that they could follow from.
struct MulticastGroups {
    std::uint32_t first = 0;
    std::size_t count = 1;

    /// The group of a point by its place among those that are produced; they share groups when there are too few.
    [[nodiscard]] std::uint32_t of(std::size_t place) const {
        return first + static_cast<std::uint32_t>(place % count);
    }
};

/// Those that are chosen, or those that follow from `address`: the device's own, in host order.
[[nodiscard]] MulticastGroups multicast_groups(const Network& network, std::uint32_t address);

inline constexpr std::uint16_t max_multicast_groups = 32;

}  // namespace servobus::adapter
