// The product's originator in a process of its own.
#pragma once

#include <string>
#include <vector>

namespace servobus::bench {

/// originator HOST COUNT INTERVAL_US: one owner (103/100) of each of COUNT drives, HOST being the address of the first.
/// Says "ready" when all are open; ends with a line of JSON about what was sent, received and lost.
int originator_role(const std::vector<std::string>& words);

}  // namespace servobus::bench
