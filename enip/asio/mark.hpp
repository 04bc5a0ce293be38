// The priority that the packets of a socket carry.
#pragma once

#include <cstdint>

namespace servobus::enip::asio {

/// All that the socket sends from now on carries this DSCP value, 0..63. A system that does not take it sends without.
void mark(int socket, std::uint8_t dscp);

}  // namespace servobus::enip::asio
