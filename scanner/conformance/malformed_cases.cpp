// What is no message, or lies about its lengths (R-ENC-3, R-CPF-2, R-MSG-3, R-ERR-1). Whether it is refused, dropped or
// ends its connection is the device's to choose; that the device lives on is not.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <random>
#include <thread>

#include "cip/multiple_service.hpp"
#include "cip/unconnected_send.hpp"
#include "enip/messages.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"
#include "scanner/conformance/class3_link.hpp"
#include "scanner/conformance/io_link.hpp"

namespace servobus::scanner::conformance {
namespace {

using enip::Command;

constexpr auto vendor_request = "0E 03 20 01 24 01 30 01";
/// For an answer to what need not be answered.
constexpr milliseconds grace{300};

/// After each of these cases: a new connection, a session, an ordinary request.
void lives(Bench& bench) {
    Session session(bench);
    if (bench.require(session.is_open(), "afterwards the device takes no session"))
        granted(bench, session.call(hex(vendor_request)));
}

/// Passes over what comes until an ordinary request is answered, the connection ends, or nothing comes for a while.
void settle(Wire& wire) {
    const auto marker = make_frame(wire.bench(), Command::list_services);
    if (!wire.send(marker)) return;
    constexpr int most = 400;
    for (int i = 0; i < most; ++i) {
        const auto frame = wire.receive(grace);
        if (!frame || frame->context == marker.context) return;
    }
}

/// Octets on a connection with a session.
void octets(Bench& bench, const cip::Bytes& bytes, std::string words = {}) {
    {
        Session session(bench);
        if (!session.is_open()) return;
        session.wire().send(bytes, std::move(words));
        settle(session.wire());
    }
    lives(bench);
}

/// The data of a SendRRData.
void data(Bench& bench, const cip::Bytes& bytes, Command command = Command::send_rr_data) {
    {
        Session session(bench);
        if (!session.is_open()) return;
        session.wire().send(make_frame(bench, command, bytes, session.handle()));
        settle(session.wire());
    }
    lives(bench);
}

/// A message of the message router that must not be granted.
void message(Bench& bench, const cip::Bytes& bytes) {
    {
        Session session(bench);
        if (!session.is_open()) return;
        const auto request = session.rr_frame(bytes);
        const auto marker = make_frame(bench, Command::list_services);
        if (!session.wire().send(request)) return;
        const auto frame = session.wire().receive(bench.timeout());
        if (frame && frame->context == request.context && frame->status == enip::EncapsulationStatus::success) {
            const auto reply = session.read(*frame, bytes.empty() ? std::uint8_t{0} : bytes[0]);
            if (reply) bench.require(!reply->ok(), "it was granted");
        }
        if (!frame && session.wire().is_open()) bench.advise(false, "there is no answer, and the connection stays");
        settle(session.wire());
    }
    lives(bench);
}
void message(Bench& bench, std::string_view text) { message(bench, hex(text)); }

/// A path behind Get_Attribute_Single, with the size that it has, in words.
void path(Bench& bench, std::string_view text) {
    const auto octets_of_path = hex(text);
    message(bench,
            join({hex("0E"), std::array{static_cast<std::uint8_t>((octets_of_path.size() + 1) / 2)}, octets_of_path}));
}

/// Something that must be answered by a reply that fits, or refused as too large.
void too_much(Bench& bench, const cip::Bytes& request) {
    {
        Session session(bench);
        if (!session.is_open()) return;
        const auto frame = session.rr_frame(request);
        if (!session.wire().send(frame)) return;
        const auto reply = session.wire().receive(bench.timeout());
        if (reply) bench.require(reply->context == frame.context, "an answer to nothing that was asked");
        settle(session.wire());
    }
    lives(bench);
}

void overrun_by_packet(Bench& bench) {
    constexpr std::size_t many = 120;
    const std::vector<cip::Bytes> parts(many, hex("01 02 20 01 24 01"));
    too_much(bench, join({hex("0A 02 20 02 24 01"), cip::write_parts(parts)}));
}

void overrun_by_list(Bench& bench) {
    constexpr std::uint16_t many = 200;
    auto request = join({hex("03 02 20 01 24 01"), u16(many)});
    for (int i = 0; i < many; ++i) {
        request.push_back(7);
        request.push_back(0);
    }
    too_much(bench, request);
}

void nested_sends(Bench& bench) {
    auto inner = hex(vendor_request);
    constexpr int deep = 30;
    for (int i = 0; i < deep; ++i) {
        cip::UnconnectedSend send;
        send.message = inner;
        send.route_path = hex("01 00");
        inner = join({hex("52 02 20 06 24 01"), send.encode()});
    }
    too_much(bench, inner);
}

void nested_packets(Bench& bench) {
    auto inner = hex(vendor_request);
    constexpr int deep = 30;
    for (int i = 0; i < deep; ++i)
        inner = join({hex("0A 02 20 02 24 01"), cip::write_parts(std::vector<cip::Bytes>{inner})});
    too_much(bench, inner);
}

/// The beginning of a message on a connection that then says nothing.
void half(Bench& bench, const cip::Bytes& beginning, std::size_t connections) {
    std::vector<std::unique_ptr<Wire>> wires;
    for (std::size_t i = 0; i < connections; ++i) {
        wires.push_back(std::make_unique<Wire>(bench));
        if (!wires.back()->is_open()) return;
        wires.back()->send(beginning, fmt::format("the first {} octets of a message", beginning.size()));
    }
    lives(bench);
    for (auto& each : wires) each->reset();
    lives(bench);
}

cip::Bytes beginning_of_a_request(Bench& bench, std::size_t octets_sent) {
    auto all = make_frame(bench, Command::register_session, hex("01 00 00 00")).encode();
    all.resize(octets_sent);
    return all;
}

void many_connections(Bench& bench) {
    constexpr std::size_t many = 40;
    std::vector<std::unique_ptr<Wire>> wires;
    {
        // A device may refuse what is above its limit.
        Bench quiet(bench.subject(), bench.which());
        for (std::size_t i = 0; i < many; ++i) {
            auto wire = std::make_unique<Wire>(quiet);
            if (!wire->is_open()) break;
            wires.push_back(std::move(wire));
        }
        bench.note(fmt::format("{} TCP connections at once", wires.size()));
        for (auto& each : wires) each->reset();
        wires.clear();
    }
    lives(bench);
}

/// Messages at once, of which each must be answered.
void flood(Bench& bench, Command command, const cip::Bytes& body, bool answered) {
    {
        Session session(bench);
        if (!session.is_open()) return;
        constexpr int many = 200;
        cip::Bytes all;
        std::vector<enip::SenderContext> waiting;
        for (int i = 0; i < many; ++i) {
            const auto frame = make_frame(bench, command, body, session.handle());
            frame.write(all);
            waiting.push_back(frame.context);
        }
        if (!session.wire().send(all, fmt::format("{} {} at once", many, enip::describe(command)))) return;
        for (int i = 0; answered && i < many; ++i) {
            const auto reply = session.wire().receive();
            if (!bench.require(reply.has_value(), fmt::format("{} of {} messages are answered", i, many))) break;
            const auto found = std::ranges::find(waiting, reply->context);
            if (!bench.require(found != waiting.end(), "an answer belongs to no message, or came twice")) break;
            waiting.erase(found);
        }
        if (session.wire().is_open())
            bench.require(session.wire().is_alive(), "the connection does not answer any more");
    }
    lives(bench);
}

void resets(Bench& bench) {
    constexpr int many = 50;
    for (int i = 0; i < many; ++i) {
        Wire wire(bench);
        if (!wire.is_open()) return;
        wire.send(make_frame(bench, Command::register_session, hex("01 00 00 00")));
        wire.reset();
    }
    lives(bench);
}

void does_not_read(Bench& bench) {
    {
        Session session(bench);
        if (!session.is_open()) return;
        constexpr int many = 200;
        const auto request = hex("01 02 20 01 24 01");
        cip::Bytes all;
        for (int i = 0; i < many; ++i) session.rr_frame(request).write(all);
        session.wire().send(all, fmt::format("{} requests, whose answers are not read", many));
        lives(bench);
        session.wire().reset();
    }
    lives(bench);
}

void handle_of_another(Bench& bench) {
    {
        Session first(bench);
        Session second(bench);
        if (!first.is_open() || !second.is_open()) return;
        for (std::uint32_t i = 0; i < 20; ++i) {
            auto request = second.unit_frame(0x10000 + i, static_cast<std::uint16_t>(i), hex(vendor_request));
            request.session = first.handle() + i;
            second.wire().send(request);
        }
        settle(second.wire());
        granted(bench, first.call(hex(vendor_request)));
    }
    lives(bench);
}

/// Ordinary reads with some octets changed, the same ones each time. The service stays, so that nothing is written, reset
/// or opened by accident.
void changed_at_random(Bench& bench) {
    constexpr int many = 200;
    std::mt19937 random(20261126);  // NOLINT(cert-msc51-cpp): the same each time
    const std::array<cip::Bytes, 5> requests{hex(vendor_request), hex("01 02 20 01 24 01"),
                                             hex("03 02 20 01 24 01 02 00 01 00 02 00"), hex("0E 03 20 F5 24 01 30 05"),
                                             hex("0E 06 21 00 01 00 25 00 01 00 31 00 01 00")};
    auto session = std::make_unique<Session>(bench);
    for (int i = 0; i < many; ++i) {
        if (!session->wire().is_open()) session = std::make_unique<Session>(bench);
        if (!session->is_open()) return;
        auto bytes = requests[random() % requests.size()];
        const auto changes = 1 + random() % 3;
        for (unsigned change = 0; change < changes; ++change) {
            bytes[1 + random() % (bytes.size() - 1)] = static_cast<std::uint8_t>(random());
        }
        if (random() % 4 == 0) bytes.resize(1 + random() % bytes.size());
        session->wire().send(session->rr_frame(bytes));
        if (i % 10 == 9) settle(session->wire());
    }
    settle(session->wire());
    session.reset();
    lives(bench);
}

void udp(Bench& bench, const std::vector<cip::Bytes>& datagrams) {
    if (bench.subject().address.address == 0) return bench.skip("the device is not reached over IPv4");
    {
        Udp socket(bench);
        for (const auto& each : datagrams) socket.send(each, fmt::format("a datagram of {} octets", each.size()));
        bench.require(socket.exchange(make_frame(bench, Command::list_services)).has_value(),
                      "afterwards nothing is answered over UDP");
    }
    lives(bench);
}

void io_port(Bench& bench, const std::vector<cip::Bytes>& datagrams) {
    if (bench.subject().address.address == 0) return bench.skip("the device is not reached over IPv4");
    {
        Udp socket(bench);
        for (const auto& each : datagrams) socket.send_io(each, fmt::format("to the I/O port: {} octets", each.size()));
    }
    lives(bench);
}

void io_to_a_connection(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    {
        IoLink link(session, usual_plan(*candidate, usual_rpi));
        if (!link.is_open() || !flows(link, bench)) return;
        Udp socket(bench);
        const auto id = u32(link.grant().reply.o_to_t_id);
        for (const auto* tail : {"", "00", "01 00 00 00 B1 00", "01 00 00 00 B1 00 FF FF", "01 00 00 00 B1 00 FF FF 00",
                                 "01 00 00 00 B1 00 00 00", "01 00 00 00 B1 00 01 00 00"}) {
            socket.send_io(join({hex("02 00 02 80 08 00"), id, hex(tail)}));
        }
        flows(link, bench);
    }
    lives(bench);
}

void connected(Bench& bench, const std::vector<cip::Bytes>& messages) {
    {
        Session session(bench);
        if (!session.is_open()) return;
        Class3Link link(session);
        if (!link.is_open()) return;
        for (const auto& each : messages) {
            session.wire().send(session.unit_frame(link.grant().o_to_t_id, link.next_sequence(), each));
            settle(session.wire());
            if (!session.wire().is_open()) link.forget();
        }
    }
    lives(bench);
}

cip::Bytes unit_items(std::string_view items) { return join({hex("00 00 00 00 00 00"), hex(items)}); }
cip::Bytes text_of(std::string_view text) { return {text.begin(), text.end()}; }
cip::Bytes filled(std::size_t count, std::uint8_t octet) { return cip::Bytes(count, octet); }

constexpr auto M = Group::malformed;
constexpr auto R = Manner::reads;
constexpr auto lives_words =
    "What is malformed is refused, dropped, or ends its connection; the device answers afterwards.";

// clang-format off
constexpr std::array cases{
    Case{"MAL-01", M, "A list of 65535 attributes of which one is there", "R-MSG-14", lives_words, R, [](Bench& b) { message(b, "03 02 20 01 24 01 FF FF 01 00"); }},
    Case{"MAL-02", M, "A list of one attribute of which half is there", "R-MSG-14", lives_words, R, [](Bench& b) { message(b, "03 02 20 01 24 01 01 00 01"); }},
    Case{"MAL-03", M, "65535 items", "R-CPF-2", lives_words, R, [](Bench& b) { data(b, hex("00 00 00 00 00 00 FF FF 00 00 00 00 B2 00 08 00 0E 03 20 01 24 01 30 01")); }},
    Case{"MAL-04", M, "An item of 65535 octets", "R-CPF-2", lives_words, R, [](Bench& b) { data(b, hex("00 00 00 00 00 00 02 00 00 00 00 00 B2 00 FF FF 0E 03 20 01 24 01 30 01")); }},
    Case{"MAL-05", M, "An address item of 65535 octets", "R-CPF-2", lives_words, R, [](Bench& b) { data(b, hex("00 00 00 00 00 00 02 00 00 00 FF FF B2 00 08 00 0E 03 20 01 24 01 30 01")); }},
    Case{"MAL-06", M, "Two data items and no address", "R-CPF-2", lives_words, R, [](Bench& b) { data(b, hex("00 00 00 00 00 00 02 00 B2 00 02 00 0E 00 B2 00 02 00 0E 00")); }},
    Case{"MAL-07", M, "A path size of 255 and no path", "R-ERR-1", lives_words, R, [](Bench& b) { message(b, "0E FF"); }},
    Case{"MAL-08", M, "A path of words behind the end", "R-ERR-1", lives_words, R, [](Bench& b) { message(b, "0E 7F 20 01 24 01 30 01"); }},
    Case{"MAL-09", M, "A class of 16 bits of which one octet is there", "R-PTH-3", lives_words, R, [](Bench& b) { path(b, "21 00"); }},
    Case{"MAL-10", M, "An instance of 32 bits of which half is there", "R-PTH-3", lives_words, R, [](Bench& b) { path(b, "20 01 26 00 01 00"); }},
    Case{"MAL-11", M, "An electronic key that is cut", "R-PTH-5", lives_words, R, [](Bench& b) { path(b, "34 04 6D 05"); }},
    Case{"MAL-12", M, "An electronic key of a format that is none", "R-PTH-5", lives_words, R, [](Bench& b) { path(b, "34 FF 6D 05 20 01 24 01 30 01"); }},
    Case{"MAL-13", M, "A data segment of 255 words that are not there", "R-PTH-8", lives_words, R, [](Bench& b) { path(b, "20 01 24 01 80 FF"); }},
    Case{"MAL-14", M, "A data segment of no words", "R-PTH-8", lives_words, R, [](Bench& b) { path(b, "20 01 24 01 80 00"); }},
    Case{"MAL-15", M, "A symbol of 255 characters that are not there", "R-PTH-9", lives_words, R, [](Bench& b) { path(b, "91 FF 41 42"); }},
    Case{"MAL-16", M, "A symbol of no characters", "R-PTH-9", lives_words, R, [](Bench& b) { path(b, "91 00"); }},
    Case{"MAL-17", M, "A port with a link address of 255 octets that are not there", "R-PTH-6", lives_words, R, [](Bench& b) { path(b, "12 FF 31 2E"); }},
    Case{"MAL-18", M, "An extended port without its number", "R-PTH-6", lives_words, R, [](Bench& b) { path(b, "0F 00"); }},
    Case{"MAL-19", M, "A network segment of 255 words that are not there", "R-PTH-7", lives_words, R, [](Bench& b) { path(b, "5F FF"); }},
    Case{"MAL-20", M, "Segments of all that is reserved", "R-PTH-1", lives_words, R, [](Bench& b) { path(b, "A0 A1 C1 C2 E0 FF 3C 3F 2F 2B"); }},
    Case{"MAL-21", M, "A path of 255 words of the same class", "R-PTH-10", lives_words, R, [](Bench& b) { cip::Bytes p; for (int i = 0; i < 255; ++i) { p.push_back(0x20); p.push_back(0x01); } message(b, join({hex("0E FF"), p})); }},
    Case{"MAL-22", M, "A Forward_Open of one octet", "R-CON-14", lives_words, R, [](Bench& b) { message(b, "54 02 20 06 24 01 0A"); }},
    Case{"MAL-23", M, "A Forward_Open of 35 octets of ones", "R-CON-14", lives_words, R, [](Bench& b) { message(b, join({hex("54 02 20 06 24 01"), filled(35, 0xFF)})); }},
    Case{"MAL-24", M, "A Forward_Open whose path is 255 words that are not there", "R-CON-14", lives_words, R, [](Bench& b) { message(b, join({hex("54 02 20 06 24 01"), filled(35, 0x00), hex("FF 20 04")})); }},
    Case{"MAL-25", M, "A Large_Forward_Open of 39 octets", "R-CON-14", lives_words, R, [](Bench& b) { message(b, join({hex("5B 02 20 06 24 01"), filled(39, 0xFF)})); }},
    Case{"MAL-26", M, "A Forward_Close whose path is 255 words that are not there", "R-CON-36", lives_words, R, [](Bench& b) { message(b, "4E 02 20 06 24 01 0A 0E 01 00 FF FF 01 02 03 04 FF 00 20 04"); }},
    Case{"MAL-27", M, "An Unconnected_Send of a message of 65535 octets that are not there", "R-CM-10", lives_words, R, [](Bench& b) { message(b, "52 02 20 06 24 01 0A 05 FF FF 0E 03 20 01 24 01 30 01 01 00 01 00"); }},
    Case{"MAL-28", M, "An Unconnected_Send whose route is 255 words that are not there", "R-CM-10", lives_words, R, [](Bench& b) { message(b, "52 02 20 06 24 01 0A 05 08 00 0E 03 20 01 24 01 30 01 FF 00 01 00"); }},
    Case{"MAL-29", M, "An Unconnected_Send of no message", "R-CM-10", lives_words, R, [](Bench& b) { message(b, "52 02 20 06 24 01 0A 05 00 00 01 00 01 00"); }},
    Case{"MAL-30", M, "Thirty Unconnected_Sends inside each other", "R-CM-9", lives_words, R, nested_sends},
    Case{"MAL-31", M, "Thirty packets inside each other", "R-MSG-16", lives_words, R, nested_packets},
    Case{"MAL-32", M, "A packet of 65535 parts", "R-MSG-16", lives_words, R, [](Bench& b) { message(b, "0A 02 20 02 24 01 FF FF 04 00 0E 03 20 01 24 01 30 01"); }},
    Case{"MAL-33", M, "A packet whose offsets go backwards", "R-MSG-16", lives_words, R, [](Bench& b) { message(b, "0A 02 20 02 24 01 02 00 0E 00 06 00 0E 03 20 01 24 01 30 01 0E 03 20 01 24 01 30 01"); }},
    Case{"MAL-34", M, "A packet whose offsets are all the same", "R-MSG-16", lives_words, R, [](Bench& b) { too_much(b, hex("0A 02 20 02 24 01 03 00 08 00 08 00 08 00 0E 03 20 01 24 01 30 01")); }},
    Case{"MAL-35", M, "A packet whose offset is 65535", "R-MSG-16", lives_words, R, [](Bench& b) { message(b, "0A 02 20 02 24 01 01 00 FF FF 0E 03 20 01 24 01 30 01"); }},
    Case{"MAL-36", M, "A packet that asks for more than fits", "R-ENC-27", "A reply that does not fit is answered 0x11, for a part or for the whole.", R, overrun_by_packet},
    Case{"MAL-37", M, "A list that asks for more than fits", "R-ENC-27", "A reply that does not fit is answered 0x11.", R, overrun_by_list},
    Case{"MAL-38", M, "A request of 4000 octets", "R-ENC-27", lives_words, R, [](Bench& b) { too_much(b, join({hex(vendor_request), filled(4000, 0x41)})); }},
    Case{"MAL-39", M, "The session handles of others", "R-ENC-21", "Each is refused or dropped, and theirs go on.", R, handle_of_another},
    Case{"MAL-40", M, "A header that announces 65511 octets, and silence", "R-ENC-3", lives_words, R, [](Bench& b) { half(b, hex("6F 00 E7 FF 01 00 00 00 00 00 00 00 01 02 03 04 05 06 07 08 00 00 00 00"), 1); }},
    Case{"MAL-41", M, "A header that announces 65535 octets, and silence", "R-ENC-3", lives_words, R, [](Bench& b) { half(b, hex("6F 00 FF FF 01 00 00 00 00 00 00 00 01 02 03 04 05 06 07 08 00 00 00 00"), 1); }},
    Case{"MAL-42", M, "Half a header, and silence", "R-ENC-3", lives_words, R, [](Bench& b) { half(b, beginning_of_a_request(b, 12), 1); }},
    Case{"MAL-43", M, "A header without its data, and silence", "R-ENC-3", lives_words, R, [](Bench& b) { half(b, beginning_of_a_request(b, 24), 1); }},
    Case{"MAL-44", M, "Half a message on twelve connections at once", "R-ENC-3", lives_words, R, [](Bench& b) { half(b, beginning_of_a_request(b, 26), 12); }},
    Case{"MAL-45", M, "Forty connections at once", "R-ENC-26", lives_words, R, many_connections},
    Case{"MAL-46", M, "200 NOPs at once", "R-ENC-10", "None is answered, and the connection goes on.", R, [](Bench& b) { flood(b, Command::nop, {}, false); }},
    Case{"MAL-47", M, "200 ListServices at once", "R-ENC-3", "Each is answered once.", R, [](Bench& b) { flood(b, Command::list_services, {}, true); }},
    Case{"MAL-48", M, "200 unknown commands at once", "R-ENC-6", "Each is answered once.", R, [](Bench& b) { flood(b, static_cast<Command>(0x4321), hex("01 02"), true); }},
    Case{"MAL-49", M, "200 requests at once", "R-ENC-22", "Each is answered once.", R, [](Bench& b) { flood(b, Command::send_rr_data, enip::SendData::unconnected(hex(vendor_request)).encode(), true); }},
    Case{"MAL-50", M, "200 requests whose answers nobody reads", "R-ENC-22", lives_words, R, does_not_read},
    Case{"MAL-51", M, "Fifty connections that are reset", "R-ENC-25", lives_words, R, resets},
    Case{"MAL-52", M, "Fifty RegisterSessions at once", "R-ENC-19", lives_words, R, [](Bench& b) { cip::Bytes all; for (int i = 0; i < 50; ++i) make_frame(b, Command::register_session, hex("01 00 00 00")).write(all); octets(b, all, "50 RegisterSessions at once"); }},
    Case{"MAL-53", M, "1200 zeros", "R-ENC-3", lives_words, R, [](Bench& b) { octets(b, filled(1200, 0x00)); }},
    Case{"MAL-54", M, "1000 octets of ones", "R-ENC-3", lives_words, R, [](Bench& b) { octets(b, filled(1000, 0xFF)); }},
    Case{"MAL-55", M, "A request of the web", "R-ENC-3", lives_words, R, [](Bench& b) { octets(b, text_of("GET / HTTP/1.1\r\nHost: device\r\nUser-Agent: none\r\n\r\n"), "GET / HTTP/1.1"); }},
    Case{"MAL-56", M, "A TLS ClientHello", "R-ENC-3", lives_words, R, [](Bench& b) { octets(b, join({hex("16 03 01 00 C8 01 00 00 C4 03 03"), filled(190, 0x5A)}), "a TLS ClientHello"); }},
    Case{"MAL-57", M, "Datagrams that are too short", "R-ENC-3", lives_words, R, [](Bench& b) { udp(b, {{}, filled(1, 0x63), filled(23, 0x00), hex("63 00")}); }},
    Case{"MAL-58", M, "Datagrams that announce what is not there", "R-ENC-3", lives_words, R, [](Bench& b) { udp(b, {join({hex("63 00 FF FF"), filled(20, 0x00)}), join({hex("04 00 E7 FF"), filled(20, 0x00)}), join({hex("6F 00 10 00"), filled(24, 0x00)})}); }},
    Case{"MAL-59", M, "Datagrams of 1400 octets of nothing", "R-ENC-3", lives_words, R, [](Bench& b) { udp(b, {filled(1400, 0xFF), filled(1400, 0x00), filled(1400, 0x55)}); }},
    Case{"MAL-60", M, "Nonsense at the I/O port", "R-IO-7", lives_words, R, [](Bench& b) { io_port(b, {{}, filled(1, 0x02), hex("02 00 02 80 08 00"), hex("FF FF 02 80 08 00 01 02 03 04 05 06 07 08 B1 00 02 00 01 00"), hex("02 00 02 80 FF FF 01 02 03 04 05 06 07 08 B1 00 02 00 01 00"), filled(1400, 0xFF)}); }},
    Case{"MAL-61", M, "Nonsense for an open I/O connection", "R-IO-8", "It is dropped, and the connection goes on.", R, io_to_a_connection},
    Case{"MAL-62", M, "A connected item of no octets", "R-ENC-23", lives_words, R, [](Bench& b) { data(b, unit_items("02 00 A1 00 04 00 01 02 03 04 B1 00 00 00"), Command::send_unit_data); }},
    Case{"MAL-63", M, "A connected address of no octets", "R-ENC-23", lives_words, R, [](Bench& b) { data(b, unit_items("02 00 A1 00 00 00 B1 00 04 00 01 00 0E 00"), Command::send_unit_data); }},
    Case{"MAL-64", M, "Messages of no and of one octet over a connection", "R-MSG-3", lives_words, R, [](Bench& b) { connected(b, {{}, hex("0E"), hex("0E FF")}); }},
    Case{"MAL-65", M, "A message over a connection that is longer than it", "R-CON-47", lives_words, R, [](Bench& b) { connected(b, {join({hex(vendor_request), filled(1200, 0x41)})}); }},
    Case{"MAL-66", M, "A list of 65535 attributes over a connection", "R-MSG-14", lives_words, R, [](Bench& b) { connected(b, {hex("03 02 20 01 24 01 FF FF 01 00")}); }},
    Case{"MAL-67", M, "200 requests with octets changed at random", "R-MSG-3", lives_words, R, changed_at_random},
};
// clang-format on

}  // namespace

std::span<const Case> malformed_cases() { return cases; }

}  // namespace servobus::scanner::conformance
