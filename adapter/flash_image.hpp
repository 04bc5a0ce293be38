// A firmware file of the bus module (000 §1.1, §1.2: Xenax_EtherNetIP_protocol_Vx.xx.flash). The maker's format is not
// public; this is one of our own, in which an image holds what the lights speak of: a bit stream and a firmware.
//
//     offset  octets
//     0       8   53 56 42 46 4C 41 53 48, "SVBFLASH"
//     8       2   1, the version of this format
//     10      2   version of the firmware: x and xx of Vx.xx, the second 0 to 99
//     12      2   revision that Identity has with it, major and minor; 0 0 when it stays as it is
//     14      2   n, how many product codes follow, 1 to 16
//     16      4   octets of the bit stream, at least 1
//     20      4   octets of the firmware, at least 1
//     24      2n  product codes of the drives that it fits
//     ...         bit stream, then firmware: passed over, whatever they are
//     end - 4 4   CRC-32 (IEEE 802.3) of all before it
//
// All numbers are little endian.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cip/bytes.hpp"

namespace servobus::adapter {

/// Octets of a whole image.
inline constexpr std::size_t max_flash_octets = std::size_t{4} << 20;

/// Vx.xx.
struct FirmwareVersion {
    std::uint8_t major = 0;
    std::uint8_t minor = 0;  ///< 0 to 99
    friend auto operator<=>(const FirmwareVersion&, const FirmwareVersion&) = default;
};
/// `1.04`.
[[nodiscard]] std::string to_string(FirmwareVersion version);

/// Attribute 4 of Identity.
struct Revision {
    std::uint8_t major = 1;  ///< 1 to 127
    std::uint8_t minor = 1;  ///< 1 to 255
    friend bool operator==(const Revision&, const Revision&) = default;
};

struct FlashImage {
    FirmwareVersion version{};
    std::optional<Revision> revision{};
    std::vector<std::uint16_t> product_codes{};
    std::size_t bit_stream_octets = 0;
    std::size_t firmware_octets = 0;

    /// The image in a file, or what is wrong with it: a clause for the person who brought it.
    [[nodiscard]] static std::variant<FlashImage, std::string> parse(cip::ByteView file);
    [[nodiscard]] bool fits(std::uint16_t product_code) const;
};

}  // namespace servobus::adapter
