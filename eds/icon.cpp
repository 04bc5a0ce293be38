#include "eds/icon.hpp"

#include <array>
#include <cstdint>
#include <cstdlib>

#include "cip/wire.hpp"

namespace servobus::eds {
namespace {

constexpr int side = 32;

enum Colour : std::uint8_t { transparent, edge, body, white, rail, carriage, colour_count };

// Blue, green, red, and an octet that is not used.
constexpr std::array<std::array<std::uint8_t, 4>, 16> palette{{
    {0x00, 0x00, 0x00, 0x00},
    {0x40, 0x30, 0x20, 0x00},
    {0x90, 0x60, 0x20, 0x00},
    {0xFF, 0xFF, 0xFF, 0x00},
    {0xB0, 0xB0, 0xB0, 0x00},
    {0x20, 0x90, 0xF0, 0x00},
}};

// A box with an X on it, and below it a carriage on its rail.
Colour pixel(int x, int y) {
    const auto inside = [&](int left, int top, int right, int bottom) {
        return x >= left && x <= right && y >= top && y <= bottom;
    };
    if (inside(16, 21, 23, 28)) return carriage;
    if (inside(3, 24, 28, 26)) return rail;
    if (!inside(1, 1, 30, 30)) return transparent;
    if (!inside(2, 2, 29, 29)) return edge;
    const int from_middle = 2 * x - (side - 1);
    const int slope = 2 * y - 23;
    const bool on_x =
        inside(7, 4, 24, 19) && (std::abs(from_middle - slope) <= 3 || std::abs(from_middle + slope) <= 3);
    return on_x ? white : body;
}

}  // namespace

cip::Bytes icon() {
    constexpr std::uint32_t header_octets = 6 + 16;
    constexpr std::uint32_t info_octets = 40;
    constexpr std::uint32_t colour_octets = side * side / 2;
    constexpr std::uint32_t mask_octets = side * side / 8;
    cip::Bytes octets;
    cip::Writer writer(octets);
    // The directory: one icon, and where it is.
    for (const auto word : std::array<std::uint16_t, 3>{0, 1, 1}) writer.u16(word);
    for (const auto octet : std::array<std::uint8_t, 4>{side, side, 16, 0}) writer.u8(octet);
    writer.u16(1);
    writer.u16(4);
    writer.u32(info_octets + 4 * palette.size() + colour_octets + mask_octets);
    writer.u32(header_octets);
    // The bitmap: twice as high, since the mask is its second half.
    writer.u32(info_octets);
    writer.u32(side);
    writer.u32(2 * side);
    writer.u16(1);
    writer.u16(4);
    writer.u32(0);
    writer.u32(colour_octets + mask_octets);
    writer.zeros(16);
    for (const auto& colour : palette) writer.bytes(colour);
    // Lines from the lowest to the uppermost, the left pixel in the high bits.
    for (int y = side; y-- > 0;) {
        for (int x = 0; x < side; x += 2) writer.u8(static_cast<std::uint8_t>(pixel(x, y) << 4 | pixel(x + 1, y)));
    }
    for (int y = side; y-- > 0;) {
        for (int x = 0; x < side; x += 8) {
            unsigned bits = 0;
            for (int i = 0; i < 8; ++i) bits = bits << 1 | (pixel(x + i, y) == transparent ? 1U : 0U);
            writer.u8(static_cast<std::uint8_t>(bits));
        }
    }
    return octets;
}

}  // namespace servobus::eds
