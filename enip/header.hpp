// The one description of the encapsulation header (R-ENC-2), for Frame and FrameDecoder.
#pragma once

#include "cip/wire.hpp"
#include "enip/encapsulation.hpp"

namespace servobus::enip {

void describe_header(auto& io, auto& frame, auto& length) {
    io.field(frame.command);
    io.field(length);
    io.field(frame.session);
    io.field(frame.status);
    io.field(frame.context);
    io.field(frame.options);
}

}  // namespace servobus::enip
