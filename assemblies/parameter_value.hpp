// A drive parameter's value in CIP's octets, and back: little-endian integers and STRING (R-TYP-1, R-TYP-3).
#pragma once

#include <boost/system/result.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "cip/bytes.hpp"
#include "cip/data_types.hpp"
#include "cip/status.hpp"
#include "cip/wire.hpp"
#include "drive/parameter.hpp"
#include "drive/refusal.hpp"
#include "drive/store.hpp"

namespace servobus::assemblies {

/// The CIP type of a row: SINT, INT, DINT, USINT, UINT, UDINT or STRING.
[[nodiscard]] cip::DataType data_type(drive::Type type);

/// Appends the value. The value is of the row's kind: a number inside its type, or a text.
void write_value(cip::Writer& writer, const drive::Parameter& row, const drive::Value& value);

/// The value that `data` holds, all of it: not_enough_data when it is short, too_much_data when it is long (R-TYP-9).
/// A STRING may have one octet of padding behind an odd count (R-TYP-5).
[[nodiscard]] boost::system::result<drive::Value, cip::GeneralStatus> read_value(const drive::Parameter& row,
                                                                                 cip::ByteView data);

/// Octets of the value at the front of `data`; nullopt when there are too few to tell.
[[nodiscard]] std::optional<std::size_t> value_size(const drive::Parameter& row, cip::ByteView data);

/// What a refusal of the drive is on CIP (decision 4; R-ERR-6, R-ERR-9, R-ERR-10).
[[nodiscard]] cip::Status to_status(drive::Refusal refusal);

}  // namespace servobus::assemblies
