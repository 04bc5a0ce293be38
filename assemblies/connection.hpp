// The I/O connections of the drive: which points belong together, in which format, and who may write (000 §2.4.1,
// R-DEV-6, R-DEV-7, R-CON-9, R-CON-28).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "assemblies/layout.hpp"
#include "cip/real_time_format.hpp"

namespace servobus::assemblies {

/// The instance that a path may name for configuration; it holds nothing (R-DEV-7).
inline constexpr std::uint16_t configuration_instance = 1;
inline constexpr std::uint16_t input_only_point = 254;
inline constexpr std::uint16_t listen_only_point = 255;

/// The packet intervals that the module keeps (000 §2.4, R-CON-17), in microseconds.
inline constexpr std::uint32_t smallest_rpi = 1'000;
inline constexpr std::uint32_t largest_rpi = 3'200'000;

struct Connection {
    enum class Kind : std::uint8_t { exclusive_owner, input_only, listen_only };

    std::string_view key;   ///< for the command line: `standard`
    std::string_view name;  ///< as the manual heads its column: `Standard`
    Kind kind;
    std::uint16_t o_to_t_point;
    std::uint16_t t_to_o_point;

    [[nodiscard]] constexpr cip::RealTimeFormat o_to_t_format() const {
        return kind == Kind::exclusive_owner ? cip::RealTimeFormat::header32 : cip::RealTimeFormat::heartbeat;
    }
    [[nodiscard]] constexpr cip::RealTimeFormat t_to_o_format() const { return cip::RealTimeFormat::modeless; }
    /// Nullptr for a heartbeat.
    [[nodiscard]] const Layout* outputs() const { return find_layout(o_to_t_point); }
    [[nodiscard]] const Layout* inputs() const { return find_layout(t_to_o_point); }
    /// What a Forward_Open asks for: octets inside the data item (R-CON-7).
    [[nodiscard]] std::size_t o_to_t_size() const;
    [[nodiscard]] std::size_t t_to_o_size() const;
};

/// Exclusive owners first. The first of each key is the one that the key means.
[[nodiscard]] std::span<const Connection> connections();
[[nodiscard]] const Connection* find_connection(std::string_view key);
[[nodiscard]] const Connection* find_connection(std::uint32_t o_to_t_point, std::uint32_t t_to_o_point);
/// What the O->T point decides by itself; nullptr when no connection has it.
[[nodiscard]] const Connection* find_by_output(std::uint32_t o_to_t_point);
[[nodiscard]] const Connection* find_by_input(std::uint32_t t_to_o_point);

/// "exclusive owner".
[[nodiscard]] std::string_view name(Connection::Kind kind);

}  // namespace servobus::assemblies
