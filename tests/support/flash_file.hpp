// Firmware images as files have them, written once more so that they are compared with something. The checksum is computed
// bit by bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/wire.hpp"

namespace servobus::test {

struct FlashFile {
    std::uint8_t major = 1;
    std::uint8_t minor = 5;
    std::uint8_t major_revision = 0;
    std::uint8_t minor_revision = 0;
    std::vector<std::uint16_t> products{0x7509};
    std::uint32_t bit_stream = 65536;  ///< octets, a second's worth
    std::uint32_t firmware = 65536;
    std::uint16_t format = 1;

    cip::Bytes octets() const {
        cip::Bytes file;
        cip::Writer writer(file);
        for (const char c : {'S', 'V', 'B', 'F', 'L', 'A', 'S', 'H'}) writer.u8(static_cast<std::uint8_t>(c));
        writer.u16(format);
        for (const auto octet : {major, minor, major_revision, minor_revision}) writer.u8(octet);
        writer.u16(static_cast<std::uint16_t>(products.size()));
        writer.u32(bit_stream);
        writer.u32(firmware);
        for (const auto product : products) writer.u16(product);
        writer.zeros(bit_stream + firmware);
        writer.u32(crc32(file));
        return file;
    }

    static std::uint32_t crc32(cip::ByteView data) {
        std::uint32_t crc = 0xFFFFFFFF;
        for (const auto octet : data) {
            crc ^= octet;
            for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? crc >> 1 ^ 0xEDB88320 : crc >> 1;
        }
        return ~crc;
    }
};

}  // namespace servobus::test
