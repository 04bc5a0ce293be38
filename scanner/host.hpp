// HOST and --route as people write them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cip/path.hpp"
#include "enip/encapsulation.hpp"
#include "scanner/mistake.hpp"

namespace servobus::scanner {

/// Where a device listens: a name or an address, and a port.
struct Host {
    std::string name;
    std::uint16_t port = enip::tcp_port;
    friend bool operator==(const Host&, const Host&) = default;
};

/// `drive.local`, `192.168.2.100`, `192.168.2.100:44818`, `[::1]:44818`.
[[nodiscard]] Parsed<Host> parse_host(std::string_view text);
/// The same form; without the port when it is the usual one.
[[nodiscard]] std::string to_string(const Host& host);

/// The hops to a device, `PORT/LINK` with commas between them: `1/0` is slot 0 of a backplane,
/// `1/0,2/192.168.1.10` goes on through port 2 of what is there. The link is a number to 255 or an address.
[[nodiscard]] Parsed<cip::Path> parse_route(std::string_view text);

}  // namespace servobus::scanner
