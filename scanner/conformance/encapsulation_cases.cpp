// Encapsulation header and commands, over TCP and UDP (R-ENC, R-CPF-4, R-CPF-5).
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "enip/asio/discovery.hpp"
#include "enip/messages.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"

namespace servobus::scanner::conformance {
namespace {

using enip::Command;
using enip::CommonPacket;
using enip::EncapsulationStatus;
using enip::Frame;
using enip::ItemType;

constexpr auto ListServices = Command::list_services;
constexpr auto ListIdentity = Command::list_identity;
constexpr auto ListInterfaces = Command::list_interfaces;

/// The one item of a List reply, or nullopt with what is wrong held against the device.
std::optional<enip::Item> only_item(Bench& bench, const std::optional<Frame>& reply, ItemType type) {
    if (!reply) return std::nullopt;
    bench.require(reply->status == EncapsulationStatus::success, "status " + enip::describe(reply->status));
    const auto packet = CommonPacket::parse(reply->data);
    if (!bench.require(packet.has_value(), "the items of the reply cannot be read")) return std::nullopt;
    const auto* item = packet->find(type);
    if (!bench.require(item != nullptr, fmt::format("there is no item 0x{:04X}", static_cast<unsigned>(type)))) {
        return std::nullopt;
    }
    bench.advise(packet->items.size() == 1, fmt::format("{} items, and one is usual", packet->items.size()));
    return *item;
}

std::optional<Frame> over_tcp(Bench& bench, Command command) {
    Wire wire(bench);
    return wire.is_open() ? wire.exchange(make_frame(bench, command)) : std::nullopt;
}

std::optional<Frame> over_udp(Bench& bench, Command command) {
    if (bench.subject().address.address == 0) {
        bench.skip("the device is not reached over IPv4");
        return std::nullopt;
    }
    Udp udp(bench);
    auto reply = udp.exchange(make_frame(bench, command));
    bench.require(reply.has_value(), fmt::format("no answer to {} over UDP", enip::describe(command)));
    return reply;
}

void list_services(Bench& bench) {
    const auto item = only_item(bench, over_tcp(bench, ListServices), ItemType::service_information);
    if (!item) return;
    const auto service = enip::ServiceItem::parse(item->data);
    if (!bench.require(service.has_value(), fmt::format("the item has {} octets and not 20", item->data.size())))
        return;
    bench.require(service->version == enip::protocol_version, fmt::format("version {} and not 1", service->version));
    bench.require((service->flags & enip::ServiceItem::cip_over_tcp) != 0,
                  "the flag for CIP over TCP (0x0020) is not set");
    constexpr unsigned known = enip::ServiceItem::cip_over_tcp | enip::ServiceItem::io_over_udp;
    bench.advise((service->flags & ~known) == 0,
                 fmt::format("flags 0x{:04X}: others than 0x0120 are reserved", service->flags));
    bench.advise(service->name == "Communications",
                 fmt::format("the name is '{}' and not 'Communications'", service->name));
}

/// What both ways answer must be the same.
void same_over_both(Bench& bench, Command command) {
    const auto tcp = over_tcp(bench, command);
    const auto udp = over_udp(bench, command);
    if (!tcp || !udp) return;
    bench.require(tcp->status == udp->status && tcp->data == udp->data,
                  fmt::format("{} is answered differently over TCP and UDP", enip::describe(command)));
}

void list_identity_over_udp(Bench& bench) {
    const auto tcp = over_tcp(bench, ListIdentity);
    const auto udp = over_udp(bench, ListIdentity);
    if (!tcp || !udp) return;
    const auto first = enip::asio::read_identity_reply(*tcp);
    const auto second = enip::asio::read_identity_reply(*udp);
    if (!bench.require(first && second, "an identity item cannot be read")) return;
    // The status may change from one moment to the next.
    auto expected = *second;
    expected.status = first->status;
    expected.state = first->state;
    expected.socket = first->socket;
    bench.require(*first == expected, "the device says two different things about itself");
}

std::optional<enip::IdentityItem> identity_item(Bench& bench) {
    const auto item = only_item(bench, over_tcp(bench, ListIdentity), ItemType::identity);
    if (!item) return std::nullopt;
    const auto parsed = enip::IdentityItem::parse(item->data);
    if (bench.require(parsed.has_value(),
                      fmt::format("the identity item of {} octets is not 34 octets and the name", item->data.size()))) {
        return *parsed;
    }
    return std::nullopt;
}

void identity_item_shape(Bench& bench) {
    const auto item = identity_item(bench);
    if (!item) return;
    bench.require(item->version == enip::protocol_version, fmt::format("version {} and not 1", item->version));
    bench.require(item->vendor != 0, "the vendor id is 0");
    bench.require(!item->product_name.empty(), "there is no product name");
}

void identity_socket_address(Bench& bench) {
    const auto item = identity_item(bench);
    if (!item) return;
    constexpr std::uint16_t inet = 2;
    bench.require(item->socket.family == inet, fmt::format("the address family is {} and not 2", item->socket.family));
    const auto port = bench.subject().options().host.port;
    bench.require(item->socket.port == port, fmt::format("the port is {} and not {}", item->socket.port, port));
    bench.require(std::ranges::all_of(item->socket.zero, [](std::uint8_t octet) { return octet == 0; }),
                  "the eight octets behind the address are not zero");
    bench.advise(item->socket.address == bench.subject().address.address,
                 fmt::format("the address is {} and not the one that was called: a translation on the way?",
                             enip::address_text(item->socket.address)));
}

void list_interfaces(Bench& bench, const std::optional<Frame>& reply) {
    if (!reply) return;
    bench.require(reply->status == EncapsulationStatus::success, "status " + enip::describe(reply->status));
    const auto packet = CommonPacket::parse(reply->data);
    if (!bench.require(packet.has_value(), "the items of the reply cannot be read")) return;
    bench.advise(packet->items.empty(), fmt::format("{} items, and none is usual", packet->items.size()));
}

void context_is_echoed(Bench& bench, Command command) {
    Wire wire(bench);
    if (!wire.is_open()) return;
    auto request = make_frame(bench, command);
    request.context = {0xFF, 0x00, 0x5A, 0xA5, 0x01, 0xFE, 0x80, 0x7F};
    if (!wire.send(request)) return;
    const auto reply = wire.receive();
    if (!bench.require(reply.has_value(), "no answer")) return;
    bench.require(reply->context == request.context, "the sender context comes back changed");
}

void context_of_a_request(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    auto request = session.rr_frame(hex("0E 03 20 01 24 01 30 01"));
    request.context = {0x80, 0x00, 0x00, 0xFF, 0x12, 0x34, 0x56, 0x78};
    if (!session.wire().send(request)) return;
    const auto reply = session.wire().receive();
    if (!bench.require(reply.has_value(), "no answer")) return;
    bench.require(reply->context == request.context, "the sender context comes back changed");
    bench.require(reply->session == session.handle(), "the session handle comes back changed");
}

void header_of_a_reply(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto reply = session.wire().exchange(session.rr_frame(hex("0E 03 20 01 24 01 30 01")));
    if (!reply) return;
    bench.require(reply->command == Command::send_rr_data, "the command comes back changed");
    bench.require(reply->session == session.handle(), "the session handle comes back changed");
    bench.require(reply->status == EncapsulationStatus::success, "status " + enip::describe(reply->status));
    bench.require(reply->options == 0, fmt::format("options 0x{:08X} in the reply", reply->options));
    // A length that is wrong shows in what comes next.
    bench.require(session.wire().is_alive(), "what comes behind the reply is no message: its length is wrong");
}

void handle_is_copied(Bench& bench) {
    Wire wire(bench);
    if (!wire.is_open()) return;
    constexpr std::uint32_t anybody = 0x12345678;
    const auto reply = wire.exchange(make_frame(bench, ListIdentity, {}, anybody));
    if (!reply) return;
    if (!bench.require(reply->status == EncapsulationStatus::success, "status " + enip::describe(reply->status)))
        return;
    bench.advise(reply->session == anybody, fmt::format("the session handle in the reply is 0x{:08X}", reply->session));
}

void silent(Bench& bench, const Frame& frame, std::string_view what, bool firm = true) {
    Wire wire(bench);
    if (wire.is_open()) wire.expect_silence(frame.encode(), what, firm);
}

void unknown_command(Bench& bench, std::uint16_t code, cip::Bytes data, Weight weight = Weight::exact) {
    Wire wire(bench);
    if (!wire.is_open()) return;
    refused(bench, wire.exchange(make_frame(bench, static_cast<Command>(code), std::move(data))), {0x0001}, {}, weight);
    bench.require(wire.is_alive(), "the connection does not answer any more");
}

Frame with_options(Frame frame) {
    frame.options = 0x00000001;
    return frame;
}

void options_in_a_request(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    session.wire().expect_silence(with_options(session.rr_frame(hex("0E 03 20 01 24 01 30 01"))).encode(),
                                  "a SendRRData with options");
}

void options_in_register_session(Bench& bench) {
    Wire wire(bench);
    if (!wire.is_open()) return;
    const auto request = with_options(make_frame(bench, Command::register_session, hex("01 00 00 00")));
    const auto marker = make_frame(bench, ListServices);
    if (!wire.send(request) || !wire.send(marker)) return;
    const auto reply = wire.receive();
    if (!bench.require(reply.has_value(), "the connection does not answer any more")) return;
    if (reply->context == marker.context) {
        bench.advise(false, "it is passed over; most devices answer status 0x0069");
        return;
    }
    refused(bench, reply, {0x0069}, {}, Weight::any);
}

void status_in_a_request(Bench& bench) {
    auto frame = make_frame(bench, ListServices);
    frame.status = EncapsulationStatus::unsupported_command;
    silent(bench, frame, "a request with a status", false);
}

void list_with_data(Bench& bench, Command command) {
    Wire wire(bench);
    if (!wire.is_open()) return;
    refused(bench, wire.exchange(make_frame(bench, command, hex("00 00"))), {0x0065}, {}, Weight::soft);
    bench.require(wire.is_alive(), "the connection does not answer any more");
}

/// A message that is longer than anybody needs is read to its end, or ends the connection.
void too_long(Bench& bench, std::size_t octets) {
    Wire wire(bench);
    if (!wire.is_open()) return;
    const auto request = make_frame(bench, static_cast<Command>(0x1234), cip::Bytes(octets));
    static_cast<void>(wire.send(request));
    const auto reply = wire.receive();
    if (!reply && !wire.is_open()) {
        bench.advise(false, "the device closes the connection");
        return;
    }
    if (!bench.require(reply.has_value(), "no answer, and the connection stays open")) return;
    // 0x0001 where it was read and only the command is unknown.
    refused(bench, reply, {0x0065, 0x0002, 0x0001}, {}, Weight::any);
    bench.require(wire.is_alive(), "the connection has lost its place: what follows is not answered");
}

void octet_by_octet(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto request = session.rr_frame(hex("0E 03 20 01 24 01 30 01"));
    for (const auto octet : request.encode()) {
        if (!session.wire().send(std::array{octet}, "one octet of a SendRRData")) return;
    }
    const auto reply = session.wire().answer_to(request);
    if (reply) bench.require(reply->status == EncapsulationStatus::success, "status " + enip::describe(reply->status));
}

void joined(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const std::array requests{make_frame(bench, ListServices), session.rr_frame(hex("0E 03 20 01 24 01 30 01")),
                              make_frame(bench, Command::nop), make_frame(bench, ListIdentity)};
    cip::Bytes octets;
    for (const auto& each : requests) each.write(octets);
    if (!session.wire().send(octets, "four messages in one piece: ListServices, SendRRData, NOP, ListIdentity")) return;
    std::size_t answered = 0;
    for (int i = 0; i < 3; ++i) {
        const auto reply = session.wire().receive();
        if (!bench.require(reply.has_value(), fmt::format("{} of 3 answers came", answered))) return;
        const auto fits = [&](const Frame& each) {
            return each.context == reply->context && each.command == reply->command;
        };
        if (std::ranges::any_of(requests, fits)) ++answered;
    }
    bench.require(answered == 3, "an answer belongs to none of the requests");
}

void pipelined(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    constexpr std::size_t outstanding = 8;
    std::vector<Frame> waiting;
    for (std::size_t i = 0; i < outstanding; ++i) {
        // Seven attributes, so that a reply that is put to the wrong request shows.
        const auto attribute = static_cast<std::uint8_t>(1 + i % 7);
        waiting.push_back(session.rr_frame(join({hex("0E 03 20 01 24 01 30"), std::array{attribute}})));
        if (!session.wire().send(waiting.back())) return;
    }
    for (std::size_t i = 0; i < outstanding; ++i) {
        const auto reply = session.wire().receive();
        if (!bench.require(reply.has_value(), fmt::format("{} of {} requests are answered", i, outstanding))) return;
        const auto found = std::ranges::find(waiting, reply->context, &Frame::context);
        if (!bench.require(found != waiting.end(), "an answer belongs to no request, or came twice")) return;
        waiting.erase(found);
    }
}

void udp_refuses(Bench& bench, const Frame& request) {
    if (bench.subject().address.address == 0) return bench.skip("the device is not reached over IPv4");
    Udp udp(bench);
    const auto marker = make_frame(bench, ListServices);
    udp.send(request.encode());
    udp.send(marker.encode());
    for (int i = 0; i < 2; ++i) {
        const auto came = udp.receive(bench.timeout());
        if (!bench.require(came.has_value(), "no answer to an ordinary datagram behind it")) return;
        const auto frame = Frame::parse(*came);
        if (!bench.require(frame.has_value(), "a datagram that is no message")) return;
        if (frame->context == marker.context) {
            bench.advise(i > 0, "it is not answered at all");
            return;
        }
        if (bench.require(frame->context == request.context, "an answer to nothing that was asked")) {
            refused(bench, std::optional(*frame), {0x0001}, {}, Weight::any);
        }
    }
}

void udp_silent(Bench& bench, cip::Bytes octets, std::string_view what, bool firm = true) {
    if (bench.subject().address.address == 0) return bench.skip("the device is not reached over IPv4");
    Udp udp(bench);
    udp.expect_silence(octets, what, firm);
}

void udp_cut(Bench& bench) {
    auto octets = make_frame(bench, Command::list_identity, cip::Bytes(8)).encode();
    octets.resize(octets.size() - 4);
    udp_silent(bench, octets, "a datagram that is shorter than it says");
}

constexpr std::uint8_t asked_delay_low = 0xF4;  // 500 ms
constexpr std::uint8_t asked_delay_high = 0x01;
constexpr milliseconds longest_delay{500};

Frame delayed_request(Bench& bench) {
    auto request = make_frame(bench, ListIdentity);
    request.context = {asked_delay_low, asked_delay_high, 0xAA, 0x55, 0x01, 0x02, 0x03, 0x04};
    return request;
}

void broadcast(Bench& bench) {
    if (bench.subject().address.address == 0) return bench.skip("the device is not reached over IPv4");
    Udp udp(bench);
    const auto request = delayed_request(bench);
    const auto begin = std::chrono::steady_clock::now();
    if (!udp.broadcast(request.encode())) return bench.skip("there is no way for broadcasts");
    const auto came = udp.receive(longest_delay + bench.timeout());
    const auto took = std::chrono::duration_cast<milliseconds>(std::chrono::steady_clock::now() - begin);
    if (!came) {
        bench.advise(false, "a broadcast is not answered; is there a router in between?");
        return;
    }
    const auto reply = Frame::parse(*came);
    if (!bench.require(reply.has_value(), "the answer is no message")) return;
    bench.require(reply->context == request.context,
                  "the sender context, which holds the longest delay, comes back changed");
    bench.require(enip::asio::read_identity_reply(*reply).has_value(), "the answer is no identity");
    // A busy machine or network is no fault of the device.
    bench.advise(
        took <= longest_delay + milliseconds(200),
        fmt::format("the answer came after {} ms; 500 ms are the longest delay that was asked for", took.count()));
}

void broadcast_does_not_block(Bench& bench) {
    if (bench.subject().address.address == 0) return bench.skip("the device is not reached over IPv4");
    Udp udp(bench);
    if (!udp.broadcast(delayed_request(bench).encode())) return bench.skip("there is no way for broadcasts");
    Wire wire(bench);
    if (!wire.is_open()) return;
    const auto reply = wire.exchange(make_frame(bench, ListIdentity));
    if (reply) bench.require(reply->status == EncapsulationStatus::success, "status " + enip::describe(reply->status));
}

void two_connections(Bench& bench) {
    Session first(bench);
    Session second(bench);
    if (!first.is_open() || !second.is_open()) return;
    granted(bench, second.call(hex("0E 03 20 01 24 01 30 01")));
    granted(bench, first.call(hex("0E 03 20 01 24 01 30 01")));
}

constexpr auto E = Group::encapsulation;
constexpr auto R = Manner::reads;

// clang-format off
constexpr std::array cases{
    Case{"ENC-01", E, "ListServices tells of CIP over TCP", "R-ENC-12", "The reply has one item 0x0100 of 20 octets: version 1, capability flags, name.", R,
         list_services},
    Case{"ENC-02", E, "ListServices is the same over UDP", "R-ENC-12", "The same data comes over UDP.", R,
         [](Bench& b) { same_over_both(b, ListServices); }},
    Case{"ENC-03", E, "ListIdentity needs no session", "R-ENC-13", "The reply has one identity item; a session is not needed.", R,
         identity_item_shape},
    Case{"ENC-04", E, "ListIdentity is the same over UDP", "R-ENC-13", "The identity does not depend on the way.", R,
         list_identity_over_udp},
    Case{"ENC-05", E, "The identity item has the socket address", "R-CPF-5", "Family 2, port and address in big-endian order, eight zero octets.", R,
         identity_socket_address},
    Case{"ENC-06", E, "ListInterfaces is answered over TCP", "R-ENC-16", "A device without other interfaces answers with no items.", R,
         [](Bench& b) { list_interfaces(b, over_tcp(b, ListInterfaces)); }},
    Case{"ENC-07", E, "ListInterfaces is answered over UDP", "R-ENC-16", "A device without other interfaces answers with no items.", R,
         [](Bench& b) { list_interfaces(b, over_udp(b, ListInterfaces)); }},
    Case{"ENC-08", E, "The sender context comes back unchanged", "R-ENC-9", "A reply copies the eight octets of the sender context.", R,
         [](Bench& b) { context_is_echoed(b, ListServices); }},
    Case{"ENC-09", E, "ListIdentity brings the sender context back", "R-ENC-9", "A reply copies the eight octets of the sender context.", R,
         [](Bench& b) { context_is_echoed(b, ListIdentity); }},
    Case{"ENC-10", E, "SendRRData brings the sender context back", "R-ENC-9", "A reply copies session handle and sender context.", R,
         context_of_a_request},
    Case{"ENC-11", E, "The header of a reply is that of the request", "R-ENC-9", "Command and session handle as in the request, options 0, length of the data.", R,
         header_of_a_reply},
    Case{"ENC-12", E, "ListIdentity copies a session handle that is none", "R-ENC-13", "The session handle in the reply is that of the request.", R,
         handle_is_copied},
    Case{"ENC-13", E, "NOP is never answered", "R-ENC-10", "A NOP with any data is ignored.", R,
         [](Bench& b) { silent(b, make_frame(b, Command::nop, hex("01 02 03 04")), "a NOP"); }},
    Case{"ENC-14", E, "NOP without data is never answered", "R-ENC-10", "A NOP with any data is ignored.", R,
         [](Bench& b) { silent(b, make_frame(b, Command::nop), "a NOP"); }},
    Case{"ENC-15", E, "An unknown command is refused", "R-ENC-6", "Status 0x0001, no data.", R,
         [](Bench& b) { unknown_command(b, 0x0001, {}); }},
    Case{"ENC-16", E, "An unknown command's data is passed over", "R-ENC-6", "The data of an unknown command is skipped, and the next message is found.", R,
         [](Bench& b) { unknown_command(b, 0x1234, hex("63 00 00 00 FF FF FF FF 01 02 03")); }},
    Case{"ENC-17", E, "Command 0xFFFF is refused", "R-ENC-6", "Status 0x0001, no data.", R,
         [](Bench& b) { unknown_command(b, 0xFFFF, {}); }},
    Case{"ENC-18", E, "IndicateStatus is refused", "R-ENC-5", "The historic commands 0x0072 and 0x0073 are unknown.", R,
         [](Bench& b) { unknown_command(b, 0x0072, {}, Weight::soft); }},
    Case{"ENC-19", E, "Cancel is refused", "R-ENC-5", "The historic commands 0x0072 and 0x0073 are unknown.", R,
         [](Bench& b) { unknown_command(b, 0x0073, {}, Weight::soft); }},
    Case{"ENC-20", E, "A message with options is dropped", "R-ENC-7", "Options other than 0 are discarded without a reply.", R,
         [](Bench& b) { silent(b, with_options(make_frame(b, ListServices)), "a ListServices with options"); }},
    Case{"ENC-21", E, "A SendRRData with options is dropped", "R-ENC-7", "Options other than 0 are discarded without a reply.", R,
         options_in_a_request},
    Case{"ENC-22", E, "RegisterSession with options makes no session", "R-ENC-7", "Options other than 0 in a RegisterSession are answered 0x0069, or dropped.", R,
         options_in_register_session},
    Case{"ENC-23", E, "A message with a status is dropped", "R-ENC-8", "The status of a request is 0; any other is ignored.", R,
         status_in_a_request},
    Case{"ENC-24", E, "ListServices with data is refused", "R-ENC-11", "The List commands have no data; others are answered 0x0065.", R,
         [](Bench& b) { list_with_data(b, ListServices); }},
    Case{"ENC-25", E, "ListIdentity with data is refused", "R-ENC-11", "The List commands have no data; others are answered 0x0065.", R,
         [](Bench& b) { list_with_data(b, ListIdentity); }},
    Case{"ENC-26", E, "A message of 60000 octets is read to its end", "R-ENC-3", "What is too long is passed over and answered 0x0065; the place in the stream is kept.", R,
         [](Bench& b) { too_long(b, 60'000); }},
    Case{"ENC-27", E, "A message of the greatest length is read to its end", "R-ENC-3", "What is too long is passed over and answered 0x0065; the place in the stream is kept.", R,
         [](Bench& b) { too_long(b, enip::max_stated_length); }},
    Case{"ENC-28", E, "A message may come octet by octet", "R-ENC-3", "TCP is a stream: one message may sit in several segments.", R,
         octet_by_octet},
    Case{"ENC-29", E, "Messages may come in one piece", "R-ENC-3", "TCP is a stream: several messages may sit in one segment.", R,
         joined},
    Case{"ENC-30", E, "Eight requests may be outstanding", "R-ENC-22", "Several requests may be outstanding; each is answered once, with its context.", R,
         pipelined},
    Case{"ENC-31", E, "RegisterSession is refused over UDP", "R-ENC-5", "A command for TCP alone is answered 0x0001 over UDP, or not at all.", R,
         [](Bench& b) { udp_refuses(b, make_frame(b, Command::register_session, hex("01 00 00 00"))); }},
    Case{"ENC-32", E, "SendRRData is refused over UDP", "R-ENC-5", "A command for TCP alone is answered 0x0001 over UDP, or not at all.", R,
         [](Bench& b) { udp_refuses(b, make_frame(b, Command::send_rr_data, enip::SendData::unconnected(hex("0E 03 20 01 24 01 30 01")).encode(), 1)); }},
    Case{"ENC-33", E, "An unknown command is refused over UDP", "R-ENC-6", "Status 0x0001, no data.", R,
         [](Bench& b) { udp_refuses(b, make_frame(b, static_cast<Command>(0x1234))); }},
    Case{"ENC-34", E, "NOP is not answered over UDP", "R-ENC-5", "A NOP is never answered.", R,
         [](Bench& b) { udp_silent(b, make_frame(b, Command::nop).encode(), "a NOP over UDP"); }},
    Case{"ENC-35", E, "A datagram that is cut is dropped", "R-ENC-3", "A datagram that is shorter than header and length is dropped.", R,
         udp_cut},
    Case{"ENC-36", E, "A datagram with options is dropped", "R-ENC-7", "Options other than 0 are discarded without a reply.", R,
         [](Bench& b) { udp_silent(b, with_options(make_frame(b, ListIdentity)).encode(), "a ListIdentity with options over UDP", false); }},
    Case{"ENC-37", E, "A broadcast is answered within its delay", "R-ENC-14", "The reply comes after a random time of at most what the sender context says, to the sender alone.", R,
         broadcast},
    Case{"ENC-38", E, "A delayed reply does not hold up others", "R-ENC-15", "While a reply to a broadcast waits, everything else is answered.", R,
         broadcast_does_not_block},
    Case{"ENC-39", E, "Two connections are served side by side", "R-ENC-26", "At least two TCP connections are supported.", R,
         two_connections},
};
// clang-format on

}  // namespace

std::span<const Case> encapsulation_cases() { return cases; }

}  // namespace servobus::scanner::conformance
