// Time as the cores of this layer take it: an argument (decision 2).
#pragma once

#include <chrono>

namespace servobus::enip {

using Time = std::chrono::steady_clock::time_point;

}  // namespace servobus::enip
