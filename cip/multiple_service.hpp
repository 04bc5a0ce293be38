// The data of a Multiple_Service_Packet, request and reply alike: UINT count, UINT offsets, the parts (R-MSG-16).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"

namespace servobus::cip {

/// Octets in front of the parts. Offsets count from the first of them.
[[nodiscard]] constexpr std::size_t parts_head(std::size_t count) { return 2 * (count + 1); }

/// Count, offsets and parts; the whole has fewer than 65,536 octets.
[[nodiscard]] Bytes write_parts(std::span<const Bytes> parts);

/// The octets from one offset to the next, the last part to the end: truncated when offsets are missing, bad_length when
/// they point into the head, backwards or past the end.
[[nodiscard]] Decoded<std::vector<ByteView>> read_parts(ByteView data);

}  // namespace servobus::cip
