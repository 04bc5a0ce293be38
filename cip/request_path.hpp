// What an explicit request is addressed to (R-PTH-10 to R-PTH-12).
#pragma once

#include <boost/system/result.hpp>
#include <cstdint>
#include <optional>

#include "cip/bytes.hpp"
#include "cip/path.hpp"
#include "cip/status.hpp"

namespace servobus::cip {

/// Class, instance and attribute of a request. Instance 0, also when left out, is the class itself (R-PTH-11).
struct RequestPath {
    std::uint32_t class_id = 0;
    std::uint32_t instance = 0;
    std::optional<std::uint32_t> attribute{};
    std::optional<ElectronicKey> key{};

    /// 0x05 for an empty path and for a class alone; 0x04 for any segment that is reserved, repeated, out of order or
    /// not one of key, class, instance, attribute.
    [[nodiscard]] static boost::system::result<RequestPath, Status> parse(ByteView path);
};

/// Who the node is, for electronic keys.
struct NodeIdentity {
    std::uint16_t vendor = 0;
    std::uint16_t device_type = 0;
    std::uint16_t product_code = 0;
    std::uint8_t major_revision = 0;
    std::uint8_t minor_revision = 0;
};

/// Nullopt when the key fits the node; otherwise the first mismatch in the order of R-CON-11. Zeros fit anything.
[[nodiscard]] std::optional<ConnectionFailure> mismatch(const ElectronicKey& key, const NodeIdentity& node);

}  // namespace servobus::cip
