// The picture of the drive that tools show: Icon and IconContents of a sheet, and instance 0xC9 of the File object.
#pragma once

#include <string_view>

#include "cip/bytes.hpp"

namespace servobus::eds {

inline constexpr std::string_view icon_file_name = "XENAX.ico";

/// An .ico file with one picture of 32 x 32 pixels and 16 colours, as EDS tools ask for; 766 octets. It is drawn here.
[[nodiscard]] cip::Bytes icon();

}  // namespace servobus::eds
