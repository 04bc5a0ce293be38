#include "enip/encapsulation.hpp"

#include <fmt/format.h>

#include "enip/header.hpp"

namespace servobus::enip {

std::string describe(EncapsulationStatus status) {
    switch (status) {
        case EncapsulationStatus::success:
            return "success";
        case EncapsulationStatus::unsupported_command:
            return "invalid or unsupported command";
        case EncapsulationStatus::insufficient_memory:
            return "not enough memory or no session left";
        case EncapsulationStatus::incorrect_data:
            return "malformed data portion";
        case EncapsulationStatus::invalid_session:
            return "invalid session handle";
        case EncapsulationStatus::invalid_length:
            return "invalid length";
        case EncapsulationStatus::unsupported_protocol:
            return "unsupported protocol version";
    }
    return fmt::format("status 0x{:04X}", static_cast<std::uint32_t>(status));
}

std::string describe(Command command) {
    switch (command) {
        case Command::nop:
            return "NOP";
        case Command::list_services:
            return "ListServices";
        case Command::list_identity:
            return "ListIdentity";
        case Command::list_interfaces:
            return "ListInterfaces";
        case Command::register_session:
            return "RegisterSession";
        case Command::unregister_session:
            return "UnRegisterSession";
        case Command::send_rr_data:
            return "SendRRData";
        case Command::send_unit_data:
            return "SendUnitData";
    }
    return fmt::format("command 0x{:04X}", static_cast<std::uint16_t>(command));
}

void Frame::write(cip::Bytes& out) const {
    cip::Writer writer(out);
    const auto length = static_cast<std::uint16_t>(data.size());
    describe_header(writer, *this, length);
    writer.bytes(data);
}

cip::Bytes Frame::encode() const {
    cip::Bytes bytes;
    bytes.reserve(header_bytes + data.size());
    write(bytes);
    return bytes;
}

cip::Decoded<Frame> Frame::parse(cip::ByteView datagram) {
    cip::Reader reader(datagram);
    Frame frame;
    std::uint16_t length = 0;
    describe_header(reader, frame, length);
    const auto data = reader.take(length);
    if (!reader.ok()) return cip::DecodeError::truncated;
    if (length > max_data_bytes) return cip::DecodeError::too_many;
    frame.data.assign(data.begin(), data.end());
    return frame;
}

Frame Frame::reply(EncapsulationStatus code, cip::Bytes body) const {
    return {command, session, code, context, 0, std::move(body)};
}

}  // namespace servobus::enip
