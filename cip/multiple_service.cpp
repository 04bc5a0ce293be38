#include "cip/multiple_service.hpp"

#include <algorithm>

#include "cip/wire.hpp"

namespace servobus::cip {

Bytes write_parts(std::span<const Bytes> parts) {
    Bytes bytes;
    Writer writer(bytes);
    writer.u16(static_cast<std::uint16_t>(parts.size()));
    auto offset = parts_head(parts.size());
    for (const auto& part : parts) {
        writer.u16(static_cast<std::uint16_t>(offset));
        offset += part.size();
    }
    for (const auto& part : parts) writer.bytes(part);
    return bytes;
}

Decoded<std::vector<ByteView>> read_parts(ByteView data) {
    Reader reader(data);
    const std::size_t count = reader.u16();
    std::vector<std::size_t> offsets;
    for (std::size_t i = 0; i < count && reader.ok(); ++i) offsets.push_back(reader.u16());
    if (!reader.ok()) return DecodeError::truncated;
    offsets.push_back(data.size());
    if (offsets.front() < parts_head(count) || !std::ranges::is_sorted(offsets)) return DecodeError::bad_length;
    std::vector<ByteView> parts;
    for (std::size_t i = 0; i < count; ++i) parts.push_back(data.subspan(offsets[i], offsets[i + 1] - offsets[i]));
    return parts;
}

}  // namespace servobus::cip
