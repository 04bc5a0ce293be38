#include "cip/unconnected_send.hpp"

#include "cip/wire.hpp"

namespace servobus::cip {

Bytes UnconnectedSend::encode() const {
    Bytes bytes;
    Writer writer(bytes);
    writer.u8(priority_tick);
    writer.u8(timeout_ticks);
    writer.u16(static_cast<std::uint16_t>(message.size()));
    writer.bytes(message);
    if (message.size() % 2 != 0) writer.u8(0);
    writer.u8(static_cast<std::uint8_t>(route_path.size() / 2));
    writer.u8(0);
    writer.bytes(route_path);
    return bytes;
}

Decoded<UnconnectedSend> UnconnectedSend::parse(ByteView data) {
    Reader reader(data);
    UnconnectedSend send;
    reader.field(send.priority_tick);
    reader.field(send.timeout_ticks);
    const std::size_t length = reader.u16();
    const auto message = reader.take(length);
    if (length % 2 != 0) reader.reserved(1);
    const auto route_octets = reader.u8() * std::size_t{2};
    reader.reserved(1);
    const auto route = reader.take(route_octets);
    if (!reader.ok()) return DecodeError::truncated;
    if (reader.remaining() > 0) return DecodeError::trailing;
    send.message.assign(message.begin(), message.end());
    send.route_path.assign(route.begin(), route.end());
    return send;
}

}  // namespace servobus::cip
