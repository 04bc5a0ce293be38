// From a host's name to its addresses, without ever waiting for a name server.
#pragma once

#include <boost/system/error_code.hpp>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "enip/asio/asio.hpp"

namespace servobus::enip::asio {

using Addresses = std::vector<net::ip::tcp::endpoint>;
using Found = std::function<void(boost::system::error_code, Addresses)>;

/// Calls `found` on `executor`, unless the returned function has been called before: that abandons the search. A name
/// server that is silent for half a minute holds up only a thread that nobody waits for, not even the end of the
/// program; so this is not Asio's own resolver, whose destructor waits.
[[nodiscard]] std::function<void()> look_up(const net::any_io_executor& executor, const std::string& host,
                                            std::uint16_t port, Found found);

}  // namespace servobus::enip::asio
