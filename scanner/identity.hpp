// Who a device says it is: the Identity object (0x01) and what its numbers mean (R-ID-1 to R-ID-6).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cip/bytes.hpp"
#include "enip/messages.hpp"

namespace servobus::scanner {

struct Identity {
    std::uint16_t vendor = 0;
    std::uint16_t device_type = 0;
    std::uint16_t product_code = 0;
    std::uint8_t major_revision = 0;
    std::uint8_t minor_revision = 0;
    std::uint16_t status = 0;
    std::uint32_t serial_number = 0;
    std::string product_name;
    std::optional<std::uint8_t> state{};  ///< not every device tells it
    friend bool operator==(const Identity&, const Identity&) = default;
};

[[nodiscard]] Identity identity_of(const enip::IdentityItem& item);

/// The attributes 1 to 7, as the Identity object numbers them, and 8.
inline constexpr std::uint16_t first_identity_attribute = 1;
inline constexpr std::uint16_t last_required_identity_attribute = 7;
inline constexpr std::uint16_t identity_state_attribute = 8;

/// Puts the value of an attribute into its place. False when `value` is too short for it, or the attribute unknown.
[[nodiscard]] bool set_attribute(Identity& identity, std::uint32_t attribute, cip::ByteView value);

/// The reply to Get_Attributes_All: attributes 1 to 7, and 8 when it is there. Nullopt when it is too short.
[[nodiscard]] std::optional<Identity> read_identity(cip::ByteView attributes_all);

/// One attribute for people: `vendor 1389 (Jenny Science AG)`; empty when it is unknown or the value is too short.
[[nodiscard]] std::string describe_identity_attribute(std::uint32_t attribute, cip::ByteView value);

/// Names of what is often met; empty for others.
[[nodiscard]] std::string_view vendor_name(std::uint16_t vendor);
[[nodiscard]] std::string_view device_type_name(std::uint16_t device_type);

/// `owned, configured, I/O runs`.
[[nodiscard]] std::string status_text(std::uint16_t status);
[[nodiscard]] std::string_view state_text(std::uint8_t state);

}  // namespace servobus::scanner
