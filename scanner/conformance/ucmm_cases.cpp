// Unconnected messages: services, paths, errors (R-MSG, R-PTH, R-ERR, R-CM-9).
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "cip/hex.hpp"
#include "cip/multiple_service.hpp"
#include "cip/services.hpp"
#include "cip/unconnected_send.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"

namespace servobus::scanner::conformance {
namespace {

namespace service = cip::service;

constexpr auto vendor_request = "0E 03 20 01 24 01 30 01";
constexpr auto type_request = "0E 03 20 01 24 01 30 02";
constexpr auto name_request = "0E 03 20 01 24 01 30 07";
constexpr auto unknown_class_request = "0E 03 20 C7 24 01 30 01";

std::optional<Reply> ask(Bench& bench, const cip::Bytes& message) {
    Session session(bench);
    return session.is_open() ? session.call(message) : std::nullopt;
}
std::optional<Reply> ask(Bench& bench, std::string_view message) { return ask(bench, hex(message)); }

void expect(Bench& bench, std::string_view message, std::initializer_list<Code> right,
            std::initializer_list<Code> tolerated = {}, Weight weight = Weight::exact) {
    const auto reply = ask(bench, message);
    refused(bench, reply, right, tolerated, weight);
    if (reply && !reply->ok()) {
        bench.advise(reply->response.data.empty(),
                     fmt::format("{} octets of data came with the refusal", reply->response.data.size()));
    }
}

/// Two requests that mean the same. The second may be refused with `tolerated`, which not everybody takes amiss.
void same(Bench& bench, std::string_view first, std::string_view second, std::initializer_list<Code> tolerated = {}) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto plain = session.call(hex(first));
    const auto other = session.call(hex(second));
    if (!granted(bench, plain) || !other) return;
    const auto& status = other->response.status;
    if (!status.ok() && std::ranges::any_of(tolerated, [&](const Code& each) { return each.matches(status); })) {
        bench.advise(false, fmt::format("this form is refused with {}", cip::describe(status)));
        return;
    }
    if (granted(bench, other))
        bench.require(plain->message == other->message, "both forms mean the same, and are answered differently");
}

void reply_form(Bench& bench) {
    const auto reply = ask(bench, vendor_request);
    if (!granted(bench, reply)) return;
    const auto& message = reply->message;
    bench.require(message[0] == (service::get_attribute_single | service::reply_bit),
                  fmt::format("the service octet is 0x{:02X} and not 0x8E", message[0]));
    bench.advise(message[1] == 0, fmt::format("the reserved octet is 0x{:02X} and not 0", message[1]));
    bench.require(message[3] == 0, fmt::format("{} words of additional status with success", message[3]));
    constexpr std::size_t whole = 6;
    bench.require(message.size() == whole,
                  fmt::format("{} octets and not 6: a UINT has no type and no length in front", message.size()));
}

void surplus_data(Bench& bench) {
    const auto reply = ask(bench, "0E 03 20 01 24 01 30 01 FF FF");
    if (!reply || reply->ok()) return;
    refused(bench, reply, {0x15}, {}, Weight::any);
}

void all_is_the_parts(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto all = session.call(hex("01 02 20 01 24 01"));
    if (is_unsupported(all))
        return bench.require(false, "Identity does not offer Get_Attributes_All, which the object requires"), void();
    if (!granted(bench, all)) return;
    cip::Bytes parts;
    for (std::uint8_t id = 1; id <= 7; ++id) {
        const auto one = session.call(join({hex("0E 03 20 01 24 01 30"), std::array{id}}));
        if (!granted(bench, one)) return;
        parts.insert(parts.end(), one->response.data.begin(), one->response.data.end());
    }
    const auto& data = all->response.data;
    const bool begins = data.size() >= parts.size() && std::equal(parts.begin(), parts.end(), data.begin());
    bench.require(begins, fmt::format("Get_Attributes_All is not attributes 1 to 7 one after the other: {} and {}",
                                      cip::to_hex(data), cip::to_hex(parts)));
}

/// Get_Attribute_List of the Identity object with this data; skips where it is not offered.
std::optional<Reply> list(Bench& bench, std::string_view data) {
    auto reply = ask(bench, join({hex("03 02 20 01 24 01"), hex(data)}));
    if (is_unsupported(reply)) {
        bench.skip("Identity does not offer Get_Attribute_List");
        return std::nullopt;
    }
    return reply;
}

void list_form(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto vendor = session.call(hex(vendor_request));
    const auto type = session.call(hex(type_request));
    const auto reply = list(bench, "02 00 01 00 02 00");
    if (!granted(bench, vendor) || !granted(bench, type) || !reply || !granted(bench, reply)) return;
    const auto expected =
        join({hex("02 00 01 00 00 00"), vendor->response.data, hex("02 00 00 00"), type->response.data});
    bench.require(reply->response.data == expected,
                  fmt::format("{} came; expected is {}", cip::to_hex(reply->response.data), cip::to_hex(expected)));
}

void list_with_unknown(Bench& bench) {
    const auto reply = list(bench, "02 00 01 00 63 00");
    if (!reply) return;
    refused(bench, reply, {0x0A}, {}, Weight::any);
    const auto& data = reply->response.data;
    // Count, attribute 1 with status and value, attribute 99 with status.
    constexpr std::size_t whole = 12;
    if (!bench.require(data.size() == whole,
                       fmt::format("{} octets and not 12: both entries must be there", data.size())))
        return;
    cip::Reader reader(data);
    reader.take(8);
    bench.require(reader.u16() == 0x63, "the entry of attribute 99 is not in its place");
    const auto status = reader.u16();
    bench.require(status == 0x14, fmt::format("attribute 99 has status 0x{:02X} and not 0x14", status));
}

void list_refused(Bench& bench, std::string_view data, std::initializer_list<Code> right) {
    const auto reply = list(bench, data);
    if (reply) refused(bench, reply, right, {}, Weight::any);
}

cip::Bytes parts_request(const std::vector<cip::Bytes>& parts) {
    return join({hex("0A 02 20 02 24 01"), cip::write_parts(parts)});
}

/// Multiple_Service_Packet; skips where it is not offered.
std::optional<Reply> packet(Bench& bench, const cip::Bytes& message) {
    auto reply = ask(bench, message);
    if (is_unsupported(reply)) {
        bench.skip("the Message Router does not offer Multiple_Service_Packet");
        return std::nullopt;
    }
    return reply;
}

void packet_is_the_parts(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    std::vector<cip::Bytes> requests{hex(vendor_request), hex(name_request), hex(type_request)};
    std::vector<cip::Bytes> replies;
    for (const auto& each : requests) {
        const auto reply = session.call(each);
        if (!granted(bench, reply)) return;
        replies.push_back(reply->message);
    }
    const auto reply = packet(bench, parts_request(requests));
    if (!reply || !granted(bench, reply)) return;
    const auto expected = cip::write_parts(replies);
    bench.require(reply->response.data == expected,
                  fmt::format("{} came; expected is {}", cip::to_hex(reply->response.data), cip::to_hex(expected)));
}

void packet_with_refusal(Bench& bench) {
    const auto reply =
        packet(bench, parts_request({hex(vendor_request), hex(unknown_class_request), hex(type_request)}));
    if (!reply) return;
    refused(bench, reply, {0x1E});
    const auto parts = cip::read_parts(reply->response.data);
    if (!bench.require(parts && parts->size() == 3, "the reply does not have three parts")) return;
    constexpr std::array<std::uint8_t, 3> statuses{0x00, 0x05, 0x00};
    for (std::size_t i = 0; i < parts->size(); ++i) {
        const auto part = cip::Response::parse((*parts)[i]);
        if (!bench.require(part.has_value(), fmt::format("part {} is no reply", i + 1))) return;
        const auto status = static_cast<std::uint8_t>(part->status.general);
        bench.require(status == statuses[i],
                      fmt::format("part {} has status 0x{:02X} and not 0x{:02X}", i + 1, status, statuses[i]));
    }
}

void packet_in_packet(Bench& bench) {
    const auto inner = parts_request({hex(vendor_request)});
    const auto reply = packet(bench, parts_request({inner, hex(vendor_request)}));
    if (!reply) return;
    refused(bench, reply, {0x1E}, {}, Weight::soft);
}

void packet_refused(Bench& bench, std::string_view data) {
    const auto reply = packet(bench, join({hex("0A 02 20 02 24 01"), hex(data)}));
    if (reply) refused(bench, reply, {0x13}, {}, Weight::any);
}

cip::Bytes unconnected_send(std::string_view message, std::string_view route) {
    cip::UnconnectedSend send;
    send.message = hex(message);
    send.route_path = hex(route);
    return join({hex("52 02 20 06 24 01"), send.encode()});
}

/// Unconnected_Send; skips where it is not offered.
std::optional<Reply> routed(Bench& bench, const cip::Bytes& message) {
    auto reply = ask(bench, message);
    if (reply && reply->response.service == service::unconnected_send && is_unsupported(reply)) {
        bench.skip("the Connection Manager does not offer Unconnected_Send");
        return std::nullopt;
    }
    return reply;
}

void routed_to_itself(Bench& bench, std::string_view route) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto plain = session.call(hex(vendor_request));
    const auto reply = routed(bench, unconnected_send(vendor_request, route));
    if (!granted(bench, plain) || !reply) return;
    if (reply->response.service == service::unconnected_send) {
        bench.advise(false, fmt::format("refused with {}", cip::describe(reply->response.status)));
        return;
    }
    bench.require(reply->message == plain->message, "the reply is not the one of the request inside");
}

