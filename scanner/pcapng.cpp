#include "scanner/pcapng.hpp"

#include <algorithm>
#include <string_view>

#include "cip/wire.hpp"
#include "enip/encapsulation.hpp"

namespace servobus::scanner {
namespace {

constexpr std::size_t ethernet_octets = 14;
constexpr std::size_t ip_octets = 20;
constexpr std::size_t udp_octets = 8;
constexpr std::size_t tcp_octets = 20;
constexpr std::uint8_t protocol_tcp = 6;
constexpr std::uint8_t protocol_udp = 17;

// TCP flags.
constexpr std::uint8_t fin = 0x01;
constexpr std::uint8_t syn = 0x02;
constexpr std::uint8_t push = 0x08;
constexpr std::uint8_t ack = 0x10;

constexpr std::uint16_t window = 65'535;
// A receiver that never sends acknowledges before its window is full.
constexpr std::size_t unacknowledged_limit = 16'384;

// Block types, options and link types of the pcapng format.
constexpr std::uint32_t section_header = 0x0A0D0D0A;
constexpr std::uint32_t interface_description = 1;
constexpr std::uint32_t enhanced_packet = 6;
constexpr std::uint32_t byte_order_magic = 0x1A2B3C4D;
constexpr std::uint16_t option_user_application = 4;
constexpr std::uint16_t option_time_resolution = 9;
constexpr std::uint16_t link_ethernet = 1;
constexpr std::uint8_t nanoseconds = 9;
constexpr std::string_view application = "Servobus";

/// The sum of 16-bit words in ones' complement, unfolded.
std::uint32_t sum_of(cip::ByteView octets, std::uint32_t sum = 0) {
    for (std::size_t i = 0; i < octets.size(); ++i) sum += i % 2 == 0 ? std::uint32_t{octets[i]} << 8 : octets[i];
    return sum;
}

std::uint16_t checksum(std::uint32_t sum) {
    while (sum > 0xFFFF) sum = (sum & 0xFFFF) + (sum >> 16);
    return static_cast<std::uint16_t>(~sum);
}

void put_big(cip::Bytes& octets, std::size_t offset, std::uint16_t value) {
    octets[offset] = static_cast<std::uint8_t>(value >> 8);
    octets[offset + 1] = static_cast<std::uint8_t>(value);
}

/// Over the pseudo header and what begins at `offset`.
std::uint16_t transport_checksum(const cip::Bytes& frame, std::uint8_t protocol) {
    const cip::ByteView view(frame);
    const auto addresses = view.subspan(ethernet_octets + 12, 8);
    const auto transport = view.subspan(ethernet_octets + ip_octets);
    return checksum(sum_of(transport, sum_of(addresses) + protocol + static_cast<std::uint32_t>(transport.size())));
}

/// Locally administered for a node, and the group's own for multicast.
void write_mac(cip::Writer& writer, std::uint32_t address) {
    if (enip::is_multicast(address)) {
        writer.big(std::uint16_t{0x0100});
        writer.u8(0x5E);
        writer.u8(address >> 16 & 0x7F);
        writer.big(static_cast<std::uint16_t>(address));
    } else {
        writer.big(std::uint16_t{0x0200});
        writer.big(address);
    }
}

std::size_t padded(std::size_t octets) { return (octets + 3) / 4 * 4; }

/// Appends a block around `body`, whose size is a multiple of four.
void write_block(std::ostream& out, std::uint32_t type, const cip::Bytes& body) {
    cip::Bytes ends;
    cip::Writer writer(ends);
    writer.u32(type);
    writer.u32(static_cast<std::uint32_t>(body.size() + 12));
    out.write(reinterpret_cast<const char*>(ends.data()), static_cast<std::streamsize>(ends.size()));
    out.write(reinterpret_cast<const char*>(body.data()), static_cast<std::streamsize>(body.size()));
    out.write(reinterpret_cast<const char*>(ends.data() + 4), 4);
}

void write_option(cip::Writer& writer, std::uint16_t code, cip::ByteView value) {
    writer.u16(code);
    writer.u16(static_cast<std::uint16_t>(value.size()));
    writer.bytes(value);
    writer.zeros(padded(value.size()) - value.size());
}

}  // namespace

PcapngWriter::PcapngWriter(std::ostream& out) : out_(out) {
    cip::Bytes section;
    cip::Writer writer(section);
    writer.u32(byte_order_magic);
    writer.u16(1);
    writer.u16(0);
    writer.u64(~std::uint64_t{0});  // the section's length is not told
    write_option(writer, option_user_application, cip::Bytes(application.begin(), application.end()));
    write_option(writer, 0, {});
    write_block(out_, section_header, section);

    cip::Bytes interface;
    cip::Writer description(interface);
    description.u16(link_ethernet);
    description.u16(0);
    description.u32(0);  // packets are never cut
    write_option(description, option_time_resolution, cip::Bytes{nanoseconds});
    write_option(description, 0, {});
    write_block(out_, interface_description, interface);
}

bool PcapngWriter::udp(enip::Endpoint source, enip::Endpoint destination, cip::ByteView payload, CaptureTime time) {
    if (payload.size() > max_udp_payload) return false;
    begin_frame(source, destination, protocol_udp, udp_octets + payload.size());
    cip::Writer writer(frame_);
    writer.big(source.port);
    writer.big(destination.port);
    writer.big(static_cast<std::uint16_t>(udp_octets + payload.size()));
    writer.big(std::uint16_t{0});
    writer.bytes(payload);
    const auto sum = transport_checksum(frame_, protocol_udp);
    // Zero would say that there is none.
    put_big(frame_, ethernet_octets + ip_octets + 6, sum == 0 ? 0xFFFF : sum);
    write_frame(time);
    return true;
}

void PcapngWriter::tcp(enip::Endpoint source, enip::Endpoint destination, cip::ByteView payload, CaptureTime time) {
    auto& connection = stream(source, destination, time);
    while (!payload.empty()) {
        const auto part = payload.first(std::min(payload.size(), tcp_segment));
        segment(source, destination, connection, push | ack, part, time);
        payload = payload.subspan(part.size());
        connection.unacknowledged += part.size();
        if (connection.unacknowledged < unacknowledged_limit) continue;
        segment(destination, source, connection, ack, {}, time);
        connection.unacknowledged = 0;
    }
}

void PcapngWriter::tcp_close(enip::Endpoint source, enip::Endpoint destination, CaptureTime time) {
    const auto found = streams_.find(std::minmax(source, destination));
    if (found == streams_.end()) return;
    segment(source, destination, found->second, fin | ack, {}, time);
    segment(destination, source, found->second, fin | ack, {}, time);
    segment(source, destination, found->second, ack, {}, time);
    streams_.erase(found);
}

PcapngWriter::Stream& PcapngWriter::stream(enip::Endpoint source, enip::Endpoint destination, CaptureTime time) {
    const Ends ends = std::minmax(source, destination);
    if (const auto found = streams_.find(ends); found != streams_.end()) return found->second;
    if (streams_.size() >= max_streams) {
        streams_.erase(std::ranges::min_element(streams_, {}, [](const auto& each) { return each.second.age; }));
    }
    auto& opened = streams_[ends];
    opened.age = ++opened_;
    const bool answered = source.port == enip::tcp_port && destination.port != enip::tcp_port;
    const auto client = answered ? destination : source;
    const auto server = answered ? source : destination;
    segment(client, server, opened, syn, {}, time);
    segment(server, client, opened, syn | ack, {}, time);
    segment(client, server, opened, ack, {}, time);
    return opened;
}

void PcapngWriter::segment(enip::Endpoint source, enip::Endpoint destination, Stream& stream, std::uint8_t flags,
                           cip::ByteView payload, CaptureTime time) {
    const bool first = source < destination;
    auto& own = first ? stream.next_of_first : stream.next_of_second;
    const auto other = first ? stream.next_of_second : stream.next_of_first;
    begin_frame(source, destination, protocol_tcp, tcp_octets + payload.size());
    cip::Writer writer(frame_);
    writer.big(source.port);
    writer.big(destination.port);
    writer.big(own);
    writer.big((flags & ack) != 0 ? other : std::uint32_t{0});
    writer.u8(tcp_octets / 4 << 4);
    writer.u8(flags);
    writer.big(window);
    writer.big(std::uint32_t{0});  // checksum and urgent pointer
    writer.bytes(payload);
    put_big(frame_, ethernet_octets + ip_octets + 16, transport_checksum(frame_, protocol_tcp));
    write_frame(time);
    own += static_cast<std::uint32_t>(payload.size()) + ((flags & (syn | fin)) != 0 ? 1 : 0);
}

void PcapngWriter::begin_frame(enip::Endpoint source, enip::Endpoint destination, std::uint8_t protocol,
                               std::size_t transport_octets) {
    frame_.clear();
    cip::Writer writer(frame_);
    write_mac(writer, destination.address);
    write_mac(writer, source.address);
    writer.big(std::uint16_t{0x0800});
    writer.u8(0x45);
    writer.u8(0);
    writer.big(static_cast<std::uint16_t>(ip_octets + transport_octets));
    writer.big(datagram_++);
    writer.big(std::uint16_t{0x4000});  // not to be fragmented
    writer.u8(enip::is_multicast(destination.address) ? 1 : 64);
    writer.u8(protocol);
    writer.big(std::uint16_t{0});
    writer.big(source.address);
    writer.big(destination.address);
    put_big(frame_, ethernet_octets + 10, checksum(sum_of(cip::ByteView(frame_).subspan(ethernet_octets))));
}

void PcapngWriter::write_frame(CaptureTime time) {
    const auto stamp = static_cast<std::uint64_t>(time.time_since_epoch().count());
    block_.clear();
    cip::Writer writer(block_);
    writer.u32(0);  // the interface
    writer.u32(static_cast<std::uint32_t>(stamp >> 32));
    writer.u32(static_cast<std::uint32_t>(stamp));
    writer.u32(static_cast<std::uint32_t>(frame_.size()));
    writer.u32(static_cast<std::uint32_t>(frame_.size()));
    writer.bytes(frame_);
    writer.zeros(padded(frame_.size()) - frame_.size());
    write_block(out_, enhanced_packet, block_);
    ++packets_;
}

}  // namespace servobus::scanner
