#include "adapter/ring_frame.hpp"

#include "adapter/ethernet_frame.hpp"
#include "cip/wire.hpp"

namespace servobus::adapter {
namespace {

constexpr std::uint16_t priority_tag = 0xE000;  // priority 7, no VLAN
constexpr std::uint8_t sub_type = 0x02;
constexpr std::uint8_t protocol_version = 0x01;
constexpr std::size_t beacon_reserved = 20;

void describe(auto& io, auto& frame) {
    io.field(frame.type);
    io.field(frame.source_port);
    io.big_endian_field(frame.source_address);
    io.big_endian_field(frame.sequence);
}

void describe_beacon(auto& io, auto& beacon) {
    io.field(beacon.state);
    io.field(beacon.precedence);
    io.big_endian_field(beacon.interval);
    io.big_endian_field(beacon.timeout);
}

void describe_entry(auto& io, auto& entry) {
    io.field(entry.mac);
    io.big_endian_field(entry.address);
}

}  // namespace

cip::Bytes RingFrame::encode() const {
    cip::Bytes payload;
    cip::Writer writer(payload);
    writer.u8(sub_type);
    writer.u8(protocol_version);
    describe(writer, *this);
    writer.bytes(content);
    EthernetFrame frame{.destination = destination, .source = source, .type = EtherType::ring, .payload = payload};
    if (type != RingFrameType::learning_update) frame.vlan_tag = priority_tag;
    return frame.encode();
}

cip::Decoded<RingFrame> RingFrame::parse(cip::ByteView octets) {
    const auto ethernet = EthernetFrame::parse(octets);
    if (!ethernet) return ethernet.error();
    if (ethernet->type != EtherType::ring) return cip::DecodeError::bad_value;
    cip::Reader reader(ethernet->payload);
    const auto kind = reader.u8();
    const auto version = reader.u8();
    RingFrame frame{.destination = ethernet->destination, .source = ethernet->source};
    describe(reader, frame);
    if (!reader.ok()) return cip::DecodeError::truncated;
    if (kind != sub_type || version != protocol_version) return cip::DecodeError::bad_value;
    if (frame.type < RingFrameType::beacon || frame.type > RingFrameType::learning_update) {
        return cip::DecodeError::bad_value;
    }
    frame.content = reader.rest();
    return frame;
}

cip::Bytes Beacon::encode() const {
    cip::Bytes content;
    cip::Writer writer(content);
    describe_beacon(writer, *this);
    writer.zeros(beacon_reserved);
    return content;
}

cip::Decoded<Beacon> Beacon::parse(cip::ByteView content) {
    cip::Reader reader(content);
    Beacon beacon;
    describe_beacon(reader, beacon);
    if (!reader.ok()) return cip::DecodeError::truncated;
    const bool known = beacon.state == RingState::normal || beacon.state == RingState::fault;
    if (!known || beacon.timeout == 0) return cip::DecodeError::bad_value;
    return beacon;
}

cip::Bytes encode_sign_on(const std::vector<SignOnEntry>& entries) {
    cip::Bytes content;
    cip::Writer writer(content);
    writer.big(static_cast<std::uint16_t>(entries.size()));
    for (const auto& entry : entries) describe_entry(writer, entry);
    return content;
}

cip::Decoded<std::vector<SignOnEntry>> parse_sign_on(cip::ByteView content) {
    cip::Reader reader(content);
    const auto count = reader.big<std::uint16_t>();
    if (count > max_sign_on_entries) return cip::DecodeError::too_many;
    std::vector<SignOnEntry> entries(count);
    for (auto& entry : entries) describe_entry(reader, entry);
    if (!reader.ok()) return cip::DecodeError::truncated;
    return entries;
}

}  // namespace servobus::adapter
