#include "cip/path.hpp"

#include <fmt/format.h>

#include <array>
#include <string_view>

namespace servobus::cip {
namespace {

// The segment class: bits 7 to 5 of the first octet (R-PTH-1).
enum class SegmentClass : std::uint8_t {
    port,
    logical,
    network,
    symbolic,
    data,
    constructed_type,
    elementary_type,
    reserved
};

constexpr std::uint8_t special_key_format_4 = 0x04;
constexpr std::uint8_t special_key_format_5 = 0x05;
constexpr std::uint8_t simple_data = 0x80;
constexpr std::uint8_t ansi_extended_symbol = 0x91;
constexpr std::uint16_t extended_port = 15;

Decoded<Segment> read_key(Reader& reader) {
    const auto format = reader.u8();
    if (!reader.ok()) return DecodeError::truncated;
    if (format != special_key_format_4 && format != special_key_format_5) return DecodeError::bad_segment;
    ElectronicKey key;
    reader.field(key.vendor);
    reader.field(key.device_type);
    reader.field(key.product_code);
    reader.field(key.major_revision);
    reader.field(key.minor_revision);
    if (format == special_key_format_5) key.serial_number = reader.u32();
    if (!reader.ok()) return DecodeError::truncated;
    return Segment{key};
}

Decoded<Segment> read_logical(std::uint8_t first, Reader& reader) {
    const auto type = static_cast<LogicalType>((first >> 2) & 7);
    const auto format = first & 3;
    if (type == LogicalType::special) {
        if (format != 0) return DecodeError::bad_segment;
        return read_key(reader);
    }
    if (type == LogicalType::extended || format == 3) return DecodeError::bad_segment;
    LogicalSegment segment{type, 0, static_cast<Width>(format)};
    switch (segment.width) {
        case Width::bits8:
            segment.value = reader.u8();
            break;
        case Width::bits16:
            reader.take(1);  // the pad octet is not checked (R-PTH-3)
            segment.value = reader.u16();
            break;
        case Width::bits32:
            reader.take(1);
            segment.value = reader.u32();
            break;
    }
    if (!reader.ok()) return DecodeError::truncated;
    return Segment{segment};
}

Decoded<Segment> read_port(std::uint8_t first, Reader& reader) {
    PortSegment segment;
    const bool long_address = (first & 0x10) != 0;
    std::size_t address_size = long_address ? reader.u8() : 1;
    segment.port = first & 0x0F;
    const bool wide_port = segment.port == extended_port;
    if (wide_port) segment.port = reader.u16();
    if (reader.ok() && segment.port == 0) return DecodeError::bad_segment;
    const auto address = reader.take(address_size);
    segment.link_address.assign(address.begin(), address.end());
    const std::size_t used = 1 + (long_address ? 1U : 0U) + (wide_port ? 2U : 0U) + address_size;
    if (used % 2 != 0) reader.take(1);
    if (!reader.ok()) return DecodeError::truncated;
    return Segment{segment};
}

Decoded<Segment> read_network(std::uint8_t first, Reader& reader) {
    NetworkSegment segment{first, {}};
    // 0x40..0x4F carry one octet, 0x50..0x5F a size in words (R-PTH-7).
    const std::size_t size = (first & 0x10) != 0 ? reader.u8() * std::size_t{2} : 1;
    const auto data = reader.take(size);
    if (!reader.ok()) return DecodeError::truncated;
    segment.data.assign(data.begin(), data.end());
    return Segment{segment};
}

Decoded<Segment> read_symbol(Reader& reader, std::size_t length, bool extended) {
    const auto name = reader.take(length);
    const std::size_t used = length + (extended ? 2 : 1);
    if (used % 2 != 0) reader.take(1);
    if (!reader.ok()) return DecodeError::truncated;
    return Segment{SymbolSegment{{name.begin(), name.end()}, extended}};
}

Decoded<Segment> read_data(std::uint8_t first, Reader& reader) {
    const std::size_t size = reader.u8();
    if (!reader.ok()) return DecodeError::truncated;
    if (first == ansi_extended_symbol) return read_symbol(reader, size, true);
    if (first != simple_data) return DecodeError::bad_segment;
    const auto data = reader.take(size * 2);
    if (!reader.ok()) return DecodeError::truncated;
    return Segment{DataSegment{{data.begin(), data.end()}}};
}

void write_segment(Writer& writer, const LogicalSegment& segment) {
    writer.u8(static_cast<std::uint8_t>(0x20 | (static_cast<unsigned>(segment.type) << 2) |
                                        static_cast<unsigned>(segment.width)));
    switch (segment.width) {
        case Width::bits8:
            writer.u8(static_cast<std::uint8_t>(segment.value));
            break;
        case Width::bits16:
            writer.u8(0);
            writer.u16(static_cast<std::uint16_t>(segment.value));
            break;
        case Width::bits32:
            writer.u8(0);
            writer.u32(segment.value);
            break;
    }
}

void write_segment(Writer& writer, const ElectronicKey& key) {
    writer.u8(0x34);
    writer.u8(key.serial_number ? special_key_format_5 : special_key_format_4);
    writer.field(key.vendor);
    writer.field(key.device_type);
    writer.field(key.product_code);
    writer.field(key.major_revision);
    writer.field(key.minor_revision);
    if (key.serial_number) writer.u32(*key.serial_number);
}

void write_segment(Writer& writer, const PortSegment& segment) {
    const bool long_address = segment.link_address.size() != 1;
    const bool wide_port = segment.port >= extended_port;
    const auto start = writer.size();
    writer.u8(static_cast<std::uint8_t>((long_address ? 0x10U : 0U) | (wide_port ? extended_port : segment.port)));
    if (long_address) writer.u8(static_cast<std::uint8_t>(segment.link_address.size()));
    if (wide_port) writer.u16(segment.port);
    writer.bytes(segment.link_address);
    if ((writer.size() - start) % 2 != 0) writer.u8(0);
}

void write_segment(Writer& writer, const NetworkSegment& segment) {
    writer.u8(segment.type);
    if ((segment.type & 0x10) != 0) writer.u8(static_cast<std::uint8_t>(segment.data.size() / 2));
    writer.bytes(segment.data);
}

void write_segment(Writer& writer, const SymbolSegment& segment) {
    const auto start = writer.size();
    const auto size = static_cast<std::uint8_t>(segment.name.size());
    if (segment.extended) {
        writer.u8(ansi_extended_symbol);
        writer.u8(size);
    } else {
        writer.u8(static_cast<std::uint8_t>(0x60 | size));
    }
    for (const char c : segment.name) writer.u8(static_cast<std::uint8_t>(c));
    if ((writer.size() - start) % 2 != 0) writer.u8(0);
}

void write_segment(Writer& writer, const DataSegment& segment) {
    writer.u8(simple_data);
    writer.u8(static_cast<std::uint8_t>((segment.data.size() + 1) / 2));
    writer.bytes(segment.data);
    if (segment.data.size() % 2 != 0) writer.u8(0);
}

std::string text(const LogicalSegment& segment) {
    static constexpr std::array<std::string_view, 8> names{"class",     "instance", "member",     "connection point",
                                                           "attribute", "special",  "service id", "extended"};
    return fmt::format("{} 0x{:02X}", names[static_cast<std::size_t>(segment.type)], segment.value);
}

std::string text(const ElectronicKey& key) {
    return fmt::format("key vendor {} type {} product 0x{:04X} revision {}.{}", key.vendor, key.device_type,
                       key.product_code, key.major_revision & 0x7F, key.minor_revision);
}

std::string text(const PortSegment& segment) {
    if (segment.link_address.size() == 1) return fmt::format("port {} link {}", segment.port, segment.link_address[0]);
    return fmt::format("port {} link {}", segment.port,
                       std::string(segment.link_address.begin(), segment.link_address.end()));
}

std::string text(const NetworkSegment& segment) { return fmt::format("network segment 0x{:02X}", segment.type); }
std::string text(const SymbolSegment& segment) { return fmt::format("symbol {}", segment.name); }
std::string text(const DataSegment& segment) { return fmt::format("{} octets of data", segment.data.size()); }

}  // namespace

LogicalSegment logical(LogicalType type, std::uint32_t value) {
    const auto width = value <= 0xFF ? Width::bits8 : value <= 0xFFFF ? Width::bits16 : Width::bits32;
    return {type, value, width};
}

Path Path::to(std::uint32_t class_id, std::uint32_t instance) {
    return Path({logical(LogicalType::class_id, class_id), logical(LogicalType::instance, instance)});
}

Path Path::to(std::uint32_t class_id, std::uint32_t instance, std::uint32_t attribute) {
    auto path = to(class_id, instance);
    path.segments.emplace_back(logical(LogicalType::attribute, attribute));
    return path;
}

Decoded<Segment> read_segment(Reader& reader) {
    const auto first = reader.u8();
    switch (static_cast<SegmentClass>(first >> 5)) {
        case SegmentClass::port:
            return read_port(first, reader);
        case SegmentClass::logical:
            return read_logical(first, reader);
        case SegmentClass::network:
            return read_network(first, reader);
        case SegmentClass::symbolic:
            if ((first & 0x1F) == 0) return DecodeError::bad_segment;  // extended string formats
            return read_symbol(reader, first & 0x1F, false);
        case SegmentClass::data:
            return read_data(first, reader);
        case SegmentClass::constructed_type:
        case SegmentClass::elementary_type:
        case SegmentClass::reserved:
            return DecodeError::bad_segment;
    }
    return DecodeError::bad_segment;
}

Decoded<Path> Path::parse(ByteView bytes) {
    Reader reader(bytes);
    Path path;
    constexpr std::size_t usual_segments = 3;  // class, instance, attribute
    path.segments.reserve(usual_segments);
    while (reader.remaining() > 0) {
        auto segment = read_segment(reader);
        if (!segment) return segment.error();
        path.segments.push_back(std::move(*segment));
    }
    return path;
}

void Path::write(Writer& writer) const {
    for (const auto& segment : segments) {
        std::visit([&](const auto& known) { write_segment(writer, known); }, segment);
    }
}

Bytes Path::encode() const {
    Bytes bytes;
    Writer writer(bytes);
    write(writer);
    return bytes;
}

std::size_t Path::words() const { return encode().size() / 2; }

std::string describe(const Path& path) {
    std::string line;
    for (const auto& segment : path.segments) {
        if (!line.empty()) line += ", ";
        line += std::visit([](const auto& known) { return text(known); }, segment);
    }
    return line;
}

}  // namespace servobus::cip
