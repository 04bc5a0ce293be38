// What {"query": "network"} tells: how the device stands with its address and its ring.
#pragma once

#include <nlohmann/json.hpp>

#include "adapter/network_state.hpp"

namespace servobus::adapter {

[[nodiscard]] nlohmann::ordered_json describe_network(const Network& network);

}  // namespace servobus::adapter
