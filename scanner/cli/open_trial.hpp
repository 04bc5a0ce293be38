// Opens a connection for a moment, to see whether the device takes it.
#pragma once

#include <chrono>
#include <optional>

#include "scanner/host.hpp"
#include "scanner/io_events.hpp"
#include "scanner/io_plan.hpp"

namespace servobus::scanner::cli {

/// How a trial ended. Well: the first datagram came.
struct TrialResult {
    bool well = false;
    std::optional<IoClosed> closed{};  ///< why not, when the device or the network said so
};

/// Opens `plan`, waits for its first datagram, and closes it. Outputs are idle all the time. With `companion` that one is
/// open meanwhile: somebody who only listens needs others. Everything ends in a few times `timeout`.
[[nodiscard]] TrialResult try_open(const Host& host, std::chrono::milliseconds timeout, const IoPlan& plan,
                                   const std::optional<IoPlan>& companion = {});

}  // namespace servobus::scanner::cli
