// The two words that every connection of a data sheet begins with: what kinds of connection it may be (R-EDS-9).
#pragma once

#include <cstdint>
#include <optional>

#include "cip/real_time_format.hpp"

namespace servobus::eds {

/// Bits 24 to 27 of the first word.
enum class Ownership : std::uint8_t { listen_only = 0, input_only = 1, exclusive_owner = 2, redundant_owner = 3 };

/// "trigger and transport": bits 0 to 6 the classes 0 to 6, 16 to 18 the triggers, 24 to 27 the ownership, 31 the side.
struct TransportWord {
    std::uint32_t bits = 0;

    static constexpr std::uint32_t class_bits = 0x0000FFFF;
    static constexpr std::uint32_t trigger_bits = 0x00070000;
    static constexpr std::uint32_t ownership_bits = 0x0F000000;
    static constexpr std::uint32_t reserved_bits = ~(class_bits | trigger_bits | ownership_bits | 0x80000000);

    [[nodiscard]] constexpr bool allows_class(unsigned number) const { return (bits >> number & 1) != 0; }
    [[nodiscard]] constexpr bool cyclic() const { return (bits >> 16 & 1) != 0; }
    [[nodiscard]] constexpr bool change_of_state() const { return (bits >> 17 & 1) != 0; }
    [[nodiscard]] constexpr bool application() const { return (bits >> 18 & 1) != 0; }
    [[nodiscard]] constexpr bool is(Ownership ownership) const {
        return (bits & ownership_bits) == std::uint32_t{1} << (24 + static_cast<unsigned>(ownership));
    }
    /// Nullopt when none or several of the four bits are set.
    [[nodiscard]] constexpr std::optional<Ownership> ownership() const {
        for (const auto each :
             {Ownership::listen_only, Ownership::input_only, Ownership::exclusive_owner, Ownership::redundant_owner}) {
            if (is(each)) return each;
        }
        return std::nullopt;
    }
    [[nodiscard]] constexpr bool server() const { return (bits >> 31) != 0; }
    friend constexpr bool operator==(const TransportWord&, const TransportWord&) = default;
};

/// What the second word says of one direction.
struct DirectionBits {
    bool fixed = false;
    bool variable = false;
    std::uint8_t format = 0;  ///< a number of cip::RealTimeFormat, 5 for safety, or reserved
    bool null = false;
    bool multicast = false;
    bool point_to_point = false;
    std::uint8_t priorities = 0;  ///< bit 0 low, 1 high, 2 scheduled, 3 urgent
    friend constexpr bool operator==(const DirectionBits&, const DirectionBits&) = default;

    [[nodiscard]] constexpr bool is(cip::RealTimeFormat real_time_format) const {
        return format == static_cast<std::uint8_t>(real_time_format);
    }
};

/// "connection parameters". O->T has bits 0, 1, 8 to 10, 16 to 18, 24 to 27; T->O 2, 3, 12 to 14, 20 to 22, 28 to 31.
struct ParameterWord {
    std::uint32_t bits = 0;

    /// 4 to 7 once told octets for each slot.
    static constexpr std::uint32_t reserved_bits = 0x008888F0;

    [[nodiscard]] constexpr DirectionBits o_to_t() const { return direction(0, 0); }
    [[nodiscard]] constexpr DirectionBits t_to_o() const { return direction(2, 4); }
    friend constexpr bool operator==(const ParameterWord&, const ParameterWord&) = default;

private:
    [[nodiscard]] constexpr bool bit(unsigned number) const { return (bits >> number & 1) != 0; }
    [[nodiscard]] constexpr DirectionBits direction(unsigned size_at, unsigned further) const {
        return {.fixed = bit(size_at),
                .variable = bit(size_at + 1),
                .format = static_cast<std::uint8_t>(bits >> (8 + further) & 7),
                .null = bit(16 + further),
                .multicast = bit(17 + further),
                .point_to_point = bit(18 + further),
                .priorities = static_cast<std::uint8_t>(bits >> (24 + further) & 15)};
    }
};

}  // namespace servobus::eds
