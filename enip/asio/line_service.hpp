// What answers lines of text, and how much of them there may be.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include "enip/target.hpp"

namespace servobus::enip::asio {

/// Octets of one line without its end.
inline constexpr std::size_t max_line_octets = 4096;
/// Clients of one socket at a time.
inline constexpr std::size_t max_line_clients = 16;

struct LineService {
    /// The answer to one line, both without line ends. Blank lines are not asked about.
    std::function<std::string(std::string_view line, Time now)> answer;
    std::string too_long;  ///< the answer to a line of more than max_line_octets
    std::string too_many;  ///< what one client more than max_line_clients is told before it is closed
};

}  // namespace servobus::enip::asio
