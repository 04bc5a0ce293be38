// The one description of a socket address on the wire, for items and for the identity.
#pragma once

#include "enip/common_packet.hpp"

namespace servobus::enip {

void describe_address(auto& io, auto& address) {
    io.big_endian_field(address.family);
    io.big_endian_field(address.port);
    io.big_endian_field(address.address);
    io.field(address.zero);
}

}  // namespace servobus::enip
