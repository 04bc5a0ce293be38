// Several requests in one: Multiple_Service_Packet (R-MSG-16).
#pragma once

#include <boost/system/result.hpp>
#include <cstddef>
#include <span>
#include <vector>

#include "cip/message.hpp"
#include "scanner/error.hpp"

namespace servobus::scanner {

/// Octets that a packet, and the reply to it, may have: what every device takes (R-ENC-27).
inline constexpr std::size_t max_packet_bytes = 500;

/// The octets that a packet of requests has, and that one more request adds to it.
inline constexpr std::size_t packet_overhead = 8;
[[nodiscard]] std::size_t packet_share(const cip::Request& request);

[[nodiscard]] cip::Request multiple_service_packet(std::span<const cip::Request> requests);

/// The responses in a reply, in the order of the requests: `count` of them, each to its service. Only a reply with
/// status success or embedded_service_error has them. Error::unexpected_data for anything else.
[[nodiscard]] boost::system::result<std::vector<cip::Response>> multiple_service_responses(
    std::span<const cip::Request> requests, const cip::Response& reply);

}  // namespace servobus::scanner
