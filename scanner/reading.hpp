// A parameter's row as a request, and a response as a parameter's value.
#pragma once

#include <boost/system/result.hpp>
#include <cstddef>
#include <optional>

#include "cip/message.hpp"
#include "drive/parameter.hpp"
#include "drive/store.hpp"
#include "scanner/error.hpp"

namespace servobus::scanner {

/// What a device says to a read.
struct ReadOutcome {
    cip::Status status{};  ///< its refusal, when there is no value
    std::optional<drive::Value> value{};
    std::size_t surplus = 0;  ///< octets behind the value, which were ignored (R-SCN-6)
};

[[nodiscard]] cip::Path path_to(const drive::Parameter& row);
[[nodiscard]] cip::Request read_request(const drive::Parameter& row);
[[nodiscard]] cip::Request write_request(const drive::Parameter& row, const drive::Value& value);

/// The value in a response to read_request(row); Error::missing_data when it is shorter than the row's type.
[[nodiscard]] boost::system::result<ReadOutcome> read_outcome(const drive::Parameter& row,
                                                              const cip::Response& response);

}  // namespace servobus::scanner
