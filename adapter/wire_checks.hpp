// Reading the value of a Set: all of it, or the status that says what is wrong with its length (R-ERR-8).
#pragma once

#include <boost/system/result.hpp>

#include "cip/status.hpp"
#include "cip/wire.hpp"

namespace servobus::adapter {

/// Whether a value has the octets that it must have.
[[nodiscard]] inline cip::GeneralStatus length_status(cip::ByteView data, std::size_t size) {
    if (data.size() < size) return cip::GeneralStatus::not_enough_data;
    return data.size() > size ? cip::GeneralStatus::too_much_data : cip::GeneralStatus::success;
}

/// An integer that is the whole value.
template <cip::Field T>
[[nodiscard]] boost::system::result<T, cip::GeneralStatus> whole_value(cip::ByteView data) {
    if (const auto wrong = length_status(data, sizeof(T)); wrong != cip::GeneralStatus::success) return wrong;
    return cip::Reader(data).little<T>();
}

/// What a reader has left over or is missing, once everything should have been read.
[[nodiscard]] inline cip::GeneralStatus length_status(const cip::Reader& reader) {
    if (!reader.ok()) return cip::GeneralStatus::not_enough_data;
    return reader.remaining() > 0 ? cip::GeneralStatus::too_much_data : cip::GeneralStatus::success;
}

}  // namespace servobus::adapter
