#include "adapter/ethernet_frame.hpp"

#include "cip/wire.hpp"

namespace servobus::adapter {

cip::Bytes EthernetFrame::encode() const {
    cip::Bytes octets;
    cip::Writer writer(octets);
    writer.bytes(destination);
    writer.bytes(source);
    if (vlan_tag) {
        writer.big(EtherType::vlan);
        writer.big(*vlan_tag);
    }
    writer.big(type);
    writer.bytes(payload);
    if (payload.size() < shortest_payload) writer.zeros(shortest_payload - payload.size());
    return octets;
}

cip::Decoded<EthernetFrame> EthernetFrame::parse(cip::ByteView octets) {
    cip::Reader reader(octets);
    EthernetFrame frame;
    reader.field(frame.destination);
    reader.field(frame.source);
    reader.big_endian_field(frame.type);
    if (frame.type == EtherType::vlan) {
        frame.vlan_tag = reader.big<std::uint16_t>();
        reader.big_endian_field(frame.type);
    }
    if (!reader.ok()) return cip::DecodeError::truncated;
    frame.payload = reader.rest();
    return frame;
}

}  // namespace servobus::adapter
