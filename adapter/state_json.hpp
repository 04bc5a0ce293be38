// What a device keeps, as JSON: what is not as delivered, and nothing else.
//
//     {"network": {"method": 0, "host_name": "press-7"}, "parameters": {"0x64/0x00": 50, "0x65/0x5D": {"3": 500}}}
//
// and "firmware", once there has been a download.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "adapter/stored_state.hpp"
#include "drive/device.hpp"

namespace servobus::adapter {

/// `table` is the device's, and `delivered` what its state was when nobody had written anything yet.
[[nodiscard]] std::string state_text(const StoredState& state, const StoredState& delivered, const drive::Store& table);

/// The same back. Otherwise what is wrong, as a sentence without a full stop: a member that is not known, a value of
/// another type or out of its range, a parameter that this device does not keep.
[[nodiscard]] std::variant<StoredState, std::string> parse_state(std::string_view text, const StoredState& delivered,
                                                                 const drive::Device& device);

}  // namespace servobus::adapter
