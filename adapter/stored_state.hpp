// What one device keeps over power-off and the end of the program.
#pragma once

#include "adapter/firmware_unit.hpp"
#include "adapter/network_settings.hpp"
#include "drive/stored_values.hpp"

namespace servobus::adapter {

struct StoredState {
    NetworkSettings network;
    drive::StoredValues parameters;
    FirmwareUnit::Flash firmware;

    friend bool operator==(const StoredState&, const StoredState&) = default;
};

}  // namespace servobus::adapter
