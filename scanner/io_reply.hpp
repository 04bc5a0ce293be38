// What a target has granted, as its reply to a Forward_Open says; nothing in it is believed before it is checked
// (R-SCN-3, R-CPF-8, R-CPF-9).
#pragma once

#include <boost/system/result.hpp>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include "cip/bytes.hpp"
#include "cip/forward_open.hpp"
#include "cip/message.hpp"
#include "enip/common_packet.hpp"
#include "enip/endpoint.hpp"
#include "scanner/error.hpp"
#include "scanner/io_plan.hpp"

namespace servobus::scanner {

/// Intervals outside of these are nobody's: production could not keep the first, and the second is no control any more.
/// Who asks for a longer one may be granted up to longest_stretch times as much.
inline constexpr std::chrono::microseconds shortest_api{250};
inline constexpr std::chrono::seconds longest_api{60};
inline constexpr unsigned longest_stretch = 10;

struct IoGrant {
    cip::ForwardOpenReply reply;
    enip::Endpoint target;                  ///< where O->T goes
    std::optional<enip::Endpoint> group{};  ///< where multicast T->O comes to
};

/// `peer` is the target's end of the TCP connection. The errors are missing_data, unexpected_data, wrong_connection, bad_interval and
/// bad_socket_address.
[[nodiscard]] boost::system::result<IoGrant> check_open_reply(const IoPlan& plan, const cip::ForwardOpen& request,
                                                              cip::ByteView data, std::span<const enip::Item> items,
                                                              enip::Endpoint peer);

/// What is wrong with a refusal: wrong_connection when it names another connection. No error when it does not say.
[[nodiscard]] error_code check_refusal(const cip::ConnectionTriad& triad, const cip::Response& response);

/// The reply to a Forward_Close.
[[nodiscard]] error_code check_close_reply(const cip::ConnectionTriad& triad, cip::ByteView data);

}  // namespace servobus::scanner
