#include "adapter/identity_status.hpp"

namespace servobus::adapter {
namespace {

constexpr unsigned owned_bit = 1U << 0;
constexpr unsigned configured_bit = 1U << 2;
constexpr unsigned extended_shift = 4;
constexpr unsigned first_fault_shift = 8;

/// Bits 4 to 7 (R-ID-4).
enum class ExtendedStatus : std::uint8_t {
    firmware_update = 1,
    connection_timed_out = 2,
    no_connection = 3,
    configuration_bad = 4,
    major_fault = 5,
    connection_runs = 6,
    connections_idle = 7,
};

bool is_major(DeviceFault fault) {
    return fault == DeviceFault::major_recoverable || fault == DeviceFault::major_unrecoverable;
}

ExtendedStatus extended_status(IoCondition io) {
    switch (io) {
        case IoCondition::running:
            return ExtendedStatus::connection_runs;
        case IoCondition::timed_out:
            return ExtendedStatus::connection_timed_out;
        case IoCondition::idle:
            return ExtendedStatus::connections_idle;
        case IoCondition::none:
            break;
    }
    return ExtendedStatus::no_connection;
}

ExtendedStatus extended_status(const DeviceCondition& condition) {
    if (is_major(condition.fault)) return ExtendedStatus::major_fault;
    if (condition.firmware_update) return ExtendedStatus::firmware_update;
    if (condition.configuration_bad) return ExtendedStatus::configuration_bad;
    return extended_status(condition.io);
}

unsigned fault_bit(DeviceFault fault) {
    return fault == DeviceFault::none ? 0 : 1U << (first_fault_shift + static_cast<unsigned>(fault) - 1);
}

}  // namespace

std::uint16_t identity_status(const DeviceCondition& condition) {
    return static_cast<std::uint16_t>((condition.owned ? owned_bit : 0) | (condition.configured ? configured_bit : 0) |
                                      static_cast<unsigned>(extended_status(condition)) << extended_shift |
                                      fault_bit(condition.fault));
}

IdentityState identity_state(const DeviceCondition& condition) {
    if (condition.fault == DeviceFault::major_unrecoverable) return IdentityState::major_unrecoverable_fault;
    if (condition.fault == DeviceFault::major_recoverable) return IdentityState::major_recoverable_fault;
    const bool waits = !condition.has_address || condition.firmware_update;
    return waits ? IdentityState::standby : IdentityState::operational;
}

}  // namespace servobus::adapter
