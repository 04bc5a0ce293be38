// Explicit connections (R-CON-45 to R-CON-47).
#include <fmt/format.h>

#include <array>
#include <thread>

#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"
#include "scanner/conformance/class3_link.hpp"
#include "scanner/conformance/io_link.hpp"
#include "scanner/io_plan.hpp"

namespace servobus::scanner::conformance {
namespace {

constexpr auto vendor_request = "0E 03 20 01 24 01 30 01";
constexpr auto name_request = "0E 03 20 01 24 01 30 07";

/// A case that has an open connection.
template <class Then>
void with_link(Bench& bench, Then then, const Change& change = {}) {
    Session session(bench);
    if (!session.is_open()) return;
    Class3Link link(session, change);
    if (link.is_open()) then(session, link);
}

void opens(Bench& bench) {
    with_link(bench, [&](Session&, Class3Link& link) {
        const auto& grant = link.grant();
        bench.require(grant.triad == link.request().triad, "the reply names another connection");
        bench.require(grant.t_to_o_id == link.request().t_to_o_id,
                      "the T->O id is not the one that the originator has chosen");
        bench.require(grant.o_to_t_id != 0, "the O->T id is 0");
        bench.advise(grant.o_to_t_api == link.request().o_to_t_rpi,
                     fmt::format("{} us granted and {} us asked", grant.o_to_t_api, link.request().o_to_t_rpi));
        bench.advise(grant.application_reply.empty(), "there is an application reply");
        const auto closed = link.close();
        if (!granted(bench, closed)) return;
        bench.require(cip::ForwardCloseReply::parse(closed->response.data).has_value(),
                      "the reply to the Forward_Close is not triad, application reply size and a reserved octet");
    });
}

void opens_large(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    auto open = class3_open(bench);
    open.large = true;
    open.o_to_t.size = 1400;
    open.t_to_o.size = 1400;
    const auto reply = try_open(session, open);
    if (is_unsupported(reply)) return bench.skip("the device has no Large_Forward_Open");
    if (!reply || reply->ok()) return;
    refused(bench, reply, {{0x01, 0x0127}, {0x01, 0x0128}, {0x01, 0x0109}}, {}, Weight::any);
}

void answers_alike(Bench& bench) {
    with_link(bench, [&](Session& session, Class3Link& link) {
        for (const auto* message : {vendor_request, name_request, "0E 03 20 C7 24 01 30 01", "0E 03 20 01 24 01 30 63",
                                    "4A 02 20 01 24 01"}) {
            const auto unconnected = session.call(hex(message));
            const auto connected = link.call(hex(message));
            if (!unconnected || !connected) return;
            bench.require(unconnected->message == connected->message,
                          fmt::format("the request {} is answered differently over a connection", message));
        }
    });
}

void repeats_reply(Bench& bench) {
    with_link(bench, [&](Session&, Class3Link& link) {
        const auto sequence = link.next_sequence();
        const auto first = link.call(hex(vendor_request), sequence);
        const auto second = link.call(hex(vendor_request), sequence);
        if (first && second)
            bench.require(first->message == second->message,
                          "the same request with the same sequence count is answered differently");
    });
}

void does_not_execute_twice(Bench& bench) {
    with_link(bench, [&](Session&, Class3Link& link) {
        const auto sequence = link.next_sequence();
        const auto first = link.call(hex(vendor_request), sequence);
        // Whoever looks at the count alone sends the reply that it has.
        const auto second = link.call(hex(name_request), sequence);
        if (first && second)
            bench.require(first->message == second->message,
                          "a request with the sequence count of the one before is executed");
    });
}

void any_other_count_is_new(Bench& bench) {
    with_link(bench, [&](Session&, Class3Link& link) {
        const auto vendor = link.call(hex(vendor_request), std::uint16_t{100});
        for (const auto sequence : std::array<std::uint16_t, 5>{50, 51, 0, 65535, 1}) {
            const auto name = link.call(hex(name_request), sequence);
            const auto again = link.call(hex(vendor_request), static_cast<std::uint16_t>(sequence + 7));
            if (!vendor || !granted(bench, name) || !again) return;
            bench.require(name->message != vendor->message,
                          fmt::format("the request with sequence count {} gets an old reply", sequence));
            bench.require(again->message == vendor->message, "the vendor changes");
        }
    });
}

void count_zero_first(Bench& bench) {
    with_link(bench,
              [&](Session&, Class3Link& link) { granted(bench, link.call(hex(vendor_request), std::uint16_t{0})); });
}

void unknown_id(Bench& bench) {
    with_link(bench, [&](Session& session, Class3Link& link) {
        const auto request = session.unit_frame(link.grant().o_to_t_id ^ 0x5A5A0000, 1, hex(vendor_request));
        const auto marker = make_frame(bench, enip::Command::list_services);
        if (!session.wire().send(request) || !session.wire().send(marker)) return;
        const auto reply = session.wire().receive();
        if (!reply && !session.wire().is_open()) {
            bench.advise(false, "the device closes the TCP connection");
            link.forget();
            return;
        }
        if (!bench.require(reply.has_value(), "the connection does not answer any more")) return;
        if (!bench.require(reply->context == marker.context,
                           "a message for a connection that is not there is answered"))
            return;
        granted(bench, link.call(hex(vendor_request)));
    });
}

void two_links(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    Class3Link first(session);
    Class3Link second(session);
    if (!first.is_open() || !second.is_open()) return;
    bench.require(first.grant().o_to_t_id != second.grant().o_to_t_id, "two connections have the same O->T id");
    granted(bench, first.call(hex(vendor_request), std::uint16_t{7}));
    const auto name = second.call(hex(name_request), std::uint16_t{7});
    const auto vendor = first.call(hex(vendor_request), std::uint16_t{8});
    if (granted(bench, name) && granted(bench, vendor))
        bench.require(name->message != vendor->message, "the connections have one sequence count between them");
    granted(bench, first.close());
    granted(bench, second.call(hex(vendor_request), std::uint16_t{9}));
}

void reply_fits(Bench& bench) {
    constexpr std::uint16_t small = 16;
    with_link(
        bench,
        [&](Session&, Class3Link& link) {
            const auto reply = link.call(hex("01 02 20 01 24 01"));
            if (!reply) return;
            const auto octets = reply->message.size() + 2;
            bench.require(octets <= small, fmt::format("a reply of {} octets on a connection of {}", octets, small));
            refused(bench, reply, {0x11}, {0x08}, Weight::any);
            granted(bench, link.call(hex(vendor_request)));
        },
        [](cip::ForwardOpen& open) { open.t_to_o.size = small; });
}

void refuses(Bench& bench, const Change& change, std::initializer_list<Code> right,
             std::initializer_list<Code> tolerated, Weight weight = Weight::any) {
    Session session(bench);
    if (!session.is_open()) return;
    auto open = class3_open(bench);
    change(open);
    const auto reply = try_open(session, open);
    if (is_unsupported(reply)) return bench.skip("the device has no explicit connections");
    refused(bench, reply, right, tolerated, weight);
    check_refusal_data(bench, reply, open);
}

void refuses_duplicate(Bench& bench) {
    with_link(bench, [&](Session& session, Class3Link& link) {
        const auto reply = session.call(open_request(link.request()));
        refused(bench, reply, {{0x01, 0x0100}}, {}, Weight::any);
        check_refusal_data(bench, reply, link.request());
        granted(bench, link.call(hex(vendor_request)));
    });
}

void ends_with_close(Bench& bench) {
    with_link(bench, [&](Session& session, Class3Link& link) {
        granted(bench, link.call(hex(vendor_request)));
        if (!granted(bench, link.close())) return;
        if (!link.expect_silence(hex(vendor_request), "a request over a connection that is closed", false)) return;
        refused(bench, close_triad(session, link.request()), {{0x01, 0x0107}}, {}, Weight::any);
    });
}

void ends_with_tcp(Bench& bench) {
    cip::ForwardOpen request;
    {
        Session session(bench);
        if (!session.is_open()) return;
        Class3Link link(session);
        if (!link.is_open()) return;
        granted(bench, link.call(hex(vendor_request)));
        request = link.request();
        link.forget();
        session.wire().reset();
    }
    // The device learns of it a little later.
    constexpr int looks = 20;
    for (int i = 0; i < looks; ++i) {
        Session session(bench);
        if (!session.is_open()) return;
        const auto reply = close_triad(session, request);
        if (!reply) return;
        if (!reply->ok()) return refused(bench, reply, {{0x01, 0x0107}}, {}, Weight::any);
        if (i == 0) std::this_thread::sleep_for(milliseconds(50));
        // It was still there, and has been closed just now: open another and give the device more time.
        Class3Link link(session);
        if (!link.is_open()) return;
        request = link.request();
        link.forget();
        session.wire().reset();
        std::this_thread::sleep_for(milliseconds(50 * (i + 1)));
    }
    bench.require(false, "the connection outlives its TCP connection");
}

void unconnected_meanwhile(Bench& bench) {
    with_link(bench, [&](Session& session, Class3Link& link) {
        for (int i = 0; i < 5; ++i) {
            granted(bench, link.call(hex(vendor_request)));
            granted(bench, session.call(hex(name_request)));
        }
    });
}

void many_in_a_row(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    constexpr int times = 40;
    for (int i = 0; i < times; ++i) {
        Class3Link link(session);
        if (!link.is_open()) {
            bench.require(!bench.reason().empty() && i == 0,
                          fmt::format("connection {} of {} one after the other is refused", i + 1, times));
            return;
        }
    }
}

constexpr auto C = Group::class3;
constexpr auto R = Manner::reads;

// clang-format off
constexpr std::array cases{
    Case{"CL3-01", C, "A connection opens and closes", "R-CON-13", "The reply has both ids, the triad and the intervals; the T->O id is the originator's.", R, opens},
    Case{"CL3-02", C, "A large connection opens, or its size is refused", "R-CON-2", "Large_Forward_Open takes sizes above 511; where it is not there, 0x08.", R, opens_large},
    Case{"CL3-03", C, "Requests are answered as without a connection", "R-MSG-5", "The same service behaves alike over a connection, with its id and sequence count.", R, answers_alike},
    Case{"CL3-04", C, "A repeated request gets the same reply", "R-CON-46", "The sequence count of the request before means a repeat: the stored reply is sent.", R, repeats_reply},
    Case{"CL3-05", C, "A repeated request is not executed", "R-CON-46", "The sequence count of the request before means a repeat, whatever is in it.", R, does_not_execute_twice},
    Case{"CL3-06", C, "Any other sequence count is new", "R-CON-46", "Only the count of the request before is a repeat; counts may go back and wrap.", R, any_other_count_is_new},
    Case{"CL3-07", C, "The first sequence count may be 0", "R-CON-46", "Before the first request there is none to be repeated.", R, count_zero_first},
    Case{"CL3-08", C, "A message for an unknown connection is dropped", "R-ENC-23", "No answer; the connections that there are go on. Some stacks close the TCP connection.", R, unknown_id},
    Case{"CL3-09", C, "Two connections have nothing in common", "R-CON-45", "Each has ids and a sequence count of its own, and ends by itself.", R, two_links},
    Case{"CL3-10", C, "A reply fits its connection", "R-ENC-27", "What does not fit is answered 0x11.", R, reply_fits},
    Case{"CL3-11", C, "Multicast T->O is refused", "R-CON-47", "Class 3 is point-to-point: status 0x01, extended status 0x0124.", R,
         [](Bench& b) { refuses(b, [](cip::ForwardOpen& open) { open.t_to_o.type = cip::ConnectionType::multicast; }, {{0x01, 0x0124}}, {{0x01, 0x0108}, {0x01, 0x0103}}); }},
    Case{"CL3-12", C, "Multicast O->T is refused", "R-CON-47", "Class 3 is point-to-point: status 0x01, extended status 0x0123.", R,
         [](Bench& b) { refuses(b, [](cip::ForwardOpen& open) { open.o_to_t.type = cip::ConnectionType::multicast; }, {{0x01, 0x0123}}, {{0x01, 0x0108}, {0x01, 0x0103}}); }},
    Case{"CL3-13", C, "A connection that is open cannot be opened again", "R-CON-26", "Status 0x01, extended status 0x0100; the open one goes on.", R, refuses_duplicate},
    Case{"CL3-14", C, "After Forward_Close nothing is answered", "R-CON-37", "The connection is gone: no reply over it, and 0x0107 to another Forward_Close.", R, ends_with_close},
    Case{"CL3-15", C, "A connection ends with its TCP connection", "R-ENC-25", "The end of the TCP connection closes its explicit connections.", R, ends_with_tcp},
    Case{"CL3-16", C, "Unconnected requests are answered meanwhile", "R-MSG-5", "An open connection does not hold up unconnected messages.", R, unconnected_meanwhile},
    Case{"CL3-17", C, "Connections that were closed are given back", "R-CON-37", "A Forward_Close frees what the connection had.", R, many_in_a_row},
    Case{"CL3-18", C, "An RPI of 0 is refused", "R-CON-17", "Status 0x01, extended status 0x0111.", R,
         [](Bench& b) { refuses(b, [](cip::ForwardOpen& open) { open.o_to_t_rpi = 0; }, {{0x01, 0x0111}}, {{0x01, 0x0112}}, Weight::soft); }},
    Case{"CL3-19", C, "A path to an object that is not there is refused", "R-CON-40", "Status 0x01, extended status 0x0315.", R,
         [](Bench& b) { refuses(b, [](cip::ForwardOpen& open) { open.path = hex("20 C7 24 01"); }, {{0x01, 0x0315}}, {{0x01, 0x0117}, 0x05, 0x04}); }},
};
// clang-format on

}  // namespace

std::span<const Case> class3_cases() { return cases; }

}  // namespace servobus::scanner::conformance
