// What is wrong with a Forward_Open whatever else is open: transport, types, multiplier, intervals, path (R-CON-15).
#pragma once

#include <cstdint>
#include <span>

#include "adapter/open_refusal.hpp"
#include "assemblies/connection.hpp"
#include "cip/forward_open.hpp"
#include "cip/path.hpp"
#include "cip/request_path.hpp"
#include "enip/io_stream.hpp"

namespace servobus::adapter {

inline constexpr std::uint8_t io_class = 1;
inline constexpr std::uint8_t explicit_class = 3;

[[nodiscard]] bool is_null(const cip::ForwardOpen& open);

/// Step 3 of R-CON-15. Multicast T->O is for I/O alone.
[[nodiscard]] OpenResult<void> check_transport(const cip::ForwardOpen& open);
/// Step 6: 0x0111 and 0x0112 (R-CON-17). `largest`: 0 when there is no upper limit.
[[nodiscard]] OpenResult<void> check_rpi(const cip::ForwardOpen& open, std::uint32_t largest);

/// The segments of a path behind a hop that names this node and the electronic key, which is checked (step 4).
[[nodiscard]] OpenResult<std::span<const cip::Segment>> check_key(const cip::Path& path, const cip::NodeIdentity& node);

/// Where a route leads: success for this node (R-CM-10).
[[nodiscard]] cip::Status check_route(cip::ByteView route);

/// What a class 1 Forward_Open asks for, when it asks for something that this device has.
struct IoOpen {
    const assemblies::Connection* connection;
    enip::Trigger trigger = enip::Trigger::cyclic;
    /// Between two T->O datagrams; a quarter of the interval unless the path says it (R-CON-51). Zero for cyclic.
    std::chrono::microseconds inhibit{};
};
/// Steps 3 to 7 for class 1.
[[nodiscard]] OpenResult<IoOpen> check_io_open(const cip::ForwardOpen& open, const cip::NodeIdentity& node);

}  // namespace servobus::adapter
