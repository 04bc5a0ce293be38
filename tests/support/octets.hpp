// Octets in tests: hex text in, hex text out, so that a failure shows the octets that differ.
#pragma once

#include <boost/assert/source_location.hpp>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"
#include "cip/hex.hpp"
#include "cip/status.hpp"

namespace servobus::cip {

// What gtest prints when an expectation fails.
inline void PrintTo(DecodeError error, std::ostream* out) { *out << describe(error); }
inline void PrintTo(const Status& status, std::ostream* out) { *out << describe(status); }
inline void PrintTo(GeneralStatus status, std::ostream* out) { *out << describe(Status(status)); }

// What value() of a result without a value does: in a test it is a failure, which gtest reports.
[[noreturn]] inline void throw_exception_from_error(DecodeError error, const boost::source_location&) {
    throw std::runtime_error(std::string(describe(error)));
}
[[noreturn]] inline void throw_exception_from_error(const Status& status, const boost::source_location&) {
    throw std::runtime_error(describe(status));
}
[[noreturn]] inline void throw_exception_from_error(GeneralStatus status, const boost::source_location&) {
    throw std::runtime_error(describe(Status(status)));
}

}  // namespace servobus::cip

namespace servobus::test {

/// The octets of a hex text; a test with a broken text ends at once.
inline cip::Bytes octets(std::string_view text) {
    auto bytes = cip::from_hex(text);
    if (!bytes) {
        std::cerr << "not hex: " << text << '\n';
        std::abort();
    }
    return std::move(*bytes);
}

inline std::string hex(cip::ByteView bytes) { return cip::to_hex(bytes); }

/// The same octets in the one spelling that hex() has.
inline std::string hex(std::string_view text) { return cip::to_hex(octets(text)); }

/// Why something could not be decoded; nullopt when it could.
template <class T>
std::optional<cip::DecodeError> error_of(const cip::Decoded<T>& decoded) {
    if (decoded) return std::nullopt;
    return decoded.error();
}

inline cip::Bytes operator+(cip::Bytes front, const cip::Bytes& back) {
    front.insert(front.end(), back.begin(), back.end());
    return front;
}

}  // namespace servobus::test
