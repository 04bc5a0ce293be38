// Why octets are not the message they claim to be. Never mixed with a CIP status or an operating system's error.
#pragma once

#include <boost/system/result.hpp>
#include <cstdint>
#include <string_view>

namespace servobus::cip {

enum class DecodeError : std::uint8_t {
    truncated,      ///< the message ends before its last field
    trailing,       ///< octets after the last field
    path_too_long,  ///< the path size runs past the message (status 0x26)
    bad_segment,    ///< reserved, unsupported or misplaced segment (status 0x04)
    bad_length,     ///< a length field contradicts the others
    bad_value,      ///< a field holds a value that the format does not have
    too_many,       ///< more elements than the named limit
};

[[nodiscard]] constexpr std::string_view describe(DecodeError error) {
    switch (error) {
        case DecodeError::truncated:
            return "the message ends too early";
        case DecodeError::trailing:
            return "there are octets after the end of the message";
        case DecodeError::path_too_long:
            return "the path is longer than the message";
        case DecodeError::bad_segment:
            return "the path has a segment that does not belong there";
        case DecodeError::bad_length:
            return "a length field does not fit the message";
        case DecodeError::bad_value:
            return "a field has a value that is not defined";
        case DecodeError::too_many:
            return "there are more elements than this end accepts";
    }
    return "unknown decode error";
}

template <class T>
using Decoded = boost::system::result<T, DecodeError>;

}  // namespace servobus::cip