void routed_odd_message(Bench& bench) {
    const auto reply = routed(bench, unconnected_send("0E 03 20 C7 24 01 30 01 00", "01 00"));
    if (!reply) return;
    if (reply->response.service == service::unconnected_send) {
        refused(bench, reply, {{0x01, 0x0311}, {0x01, 0x0312}}, {}, Weight::any);
        return;
    }
    refused(bench, reply, {0x05});
}

void routed_refusal(Bench& bench) {
    const auto reply = routed(bench, unconnected_send(unknown_class_request, ""));
    if (!reply) return;
    bench.advise(reply->response.service == service::get_attribute_single,
                 "the refusal is not that of the request inside");
    refused(bench, reply, {0x05}, {}, Weight::any);
}

void routed_refused(Bench& bench, const cip::Bytes& message, std::initializer_list<Code> right,
                    std::initializer_list<Code> tolerated = {}) {
    const auto reply = routed(bench, message);
    if (!reply) return;
    refused(bench, reply, right, tolerated, Weight::any);
    bench.advise(reply->response.service == service::unconnected_send,
                 "the refusal is not that of the Unconnected_Send");
}

void routed_lengths(Bench& bench) {
    // The message has eight octets; the length says 200.
    routed_refused(bench, hex("52 02 20 06 24 01 0A 05 C8 00 0E 03 20 01 24 01 30 01 01 00 01 00"), {{0x01, 0x0205}},
                   {0x13, 0x15, 0x26, 0x04});
}

