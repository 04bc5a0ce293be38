// An I/O plan as the words of `servobus-scanner io HOST ...`.
#pragma once

#include <string>
#include <vector>

#include "scanner/io_plan.hpp"

namespace servobus::scanner {

/// What stands behind `io`: the host, and the options that are not as they would be without them. `--connection` where
/// a connection of the XENAX has these points, sizes and formats, the six numbers otherwise.
[[nodiscard]] std::vector<std::string> plan_arguments(const IoPlan& plan, const std::string& host);

/// `servobus-scanner io 192.168.2.100 --connection standard --rpi 2`, words with blanks in quotes.
[[nodiscard]] std::string command_line(const IoPlan& plan, const std::string& host);

}  // namespace servobus::scanner
