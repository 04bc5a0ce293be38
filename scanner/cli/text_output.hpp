// Results as people read them. Every function returns whole lines.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scanner/cli/results.hpp"

namespace servobus::scanner::cli {

/// The text as a terminal shows it: UTF-8, with what would move the cursor written as \x1B.
[[nodiscard]] std::string printable(std::string_view text);

/// `SCurve = 20 %  (CIP 0x64/1/0x00, CANopen 0x2000:00)`; empty when the outcome has no value.
[[nodiscard]] std::string value_text(const Outcome& outcome);

/// Why there is no value: `SCurve: refused with 0x09 invalid attribute value; it takes 1 to 100 %`.
[[nodiscard]] std::string refusal_text(const Outcome& outcome);

/// A remark about a value that is there: surplus octets; empty when there is none.
[[nodiscard]] std::string warning_text(const Outcome& outcome);

/// All parameters, a table for each class.
[[nodiscard]] std::string dump_text(const std::vector<Outcome>& outcomes);

[[nodiscard]] std::string identity_text(const Identity& identity);
[[nodiscard]] std::string devices_text(const enip::asio::FoundDevices& devices);
[[nodiscard]] std::string call_text(const CallResult& result);
/// `static address`, `address by DHCP`; empty when it is not known.
[[nodiscard]] std::string address_method_text(std::optional<std::uint8_t> method);
[[nodiscard]] std::string reset_text(const ResetResult& result);
[[nodiscard]] std::string command_text(const CommandResult& result);
[[nodiscard]] std::string list_text(std::span<const drive::Parameter* const> rows);
[[nodiscard]] std::string commands_text(std::span<const drive::DirectCommand* const> commands);

/// Sixteen octets a line, with their characters.
[[nodiscard]] std::string hex_dump(cip::ByteView octets);

}  // namespace servobus::scanner::cli
