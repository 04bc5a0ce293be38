// What attributes are called, for the log.
#pragma once

#include <cstdint>
#include <string>

#include "drive/device.hpp"

namespace servobus::adapter {

/// `drive.Controlword`, `TCP/IP Interface.Host Name`; empty where nobody knows.
[[nodiscard]] std::string attribute_name(const drive::Device& device, std::uint32_t class_id, std::uint32_t attribute);

}  // namespace servobus::adapter
