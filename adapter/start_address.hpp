// How the drive comes to its address, in the configuration file: what a client has set of it before the first power-up.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "adapter/json_settings.hpp"
#include "adapter/network_settings.hpp"

namespace servobus::adapter {

/// {"method": "stored", "address": "192.168.2.100/24", "gateway": "192.168.2.1", "acd": true}, or a part of it. An address
/// without a method is the stored one.
[[nodiscard]] std::optional<FileError> read_network(const Walk& walk, const nlohmann::json& value,
                                                    const std::string& pointer, NetworkSettings& settings);

}  // namespace servobus::adapter
