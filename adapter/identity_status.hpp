// What the status word and the state of the Identity object are made of (R-ID-3 to R-ID-5).
#pragma once

#include <cstdint>

namespace servobus::adapter {

/// What the I/O connections are doing, all together.
enum class IoCondition : std::uint8_t {
    none,       ///< there is none
    timed_out,  ///< one was lost, and none has been opened since
    idle,       ///< there are some, and nobody runs
    running,    ///< at least one is in run
};

/// A fault of the device, by its bit in the status word; none of them takes more than one.
enum class DeviceFault : std::uint8_t {
    none,
    minor_recoverable,
    minor_unrecoverable,
    major_recoverable,
    major_unrecoverable,
};

struct DeviceCondition {
    bool owned = false;              ///< by an exclusive owner
    bool configured = false;         ///< something is stored that is not as delivered
    bool configuration_bad = false;  ///< what was stored could not be used, and nothing has been stored since
    bool firmware_update = false;    ///< a download is in progress
    bool has_address = true;
    DeviceFault fault = DeviceFault::none;
    IoCondition io = IoCondition::none;
};

/// Attribute 8 (R-ID-5). Nobody can meet the other states of the specification: the device is there at once.
enum class IdentityState : std::uint8_t {
    standby = 2,  ///< it has no address and so nobody to work for, or takes a download
    operational = 3,
    major_recoverable_fault = 4,
    major_unrecoverable_fault = 5,
};

/// Attribute 5 (R-ID-3). Of the extended states the first that is so: major fault, firmware update, bad configuration,
/// running, timed out, idle, none (R-ID-4).
[[nodiscard]] std::uint16_t identity_status(const DeviceCondition& condition);
[[nodiscard]] IdentityState identity_state(const DeviceCondition& condition);

}  // namespace servobus::adapter
