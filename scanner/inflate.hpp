// Files that a device keeps compressed: zlib or gzip (R-FIL-2, attribute 11).
#pragma once

#include <boost/system/result.hpp>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "cip/bytes.hpp"

namespace servobus::scanner {

/// What a file may become, at most.
inline constexpr std::size_t max_inflated_octets = std::size_t{64} << 20;

enum class InflateError : std::uint8_t {
    unknown_format,  ///< neither zlib nor gzip
    damaged,         ///< or cut off
    too_large,
};
[[nodiscard]] std::string_view describe(InflateError error);

/// The octets behind a zlib or gzip stream; what may stand behind the stream is left out.
[[nodiscard]] boost::system::result<cip::Bytes, InflateError> inflate(cip::ByteView stream,
                                                                      std::size_t max_octets = max_inflated_octets);

}  // namespace servobus::scanner
