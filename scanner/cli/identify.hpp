// Asking a device who it is.
#pragma once

#include <boost/system/result.hpp>

#include "scanner/cli/link.hpp"
#include "scanner/identity.hpp"

namespace servobus::scanner::cli {

/// By Get_Attributes_All, or attribute by attribute where the device has no such service.
[[nodiscard]] boost::system::result<Identity, Failure> ask_identity(Link& link);

}  // namespace servobus::scanner::cli
