// What a request brings back beside its response, and the way that it has taken.
#pragma once

#include <vector>

#include "cip/message.hpp"
#include "enip/common_packet.hpp"
#include "enip/endpoint.hpp"

namespace servobus::scanner {

/// A response, and the items that came beside it (R-CPF-8).
struct Exchange {
    cip::Response response{};
    std::vector<enip::Item> items{};
};

/// Both ends of a TCP connection; zeros when it is not over IPv4.
struct TcpEnds {
    enip::Endpoint local;
    enip::Endpoint remote;
};

}  // namespace servobus::scanner
