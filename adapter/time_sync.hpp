// What is known of the PTP node that keeps the clock of this machine: behind the class 0x43 of all drives of the process.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <vector>

#include "adapter/ptp_management.hpp"

namespace servobus::adapter {

/// Ports of a PTP node that are told of; further ones are not asked for.
inline constexpr std::size_t max_ptp_ports = 16;

struct PtpPort {
    PortDataSet data;
    std::optional<ClockDescription> description{};
};

/// A PTP node as it was when it was asked last.
struct PtpNode {
    DefaultDataSet own;
    CurrentDataSet current;
    ParentDataSet parent;
    TimePropertiesDataSet time;
    std::vector<PtpPort> ports;
};

struct TimeSync {
    std::optional<PtpNode> node{};       ///< nullopt: nobody answers
    std::chrono::seconds utc_offset{0};  ///< system time less UTC, as the last master has told it
};

/// Whether a master disciplines its clock: one of its ports is a slave (9.2.5).
[[nodiscard]] bool has_master(const PtpNode& node);
/// The clock's offset from the master's, in ns.
[[nodiscard]] std::chrono::nanoseconds offset_from_master(const PtpNode& node);
[[nodiscard]] std::chrono::nanoseconds mean_path_delay(const PtpNode& node);

}  // namespace servobus::adapter
