// Registering and leaving sessions (R-ENC-17 to R-ENC-21).
#include <fmt/format.h>

#include <array>

#include "enip/messages.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"

namespace servobus::scanner::conformance {
namespace {

using enip::Command;
using enip::EncapsulationStatus;
using enip::Frame;

constexpr auto vendor_request = "0E 03 20 01 24 01 30 01";

Frame registering(Bench& bench, std::string_view data) {
    return make_frame(bench, Command::register_session, hex(data));
}

Frame asking(Bench& bench, std::uint32_t handle) {
    return make_frame(bench, Command::send_rr_data, enip::SendData::unconnected(hex(vendor_request)).encode(), handle);
}

bool is_session(Bench& bench, Wire& wire, std::uint32_t handle) {
    const auto reply = wire.exchange(asking(bench, handle));
    return reply && bench.require(reply->status == EncapsulationStatus::success,
                                  "the session does not work: status " + enip::describe(reply->status));
}

void registers(Bench& bench) {
    Wire wire(bench);
    if (!wire.is_open()) return;
    const auto reply = wire.exchange(registering(bench, "01 00 00 00"));
    if (!reply) return;
    bench.require(reply->status == EncapsulationStatus::success, "status " + enip::describe(reply->status));
    bench.require(reply->session != 0, "the session handle is 0");
    bench.require(reply->data == hex("01 00 00 00"), "the data does not come back as it was sent");
    if (reply->session != 0) is_session(bench, wire, reply->session);
}

void handles_differ(Bench& bench) {
    Session first(bench);
    Session second(bench);
    if (!first.is_open() || !second.is_open()) return;
    bench.require(first.handle() != second.handle(), "two sessions have the same handle");
}

void refuses_version(Bench& bench, std::string_view data) {
    Wire wire(bench);
    if (!wire.is_open()) return;
    const auto reply = wire.exchange(registering(bench, data));
    if (!reply) return;
    refused(bench, reply, {0x0069});
    bench.advise(reply->data == hex("01 00 00 00"), "the reply does not tell version 1 and options 0");
    bench.advise(reply->session == 0, fmt::format("the session handle is 0x{:08X} and not 0", reply->session));
    // The connection stays, and a session can be had on it.
    const auto second = wire.exchange(registering(bench, "01 00 00 00"));
    if (second)
        bench.require(second->session != 0,
                      "after the refusal there is no session to be had: status " + enip::describe(second->status));
}

void refuses_length(Bench& bench, std::string_view data) {
    Wire wire(bench);
    if (!wire.is_open()) return;
    refused(bench, wire.exchange(registering(bench, data)), {0x0065}, {}, Weight::soft);
    bench.require(wire.is_alive(), "the connection does not answer any more");
}

void registers_twice(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto reply = session.wire().exchange(registering(bench, "01 00 00 00"));
    if (!reply) return;
    if (reply->status == EncapsulationStatus::success) {
        bench.require(false, "a second session on the same connection");
        return;
    }
    refused(bench, reply, {0x0001}, {}, Weight::any);
    bench.advise(reply->session == session.handle(), "the reply does not tell the session that there is");
    is_session(bench, session.wire(), session.handle());
}

void needs_session(Bench& bench) {
    Wire wire(bench);
    if (!wire.is_open()) return;
    refused(bench, wire.exchange(asking(bench, 0)), {0x0064});
    refused(bench, wire.exchange(asking(bench, 0x00C0FFEE)), {0x0064});
}

void wrong_handle(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    refused(bench, session.wire().exchange(asking(bench, session.handle() ^ 0x5A5A5A5A)), {0x0064});
    is_session(bench, session.wire(), session.handle());
}

void handle_of_another(Bench& bench) {
    Session first(bench);
    Session second(bench);
    if (!first.is_open() || !second.is_open()) return;
    refused(bench, second.wire().exchange(asking(bench, first.handle())), {0x0064});
    is_session(bench, first.wire(), first.handle());
}

void wrong_handle_in_unit_data(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    auto request = session.unit_frame(0x11223344, 1, hex(vendor_request));
    request.session ^= 0x5A5A5A5A;
    const auto marker = make_frame(bench, Command::list_services);
    if (!session.wire().send(request) || !session.wire().send(marker)) return;
    const auto reply = session.wire().receive();
    if (!bench.require(reply.has_value(), "the connection does not answer any more")) return;
    if (reply->context == marker.context) return;  // no answer is right too
    refused(bench, reply, {0x0064});
}

void unregisters(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto handle = session.handle();
    if (!session.wire().send(make_frame(bench, Command::unregister_session, {}, handle))) return;
    constexpr milliseconds for_closing{1000};
    if (session.wire().closes(for_closing)) {
        bench.require(bench.record.steps().back().octets.empty(), "UnRegisterSession was answered");
        return;
    }
    bench.advise(false, "the device leaves closing the TCP connection to the originator");
    refused(bench, session.wire().exchange(asking(bench, handle)), {0x0064});
}

void unregisters_with_data(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto handle = session.handle();
    if (!session.wire().send(make_frame(bench, Command::unregister_session, hex("01 02 03 04"), handle))) return;
    constexpr milliseconds for_closing{1000};
    if (session.wire().closes(for_closing)) return;
    const auto reply = session.wire().exchange(asking(bench, handle));
    if (reply) bench.advise(reply->status != EncapsulationStatus::success, "the session goes on");
}

void unregisters_another(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto request = make_frame(bench, Command::unregister_session, {}, session.handle() ^ 0x5A5A5A5A);
    const auto marker = make_frame(bench, Command::list_services);
    if (!session.wire().send(request) || !session.wire().send(marker)) return;
    const auto reply = session.wire().receive();
    if (!reply && !session.wire().is_open()) {
        bench.advise(false, "the connection is closed");
        return;
    }
    if (!bench.require(reply.has_value(), "the connection does not answer any more")) return;
    if (reply->context != marker.context) {
        refused(bench, reply, {0x0064});
        static_cast<void>(session.wire().answer_to(marker));
    }
    is_session(bench, session.wire(), session.handle());
}

/// The handle of a session that is over, on a connection that has none.
void is_over(Bench& bench, std::uint32_t handle) {
    Wire wire(bench);
    if (!wire.is_open()) return;
    refused(bench, wire.exchange(asking(bench, handle)), {0x0064});
}

void handle_ends_with_session(Bench& bench) {
    Session session(bench);
    const auto handle = session.handle();
    if (!session.is_open()) return;
    session.leave();
    is_over(bench, handle);
}

void session_ends_with_connection(Bench& bench) {
    Session session(bench);
    const auto handle = session.handle();
    if (!session.is_open()) return;
    session.wire().reset();
    is_over(bench, handle);
}

void sessions_are_given_back(Bench& bench) {
    constexpr int times = 40;
    for (int i = 0; i < times; ++i) {
        Session session(bench);
        if (!bench.require(session.is_open(),
                           fmt::format("session {} of {} one after the other is refused", i + 1, times))) {
            return;
        }
    }
}

void connections_are_given_back(Bench& bench) {
    constexpr int times = 40;
    for (int i = 0; i < times; ++i) {
        Session session(bench);
        if (!bench.require(session.is_open(),
                           fmt::format("session {} of {} one after the other is refused", i + 1, times))) {
            return;
        }
        session.wire().reset();
    }
}

constexpr auto S = Group::sessions;
constexpr auto R = Manner::reads;

// clang-format off
constexpr std::array cases{
    Case{"SES-01", S, "RegisterSession makes a session", "R-ENC-17", "A handle other than 0, the data as it was sent; the session works.", R, registers},
    Case{"SES-02", S, "Each session has a handle of its own", "R-ENC-17", "One session for each TCP connection, each with its handle.", R, handles_differ},
    Case{"SES-03", S, "Protocol version 2 is refused", "R-ENC-18", "Status 0x0069, data version 1 and options 0, handle 0; the connection stays.", R,
         [](Bench& b) { refuses_version(b, "02 00 00 00"); }},
    Case{"SES-04", S, "Protocol version 0 is refused", "R-ENC-18", "Status 0x0069, data version 1 and options 0, handle 0; the connection stays.", R,
         [](Bench& b) { refuses_version(b, "00 00 00 00"); }},
    Case{"SES-05", S, "Option flags are refused", "R-ENC-18", "Status 0x0069, data version 1 and options 0, handle 0; the connection stays.", R,
         [](Bench& b) { refuses_version(b, "01 00 01 00"); }},
    Case{"SES-06", S, "RegisterSession of two octets is refused", "R-ENC-11", "RegisterSession has four octets of data; others are answered 0x0065.", R,
         [](Bench& b) { refuses_length(b, "01 00"); }},
    Case{"SES-07", S, "RegisterSession of six octets is refused", "R-ENC-11", "RegisterSession has four octets of data; others are answered 0x0065.", R,
         [](Bench& b) { refuses_length(b, "01 00 00 00 00 00"); }},
    Case{"SES-08", S, "A second RegisterSession is refused", "R-ENC-19", "Status 0x0001; the session that there is goes on.", R, registers_twice},
    Case{"SES-09", S, "SendRRData needs a session", "R-ENC-21", "Status 0x0064, no data, and CIP does not see the request.", R, needs_session},
    Case{"SES-10", S, "A wrong session handle is refused", "R-ENC-21", "Status 0x0064; the session of the connection goes on.", R, wrong_handle},
    Case{"SES-11", S, "A handle is of use on its own connection only", "R-ENC-17", "A handle is valid on the connection that has made it.", R, handle_of_another},
    Case{"SES-12", S, "SendUnitData needs the session's handle", "R-ENC-21", "Status 0x0064, or no answer.", R, wrong_handle_in_unit_data},
    Case{"SES-13", S, "UnRegisterSession ends session and connection", "R-ENC-20", "No reply; the session is over and the TCP connection closes.", R, unregisters},
    Case{"SES-14", S, "UnRegisterSession with data is honoured", "R-ENC-11", "Data in it does not matter.", R, unregisters_with_data},
    Case{"SES-15", S, "UnRegisterSession does not end another's session", "R-ENC-20", "Status 0x0064 or no answer; the session of the connection goes on.", R, unregisters_another},
    Case{"SES-16", S, "A handle is void after UnRegisterSession", "R-ENC-20", "A session that has ended cannot be used from anywhere.", R, handle_ends_with_session},
    Case{"SES-17", S, "A session ends with its TCP connection", "R-ENC-25", "The end of the TCP connection, whatever its cause, ends the session.", R, session_ends_with_connection},
    Case{"SES-18", S, "Sessions that have ended are given back", "R-ENC-20", "UnRegisterSession frees what the session had.", R, sessions_are_given_back},
    Case{"SES-19", S, "Connections that were reset are given back", "R-ENC-25", "The end of the TCP connection frees what it had.", R, connections_are_given_back},
};
// clang-format on

}  // namespace

std::span<const Case> session_cases() { return cases; }

}  // namespace servobus::scanner::conformance
