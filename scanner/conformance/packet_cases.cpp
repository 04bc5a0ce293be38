// The common packet format (R-CPF, R-ENC-22).
#include <fmt/format.h>

#include <array>

#include "enip/messages.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"

namespace servobus::scanner::conformance {
namespace {

using enip::Command;
using enip::EncapsulationStatus;

// Interface handle 0, timeout 0.
constexpr auto head = "00 00 00 00 00 00";
constexpr auto null_item = "00 00 00 00";
// Get_Attribute_Single, Identity, vendor: in an unconnected data item, length included.
constexpr auto vendor_item = "B2 00 08 00 0E 03 20 01 24 01 30 01";

/// SendRRData with this data; afterwards the session must go on.
std::optional<enip::Frame> send_data(Session& session, const cip::Bytes& data) {
    return session.wire().exchange(make_frame(session.bench(), Command::send_rr_data, data, session.handle()));
}

void goes_on(Session& session) {
    auto& bench = session.bench();
    if (!session.wire().is_open()) {
        bench.require(false, "the device closed the connection");
        return;
    }
    granted(bench, session.call(hex("0E 03 20 01 24 01 30 01")));
}

cip::Bytes packet(std::string_view count, std::initializer_list<std::string_view> items) {
    auto data = join({hex(head), hex(count)});
    for (const auto item : items) {
        const auto octets = hex(item);
        data.insert(data.end(), octets.begin(), octets.end());
    }
    return data;
}

void malformed(Bench& bench, const cip::Bytes& data, Weight weight = Weight::exact) {
    Session session(bench);
    if (!session.is_open()) return;
    refused(bench, send_data(session, data), {0x0003}, {0x0065}, weight);
    goes_on(session);
}

/// The same, and a device that says nothing at all is only advised.
void malformed_or_silent(Bench& bench, const cip::Bytes& data, std::initializer_list<std::uint32_t> right) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto request = make_frame(bench, Command::send_rr_data, data, session.handle());
    const auto marker = make_frame(bench, Command::list_services);
    if (!session.wire().send(request) || !session.wire().send(marker)) return;
    const auto reply = session.wire().receive();
    if (!bench.require(reply.has_value(), "the connection does not answer any more")) return;
    if (reply->context == marker.context) {
        bench.advise(false, "it is not answered at all");
    } else {
        refused(bench, reply, right, {}, Weight::any);
        static_cast<void>(session.wire().answer_to(marker));
    }
    goes_on(session);
}

void answered(Bench& bench, const cip::Bytes& data) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto frame = send_data(session, data);
    if (!frame) return;
    constexpr std::uint8_t get_attribute_single = 0x0E;
    granted(bench, session.read(*frame, get_attribute_single));
}

void reply_items(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto frame = send_data(session, packet("02 00", {null_item, vendor_item}));
    if (!frame) return;
    const auto data = enip::SendData::parse(frame->data);
    if (!bench.require(data.has_value(), "the items of the reply cannot be read")) return;
    bench.require(data->interface_handle == 0, "the interface handle is not 0");
    bench.advise(data->timeout == 0, fmt::format("the timeout is {} and not 0", data->timeout));
    bench.require(data->packet.items.size() == 2, fmt::format("{} items and not 2", data->packet.items.size()));
    bench.require(enip::unconnected_message(*data).has_value(), "not a null address item and an unconnected data item");
}

void interface_handle(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    auto data = packet("02 00", {null_item, vendor_item});
    data[0] = 1;
    const auto reply = send_data(session, data);
    if (reply && reply->status != EncapsulationStatus::success) refused(bench, reply, {0x0003}, {}, Weight::any);
    if (reply && reply->status == EncapsulationStatus::success) {
        bench.advise(false, "the interface handle is not looked at");
    }
    goes_on(session);
}

void unit_data_with_unconnected_items(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto request =
        make_frame(bench, Command::send_unit_data, packet("02 00", {null_item, vendor_item}), session.handle());
    const auto marker = make_frame(bench, Command::list_services);
    if (!session.wire().send(request) || !session.wire().send(marker)) return;
    const auto reply = session.wire().receive();
    if (!bench.require(reply.has_value(), "the connection does not answer any more")) return;
    if (reply->context != marker.context) {
        refused(bench, reply, {0x0003}, {}, Weight::any);
        static_cast<void>(session.wire().answer_to(marker));
    }
    goes_on(session);
}

constexpr auto P = Group::packet;
constexpr auto R = Manner::reads;
constexpr auto malformed_words = "Status 0x0003, no data; the session goes on.";

