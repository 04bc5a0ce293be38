#include "adapter/flash_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/crc.hpp>

#include "cip/wire.hpp"

namespace servobus::adapter {
namespace {

constexpr std::array<std::uint8_t, 8> magic{'S', 'V', 'B', 'F', 'L', 'A', 'S', 'H'};
constexpr std::uint16_t known_format = 1;
constexpr std::size_t head_octets = 24;
constexpr std::size_t checksum_octets = 4;
constexpr std::size_t most_products = 16;
constexpr std::uint8_t highest_minor_version = 99;
constexpr std::uint8_t highest_major_revision = 127;  // R-ID-1

std::uint32_t crc_of(cip::ByteView octets) {
    boost::crc_32_type crc;
    crc.process_bytes(octets.data(), octets.size());
    return crc.checksum();
}

// What is wrong with the numbers of a head; empty when nothing is.
std::string check_head(const FlashImage& image, std::size_t products, bool sets_revision) {
    if (image.version.minor > highest_minor_version) {
        return fmt::format("its version is {}.{}; the second number goes to {}", image.version.major,
                           image.version.minor, highest_minor_version);
    }
    if (products == 0 || products > most_products) {
        return fmt::format("it names {} products; 1 to {} can be", products, most_products);
    }
    if (image.bit_stream_octets == 0 || image.firmware_octets == 0) return "it has no bit stream or no firmware";
    const auto revision = image.revision.value_or(Revision{});
    if (sets_revision && (revision.major == 0 || revision.major > highest_major_revision || revision.minor == 0)) {
        return fmt::format("its revision is {}.{}; 1.1 to {}.255 can be", revision.major, revision.minor,
                           highest_major_revision);
    }
    return {};
}

}  // namespace

std::string to_string(FirmwareVersion version) { return fmt::format("{}.{:02}", version.major, version.minor); }

bool FlashImage::fits(std::uint16_t product_code) const {
    return std::ranges::find(product_codes, product_code) != product_codes.end();
}

std::variant<FlashImage, std::string> FlashImage::parse(cip::ByteView file) {
    if (file.size() > max_flash_octets) return fmt::format("it has more than {} octets", max_flash_octets);
    cip::Reader reader(file);
    const auto mark = reader.take(magic.size());
    if (!reader.ok() || !std::ranges::equal(mark, magic)) return "it is no flash image: it does not begin as one";
    const auto format = reader.u16();
    if (reader.ok() && format != known_format)
        return fmt::format("its format is {}; {} is known", format, known_format);
    FlashImage image;
    image.version = {reader.u8(), reader.u8()};
    const Revision revision{reader.u8(), reader.u8()};
    const bool sets_revision = revision != Revision{0, 0};
    if (sets_revision) image.revision = revision;
    const std::size_t products = reader.u16();
    image.bit_stream_octets = reader.u32();
    image.firmware_octets = reader.u32();
    if (!reader.ok())
        return fmt::format("it is cut off: it has {} octets, its head alone {}", file.size(), head_octets);
    const auto whole = head_octets + 2 * products + image.bit_stream_octets + image.firmware_octets + checksum_octets;
    if (file.size() != whole) {
        return fmt::format("it {}: it has {} octets and speaks of {}",
                           file.size() < whole ? "is cut off" : "is too long", file.size(), whole);
    }
    const auto checked = file.first(file.size() - checksum_octets);
    const auto stated = cip::Reader(file.subspan(checked.size())).u32();
    if (const auto found = crc_of(checked); found != stated) {
        return fmt::format("it is damaged: its checksum is 0x{:08X}, and that of its octets 0x{:08X}", stated, found);
    }
    if (auto wrong = check_head(image, products, sets_revision); !wrong.empty()) return wrong;
    for (std::size_t i = 0; i < products; ++i) image.product_codes.push_back(reader.u16());
    return image;
}

}  // namespace servobus::adapter