void long_request(Bench& bench) {
    // 504 octets in all, which every device reads.
    constexpr std::size_t message_octets = 504;
    auto message = hex(unknown_class_request);
    message.resize(message_octets, 0x5A);
    refused(bench, ask(bench, message), {0x05}, {}, Weight::any);
}

void answers_in_time(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    constexpr milliseconds in_time{1000};
    constexpr int times = 20;
    milliseconds longest{0};
    for (int i = 0; i < times; ++i) {
        const auto begin = std::chrono::steady_clock::now();
        if (!granted(bench, session.call(hex(name_request)))) return;
        longest = std::max(longest, std::chrono::duration_cast<milliseconds>(std::chrono::steady_clock::now() - begin));
    }
    bench.note(fmt::format("the slowest of {} answers took {} ms", times, longest.count()));
    bench.advise(longest <= in_time, fmt::format("an answer took {} ms", longest.count()));
}

void sees_the_same_twice(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto first = session.call(hex(name_request));
    const auto second = session.call(hex(name_request));
    if (granted(bench, first) && granted(bench, second))
        bench.require(first->message == second->message, "the product name changes from one read to the next");
}

constexpr auto U = Group::ucmm;
constexpr auto R = Manner::reads;
constexpr auto W = Manner::writes;

// clang-format off
constexpr std::array cases{
    Case{"UCM-01", U, "A reply has service, status and the bare value", "R-MSG-2", "Service with bit 7, a reserved 0, general status, words of additional status, data; a value has no type and no length in front.", R, reply_form},
    Case{"UCM-02", U, "Reading twice gives the same", "R-MSG-10", "Get_Attribute_Single answers the value.", R, sees_the_same_twice},
    Case{"UCM-03", U, "A class of 16 bits means the same", "R-PTH-3", "A class, instance or attribute may have 8 or 16 bits.", R,
         [](Bench& b) { same(b, vendor_request, "0E 04 21 00 01 00 24 01 30 01"); }},
    Case{"UCM-04", U, "An instance of 16 bits means the same", "R-PTH-3", "A class, instance or attribute may have 8 or 16 bits.", R,
         [](Bench& b) { same(b, vendor_request, "0E 04 20 01 25 00 01 00 30 01"); }},
    Case{"UCM-05", U, "An attribute of 16 bits means the same", "R-PTH-3", "A class, instance or attribute may have 8 or 16 bits.", R,
         [](Bench& b) { same(b, vendor_request, "0E 04 20 01 24 01 31 00 01 00"); }},
    Case{"UCM-06", U, "All of 16 bits means the same", "R-PTH-3", "A class, instance or attribute may have 8 or 16 bits.", R,
         [](Bench& b) { same(b, vendor_request, "0E 06 21 00 01 00 25 00 01 00 31 00 01 00"); }},
    Case{"UCM-07", U, "An instance of 32 bits means the same", "R-PTH-3", "An instance may have 32 bits; some stacks refuse that.", R,
         [](Bench& b) { same(b, vendor_request, "0E 05 20 01 26 00 01 00 00 00 30 01", {0x04, 0x05}); }},
    Case{"UCM-08", U, "The pad octet of a path does not matter", "R-PTH-3", "The octet between type and value is not checked.", R,
         [](Bench& b) { same(b, vendor_request, "0E 04 21 FF 01 00 24 01 30 01", {0x04}); }},
    Case{"UCM-09", U, "An instance in front of its class is refused", "R-PTH-10", "Class, instance, attribute in this order; otherwise 0x04.", R,
         [](Bench& b) { expect(b, "0E 03 24 01 20 01 30 01", {0x04}, {}, Weight::any); }},
    Case{"UCM-10", U, "An attribute in front of its class is refused", "R-PTH-10", "Class, instance, attribute in this order; otherwise 0x04.", R,
         [](Bench& b) { expect(b, "0E 03 30 01 20 01 24 01", {0x04}, {}, Weight::any); }},
    Case{"UCM-11", U, "A class that is there twice is refused", "R-PTH-10", "Each segment at most once; otherwise 0x04.", R,
         [](Bench& b) { expect(b, "0E 04 20 01 20 01 24 01 30 01", {0x04}, {}, Weight::soft); }},
    Case{"UCM-12", U, "An empty path leads nowhere", "R-PTH-10", "A path without segments is answered 0x05.", R,
         [](Bench& b) { expect(b, "0E 00", {0x05}, {0x04}, Weight::any); }},
    Case{"UCM-13", U, "A class alone has no attribute", "R-PTH-10", "A path with only a class is answered 0x05.", R,
         [](Bench& b) { expect(b, "0E 01 20 01", {0x05}, {0x14, 0x04}, Weight::any); }},
    Case{"UCM-14", U, "A class that is not there", "R-ERR-3", "Status 0x05.", R, [](Bench& b) { expect(b, unknown_class_request, {0x05}); }},
    Case{"UCM-15", U, "A class of 16 bits that is not there", "R-ERR-3", "Status 0x05, and not the class that has the same lower octet.", R,
         [](Bench& b) { expect(b, "0E 04 21 00 01 7F 24 01 30 01", {0x05}); }},
    Case{"UCM-16", U, "An instance that is not there", "R-ERR-3", "Status 0x05.", R, [](Bench& b) { expect(b, "0E 03 20 01 24 C8 30 01", {0x05}); }},
    Case{"UCM-17", U, "An instance of 16 bits that is not there", "R-ERR-3", "Status 0x05, and not the instance that has the same lower octet.", R,
         [](Bench& b) { expect(b, "0E 04 20 01 25 00 01 7F 30 01", {0x05}); }},
    Case{"UCM-18", U, "The instance is looked at before the service", "R-ERR-3", "An unknown instance is 0x05, even if the service is unknown too.", R,
         [](Bench& b) { expect(b, "4A 02 20 01 24 C8", {0x05}, {}, Weight::any); }},
    Case{"UCM-19", U, "An attribute that is not there", "R-ERR-5", "Status 0x14.", R, [](Bench& b) { expect(b, "0E 03 20 01 24 01 30 63", {0x14}); }},
    Case{"UCM-20", U, "An attribute of 16 bits that is not there", "R-ERR-5", "Status 0x14, and not the attribute that has the same lower octet.", R,
         [](Bench& b) { expect(b, "0E 04 20 01 24 01 31 00 01 7F", {0x14}); }},
    Case{"UCM-21", U, "An attribute that is missing in the path", "R-ERR-5", "Status 0x14.", R, [](Bench& b) { expect(b, "0E 02 20 01 24 01", {0x14}, {0x04, 0x05}, Weight::any); }},
    Case{"UCM-22", U, "A service that Identity does not offer", "R-ERR-4", "Status 0x08.", R, [](Bench& b) { expect(b, "4A 02 20 01 24 01", {0x08}); }},
    Case{"UCM-23", U, "A service that the class does not offer", "R-ERR-4", "Status 0x08.", R, [](Bench& b) { expect(b, "4A 02 20 01 24 00", {0x08}, {}, Weight::any); }},
    Case{"UCM-24", U, "A service that the Message Router does not offer", "R-ERR-4", "Status 0x08.", R, [](Bench& b) { expect(b, "4A 02 20 02 24 01", {0x08}); }},
    Case{"UCM-25", U, "A service that the Connection Manager does not offer", "R-ERR-4", "Status 0x08.", R, [](Bench& b) { expect(b, "4A 02 20 06 24 01", {0x08}); }},
    Case{"UCM-26", U, "Service 0 is none", "R-ERR-4", "Status 0x08.", R, [](Bench& b) { expect(b, "00 02 20 01 24 01", {0x08}, {}, Weight::any); }},
    Case{"UCM-27", U, "A service with the reply bit is none", "R-MSG-3", "A request has bit 7 clear; otherwise 0x08.", R,
         [](Bench& b) { expect(b, "8E 03 20 01 24 01 30 01", {0x08}, {}, Weight::any); }},
    Case{"UCM-28", U, "A path that is longer than the message", "R-ERR-1", "Status 0x26; some stacks say 0x04.", R,
         [](Bench& b) { expect(b, "0E 09 20 01 24 01 30 01", {0x26, 0x04}, {}, Weight::any); }},
    Case{"UCM-29", U, "A reserved segment", "R-ERR-2", "Status 0x04.", R, [](Bench& b) { expect(b, "0E 03 20 01 24 01 E0 01", {0x04}, {}, Weight::any); }},
    Case{"UCM-30", U, "A reserved logical format", "R-ERR-2", "Status 0x04.", R, [](Bench& b) { expect(b, "0E 03 23 01 24 01 30 01", {0x04}, {}, Weight::any); }},
    Case{"UCM-31", U, "A symbol that nobody knows", "R-PTH-9", "Status 0x04.", R, [](Bench& b) { expect(b, "0E 04 91 05 4E 6F 6E 65 21 00", {0x04}, {0x05}, Weight::any); }},
    Case{"UCM-32", U, "A segment that is cut off", "R-ERR-2", "Status 0x04.", R, [](Bench& b) { expect(b, "0E 03 20 01 24 01 31 00", {0x04}, {0x26, 0x05}, Weight::any); }},
    Case{"UCM-33", U, "Data behind a Get_Attribute_Single", "R-MSG-10", "It is passed over, or answered 0x15.", R, surplus_data},
    Case{"UCM-34", U, "Get_Attributes_All is the attributes one after the other", "R-MSG-12", "The values in the object's order, without gaps.", R, all_is_the_parts},
    Case{"UCM-35", U, "Get_Attribute_List answers id, status and value", "R-MSG-14", "Count, and for each attribute id, status, value.", R, list_form},
    Case{"UCM-36", U, "An attribute that is not there in a list", "R-MSG-14", "General status 0x0A, and all entries are there.", R, list_with_unknown},
    Case{"UCM-37", U, "A list of more attributes than there are", "R-MSG-14", "Status 0x13.", R, [](Bench& b) { list_refused(b, "05 00 01 00 02 00", {0x13}); }},
    Case{"UCM-38", U, "A list with data behind it", "R-MSG-14", "Status 0x15.", R, [](Bench& b) { list_refused(b, "01 00 01 00 02 00", {0x15}); }},
    Case{"UCM-39", U, "A list without a count", "R-MSG-14", "Status 0x13.", R, [](Bench& b) { list_refused(b, "", {0x13}); }},
    Case{"UCM-40", U, "Multiple_Service_Packet is its parts", "R-MSG-16", "The reply has the replies of the parts, in their order.", R, packet_is_the_parts},
    Case{"UCM-41", U, "A part that is refused", "R-MSG-16", "General status 0x1E; each part has its own status.", R, packet_with_refusal},
    Case{"UCM-42", U, "A packet in a packet", "R-MSG-16", "The inner one is refused.", R, packet_in_packet},
    Case{"UCM-43", U, "An offset behind the data", "R-MSG-16", "Status 0x13.", R, [](Bench& b) { packet_refused(b, "01 00 C8 00 0E 03 20 01 24 01 30 01"); }},
    Case{"UCM-44", U, "An offset into the head", "R-MSG-16", "Status 0x13.", R, [](Bench& b) { packet_refused(b, "01 00 01 00 0E 03 20 01 24 01 30 01"); }},
    Case{"UCM-45", U, "More parts than offsets", "R-MSG-16", "Status 0x13.", R, [](Bench& b) { packet_refused(b, "40 00 04 00 0E 03 20 01 24 01 30 01"); }},
    Case{"UCM-46", U, "Unconnected_Send without a route", "R-CM-9", "The device itself is meant; the reply is that of the request inside.", R, [](Bench& b) { routed_to_itself(b, ""); }},
    Case{"UCM-47", U, "Unconnected_Send to port 1, address 0", "R-CM-9", "The device itself is meant; the reply is that of the request inside.", R, [](Bench& b) { routed_to_itself(b, "01 00"); }},
    Case{"UCM-48", U, "A message of odd length in an Unconnected_Send", "R-CM-9", "A pad octet follows a message of odd length.", R, routed_odd_message},
    Case{"UCM-49", U, "A refusal inside an Unconnected_Send", "R-CM-9", "The service that is refused is the one inside.", R, routed_refusal},
    Case{"UCM-50", U, "A route through a port that is not there", "R-CM-10", "Service 0xD2, status 0x01, extended status 0x0311.", R,
         [](Bench& b) { routed_refused(b, unconnected_send(vendor_request, "0D 03"), {{0x01, 0x0311}}, {{0x01, 0x0312}, {0x01, 0x0204}}); }},
    Case{"UCM-51", U, "A route to an address where nobody is", "R-CM-10", "Service 0xD2, status 0x01, extended status 0x0312.", R,
         [](Bench& b) { routed_refused(b, unconnected_send(vendor_request, "01 63"), {{0x01, 0x0312}}, {{0x01, 0x0311}, {0x01, 0x0204}}); }},
    Case{"UCM-52", U, "A route that is no route", "R-CM-10", "Status 0x04.", R,
         [](Bench& b) { routed_refused(b, unconnected_send(vendor_request, "20 01"), {0x04}, {{0x01, 0x0315}, {0x01, 0x0311}}); }},
    Case{"UCM-53", U, "A length that is longer than the message inside", "R-CM-10", "Status 0x01, extended status 0x0205.", R, routed_lengths},
    Case{"UCM-54", U, "A request of 504 octets is read", "R-ENC-27", "Every device takes 504 octets.", R, long_request},
    Case{"UCM-55", U, "Answers come within a second", "R-MSG-18", "An unconnected request is answered within one second.", R, answers_in_time},
    Case{"UCM-56", U, "The vendor id cannot be written", "R-ERR-6", "Status 0x0E, or 0x08 where nothing can be written.", W,
         [](Bench& b) { expect(b, "10 03 20 01 24 01 30 01 FF FF", {0x0E, 0x08}); }},
    Case{"UCM-57", U, "An attribute that is not there cannot be written", "R-ERR-5", "Status 0x14, or 0x08 where nothing can be written.", W,
         [](Bench& b) { expect(b, "10 03 20 01 24 01 30 63 00", {0x14, 0x08}, {0x0E}, Weight::any); }},
    Case{"UCM-58", U, "A class cannot be written", "R-OBJ-1", "Instance 0 is read only: 0x08, or 0x0E.", W,
         [](Bench& b) { expect(b, "10 03 20 01 24 00 30 01 02 00", {0x08, 0x0E}, {0x14}, Weight::any); }},
    Case{"UCM-59", U, "Reset knows types 0 to 2", "R-ID-8", "Any other type is answered 0x20, and nothing happens.", W,
         [](Bench& b) { expect(b, "05 02 20 01 24 01 63", {0x20}, {0x09, 0x08}, Weight::any); }},
    Case{"UCM-60", U, "Reset has one octet of data at most", "R-ID-8", "Status 0x15, and nothing happens.", W,
         [](Bench& b) { expect(b, "05 02 20 01 24 01 63 00 00", {0x15}, {0x20, 0x09, 0x08}, Weight::any); }},
};
// clang-format on

}  // namespace

std::span<const Case> ucmm_cases() { return cases; }

}  // namespace servobus::scanner::conformance
