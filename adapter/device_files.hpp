// The files that the File object (0x37) hands out.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "cip/bytes.hpp"

namespace servobus::adapter {

/// One file, as it is stored. It may be empty.
struct DeviceFile {
    /// Shared, since many drives of one process hand out the same octets. Never null.
    std::shared_ptr<const cip::Bytes> content = std::make_shared<const cip::Bytes>();
    std::string name{};
    // Tools compare the revision with that of the EDS' own section [File], and do not upload when they differ.
    std::uint8_t major_revision = 1;
    std::uint8_t minor_revision = 0;
};

struct DeviceFiles {
    std::optional<DeviceFile> eds{};
    std::optional<DeviceFile> icon{};
};

}  // namespace servobus::adapter
