// The assembly instances as layouts over drive parameters (000 §2.4.2 to §2.4.4, R-DEV-6).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "cip/bytes.hpp"
#include "drive/device.hpp"
#include "drive/parameter.hpp"
#include "drive/refusal.hpp"

namespace servobus::assemblies {

enum class Direction : std::uint8_t { o_to_t, t_to_o };

/// A field of an assembly. Members follow each other without alignment.
struct Member {
    enum class Kind : std::uint8_t { parameter, padding, time_stamp };

    Kind kind = Kind::parameter;
    drive::Key key{};         ///< of the row, for Kind::parameter
    std::uint8_t octets = 0;  ///< on the wire
};

/// One assembly instance.
struct Layout {
    std::uint16_t instance;
    Direction direction;
    std::string_view name;
    std::span<const Member> members;

    [[nodiscard]] constexpr std::size_t size() const {
        std::size_t octets = 0;
        for (const auto& member : members) octets += member.octets;
        return octets;
    }
};

/// All layouts by instance: 100 to 105, 112, 113.
[[nodiscard]] std::span<const Layout> layouts();
[[nodiscard]] const Layout* find_layout(std::uint32_t instance);

/// Writes the members' present values into `image`, which has layout.size() octets. Time stamps are `time_stamp`.
void pack(const Layout& layout, const drive::Device& device, std::int64_t time_stamp, std::span<std::uint8_t> image);

/// Checks all members of `image` (layout.size() octets) and then writes all, or none: the first refusal is returned.
[[nodiscard]] std::optional<drive::Refusal> unpack(const Layout& layout, cip::ByteView image, drive::Device& device);

}  // namespace servobus::assemblies