// clang-format off
constexpr std::array cases{
    Case{"CPF-01", P, "A reply has a null address and an unconnected data item", "R-ENC-22", "The reply has the shape of the request, with interface handle and timeout 0.", R, reply_items},
    Case{"CPF-02", P, "No items are malformed", "R-CPF-2", malformed_words, R,
         [](Bench& b) { malformed(b, packet("00 00", {null_item, vendor_item}), Weight::any); }},
    Case{"CPF-03", P, "One item is malformed", "R-CPF-2", malformed_words, R,
         [](Bench& b) { malformed(b, packet("01 00", {"00 00 08 00 0E 03 20 01 24 01 30 01"}), Weight::any); }},
    Case{"CPF-04", P, "A connected address is none for SendRRData", "R-CPF-2", malformed_words, R,
         [](Bench& b) { malformed(b, packet("02 00", {"A1 00 04 00 01 02 03 04", vendor_item})); }},
    Case{"CPF-05", P, "Connected data are none for SendRRData", "R-CPF-2", malformed_words, R,
         [](Bench& b) { malformed(b, packet("02 00", {null_item, "B1 00 08 00 0E 03 20 01 24 01 30 01"})); }},
    Case{"CPF-06", P, "An unknown item is no address", "R-CPF-2", malformed_words, R,
         [](Bench& b) { malformed(b, packet("02 00", {"55 55 00 00", vendor_item})); }},
    Case{"CPF-07", P, "A null address has no data", "R-CPF-2", malformed_words, R,
         [](Bench& b) { malformed(b, packet("02 00", {"00 00 04 00 01 02 03 04", vendor_item}), Weight::any); }},
    Case{"CPF-08", P, "Items in the wrong order are malformed", "R-CPF-2", malformed_words, R,
         [](Bench& b) { malformed(b, packet("02 00", {vendor_item, null_item})); }},
    Case{"CPF-09", P, "An item does not end behind the message", "R-CPF-2", "Status 0x0003; some stacks say nothing.", R,
         [](Bench& b) { malformed_or_silent(b, packet("02 00", {null_item, "B2 00 FF 00 0E 03 20 01 24 01 30 01"}), {0x0003}); }},
    Case{"CPF-10", P, "Three items of which two are there are malformed", "R-CPF-2", "Status 0x0003; some stacks say nothing.", R,
         [](Bench& b) { malformed_or_silent(b, packet("03 00", {null_item, vendor_item}), {0x0003}); }},
    Case{"CPF-11", P, "Octets behind the last item are malformed", "R-CPF-2", "Status 0x0003; some stacks say nothing, or do not look.", R,
         [](Bench& b) { malformed(b, packet("02 00", {null_item, vendor_item, "DE AD"}), Weight::soft); }},
    Case{"CPF-12", P, "65535 items are malformed", "R-CPF-2", "Status 0x0003; some stacks say nothing.", R,
         [](Bench& b) { malformed_or_silent(b, packet("FF FF", {null_item, vendor_item}), {0x0003}); }},
    Case{"CPF-13", P, "SendRRData has at least 16 octets", "R-ENC-11", "Status 0x0065, no data.", R,
         [](Bench& b) { malformed_or_silent(b, hex("00 00 00 00 00 00 02 00 00 00"), {0x0065, 0x0003}); }},
    Case{"CPF-14", P, "SendRRData without data is refused", "R-ENC-11", "Status 0x0065, no data.", R,
         [](Bench& b) { malformed_or_silent(b, {}, {0x0065, 0x0003}); }},
    Case{"CPF-15", P, "The interface handle is 0", "R-ENC-22", "Any other is answered 0x0003; some stacks do not look.", R, interface_handle},
    Case{"CPF-16", P, "The timeout does not matter", "R-ENC-22", "The target ignores the timeout.", R,
         [](Bench& b) { auto data = packet("02 00", {null_item, vendor_item}); data[4] = 0x0A; answered(b, data); }},
    Case{"CPF-17", P, "Unknown items behind the message are passed over", "R-CPF-10", "Items that nobody knows, behind the data item, are ignored.", R,
         [](Bench& b) { answered(b, packet("03 00", {null_item, vendor_item, "77 77 02 00 01 02"})); }},
    Case{"CPF-18", P, "A socket address behind a read does not matter", "R-CPF-8", "Socket addresses are of use for a Forward_Open only.", R,
         [](Bench& b) { answered(b, packet("03 00", {null_item, vendor_item, "01 80 10 00 00 02 08 AE 00 00 00 00 00 00 00 00 00 00 00 00"})); }},
    Case{"CPF-19", P, "A message of no octets is malformed", "R-MSG-3", "Service and path size are the least; status 0x0003.", R,
         [](Bench& b) { malformed_or_silent(b, packet("02 00", {null_item, "B2 00 00 00"}), {0x0003}); }},
    Case{"CPF-20", P, "A message of one octet is malformed", "R-MSG-3", "Service and path size are the least; status 0x0003.", R,
         [](Bench& b) { malformed_or_silent(b, packet("02 00", {null_item, "B2 00 01 00 0E"}), {0x0003, 0x0000}); }},
    Case{"CPF-21", P, "SendUnitData has connected items", "R-ENC-23", "An address item 0x00A1 and a data item 0x00B1; anything else is refused or dropped.", R, unit_data_with_unconnected_items},
};
// clang-format on

}  // namespace

std::span<const Case> packet_cases() { return cases; }

}  // namespace servobus::scanner::conformance
