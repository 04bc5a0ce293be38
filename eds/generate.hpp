// The data sheet of a variant, written from its parameter table, the assemblies and the connections (R-EDS-3 to R-EDS-11).
#pragma once

#include <cstdint>
#include <string>

#include "drive/device.hpp"
#include "eds/field_values.hpp"

namespace servobus::eds {

/// How many connections the device takes at most, for [Capacity].
struct ConnectionLimits {
    std::uint32_t io = 9;  ///< one owner, and eight that look on
    std::uint32_t messages = 128;
};

/// Of the sheet, not of the device.
inline constexpr Revision sheet_revision{1, 0};

/// `XENAX_XVI_75V8S_EtherNetIP.eds` (000 §1.2).
[[nodiscard]] std::string file_name(const drive::Model& model);

/// The text, 7-bit ASCII, lines end with LF. The same arguments give the same octets, wherever and whenever. [Device]
/// says what the model's identity does, so that a tool finds the sheet by what the device answers.
[[nodiscard]] std::string generate(const drive::Model& model, const ConnectionLimits& limits = {});

}  // namespace servobus::eds
