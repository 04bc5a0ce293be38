#include "adapter/time_sync.hpp"

#include <algorithm>

namespace servobus::adapter {
namespace {

// A TimeInterval is in 1/65536 ns.
std::chrono::nanoseconds from_time_interval(std::int64_t interval) { return std::chrono::nanoseconds(interval >> 16); }

}  // namespace

bool has_master(const PtpNode& node) {
    return std::ranges::any_of(node.ports, [](const PtpPort& port) { return port.data.state == PtpPortState::slave; });
}

std::chrono::nanoseconds offset_from_master(const PtpNode& node) {
    return from_time_interval(node.current.offset_from_master);
}

std::chrono::nanoseconds mean_path_delay(const PtpNode& node) {
    return from_time_interval(node.current.mean_path_delay);
}

}  // namespace servobus::adapter
