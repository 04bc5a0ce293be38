// An explicit (class 3) connection as its originator sees it (R-CON-45 to R-CON-47).
#pragma once

#include <cstddef>
#include <cstdint>

#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"
#include "cip/forward_open.hpp"
#include "cip/message.hpp"
#include "cip/path.hpp"

namespace servobus::scanner {

/// The largest that a Forward_Open can ask for and every device takes, and what is asked for in the large form.
inline constexpr std::uint16_t small_connection_size = 500;
inline constexpr std::uint16_t large_connection_size = 4000;

/// What the originator chooses.
struct Class3Proposal {
    bool large = true;
    std::uint32_t t_to_o_id = 0;
    cip::ConnectionTriad triad;
    cip::Path path;  ///< the route, then the message router

    [[nodiscard]] std::uint16_t size() const { return large ? large_connection_size : small_connection_size; }
    [[nodiscard]] cip::Request forward_open() const;
    [[nodiscard]] cip::Request forward_close() const;
};

/// An open connection.
struct Class3Connection {
    Class3Proposal proposal;
    std::uint32_t o_to_t_id = 0;  ///< chosen by the target
    std::uint16_t sequence = 0;   ///< of the last request

    /// Octets of a request that fit, beside the sequence count.
    [[nodiscard]] std::size_t max_message() const { return proposal.size() - 2U; }
};

/// `route`, then `20 02 24 01`.
[[nodiscard]] cip::Path class3_path(const cip::Path& route);

/// The connection that a successful reply to proposal.forward_open() means; bad_value when it is about another.
[[nodiscard]] cip::Decoded<Class3Connection> class3_connection(const Class3Proposal& proposal, cip::ByteView reply);

}  // namespace servobus::scanner
