// Service codes (R-MSG-4). Codes from 0x4B to 0x63 mean what the class says.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace servobus::cip::service {

inline constexpr std::uint8_t get_attributes_all = 0x01;
inline constexpr std::uint8_t set_attributes_all = 0x02;
inline constexpr std::uint8_t get_attribute_list = 0x03;
inline constexpr std::uint8_t set_attribute_list = 0x04;
inline constexpr std::uint8_t reset = 0x05;
inline constexpr std::uint8_t multiple_service_packet = 0x0A;
inline constexpr std::uint8_t get_attribute_single = 0x0E;
inline constexpr std::uint8_t set_attribute_single = 0x10;

// Connection Manager
inline constexpr std::uint8_t forward_close = 0x4E;
inline constexpr std::uint8_t unconnected_send = 0x52;
inline constexpr std::uint8_t forward_open = 0x54;
inline constexpr std::uint8_t get_connection_data = 0x56;
inline constexpr std::uint8_t search_connection_data = 0x57;
inline constexpr std::uint8_t get_connection_owner = 0x5A;
inline constexpr std::uint8_t large_forward_open = 0x5B;

/// Set in the service octet of every reply.
inline constexpr std::uint8_t reply_bit = 0x80;

/// `Get_Attribute_Single`; for object specific codes the name depends on the class. Empty when not known.
[[nodiscard]] std::string_view name(std::uint8_t code, std::uint32_t class_id);

/// The code of a name as above, in any case and with or without underscores; nullopt for an unknown one.
[[nodiscard]] std::optional<std::uint8_t> from_name(std::string_view text);

}  // namespace servobus::cip::service

namespace servobus::cip::class_id {

inline constexpr std::uint16_t identity = 0x01;
inline constexpr std::uint16_t message_router = 0x02;
inline constexpr std::uint16_t assembly = 0x04;
inline constexpr std::uint16_t connection_manager = 0x06;

}  // namespace servobus::cip::class_id
