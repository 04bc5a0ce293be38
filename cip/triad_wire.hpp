// The one description of a connection's triad on the wire, for all messages that name a connection.
#pragma once

#include "cip/forward_open.hpp"

namespace servobus::cip {

void describe_triad(auto& io, auto& triad) {
    io.field(triad.serial_number);
    io.field(triad.originator_vendor);
    io.field(triad.originator_serial);
}

}  // namespace servobus::cip
