// TCP connections that are silent (R-ENC-24). The inactivity timeout is set to its shortest and back.
#include <fmt/format.h>

#include <array>

#include "scanner/conformance/attribute.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"
#include "scanner/conformance/class3_link.hpp"
#include "scanner/conformance/io_link.hpp"

namespace servobus::scanner::conformance {
namespace {

using namespace std::chrono_literals;

constexpr Place place{0xF5, 1, 13};
constexpr auto shortest = "01 00";
/// How long a silent connection may live: the timeout, and what a device takes to look.
constexpr milliseconds patience = 4s;
/// Messages of those who are not silent.
constexpr milliseconds beat = 250ms;
constexpr int beats = 8;

/// While the timeout is one second. `keeper` is the session that has set it, and sets it back.
template <class Then>
void with_short_timeout(Bench& bench, Then then) {
    Session keeper(bench);
    if (!keeper.is_open()) return;
    const auto before = read(keeper, place, Presence::optional);
    if (!before) return;
    const auto set = keeper.call(set_request(place, hex(shortest)));
    if (!set) return;
    if (!set->ok())
        return bench.skip(fmt::format("the inactivity timeout cannot be set: {}", cip::describe(set->response.status)));
    then(keeper);
    // The one that has set it may be gone by now.
    if (!keeper.wire().is_alive()) {
        Session another(bench);
        if (!another.is_open()) return;
        granted(bench, another.call(set_request(place, *before)));
        return;
    }
    granted(bench, keeper.call(set_request(place, *before)));
    const auto after = peek(keeper, place);
    bench.require(after && *after == *before, "the inactivity timeout is not what it was");
}

/// Waits for the end of a connection while another says something now and then.
bool ends(Wire& silent, Wire& busy, milliseconds longest) {
    const auto end = std::chrono::steady_clock::now() + longest;
    while (std::chrono::steady_clock::now() < end) {
        if (silent.closes(beat)) return true;
        busy.send_unrecorded(make_frame(busy.bench(), enip::Command::nop));
    }
    return false;
}

void silent_session_ends(Bench& bench) {
    with_short_timeout(bench, [&](Session& keeper) {
        Session session(bench);
        if (!session.is_open()) return;
        const auto begin = std::chrono::steady_clock::now();
        const bool ended = ends(session.wire(), keeper.wire(), patience);
        const auto took = std::chrono::duration_cast<milliseconds>(std::chrono::steady_clock::now() - begin);
        if (!bench.require(ended,
                           fmt::format("a session is silent for {} ms and goes on; the timeout is 1 s", took.count())))
            return;
        bench.require(took >= 800ms, fmt::format("a session is closed after {} ms; the timeout is 1 s", took.count()));
    });
}

void silent_connection_ends(Bench& bench) {
    with_short_timeout(bench, [&](Session& keeper) {
        Wire wire(bench);
        if (!wire.is_open()) return;
        bench.advise(ends(wire, keeper.wire(), patience),
                     "a connection without a session is silent for four seconds and goes on; the timeout is 1 s");
    });
}

/// A session that says something that is no request lives.
void nop_is_activity(Bench& bench) {
    with_short_timeout(bench, [&](Session& keeper) {
        Session session(bench);
        if (!session.is_open()) return;
        for (int i = 0; i < beats; ++i) {
            if (!bench.require(!session.wire().closes(beat), "a session that sends NOPs is closed")) return;
            session.wire().send(make_frame(bench, enip::Command::nop));
            keeper.wire().send_unrecorded(make_frame(bench, enip::Command::nop));
        }
        granted(bench, session.call(hex("0E 03 20 01 24 01 30 01")));
    });
}

void requests_are_activity(Bench& bench) {
    with_short_timeout(bench, [&](Session& keeper) {
        Session session(bench);
        if (!session.is_open()) return;
        Class3Link link(session);
        if (!link.is_open()) return;
        for (int i = 0; i < beats; ++i) {
            if (!bench.require(!session.wire().closes(beat),
                               "a session that sends requests over a connection is closed"))
                return;
            if (!granted(bench, link.call(hex("0E 03 20 01 24 01 30 01")))) return;
            keeper.wire().send_unrecorded(make_frame(bench, enip::Command::nop));
        }
    });
}

void io_goes_on(Bench& bench) {
    const auto* candidate = harmless(bench);
    if (candidate == nullptr) return;
    with_short_timeout(bench, [&](Session& keeper) {
        Session session(bench);
        if (!session.is_open()) return;
        IoLink link(session, usual_plan(*candidate, usual_rpi));
        if (!link.is_open()) return;
        const auto end = std::chrono::steady_clock::now() + patience;
        bool ended = false;
        while (!ended && std::chrono::steady_clock::now() < end) {
            link.run(beat);
            ended = session.wire().closes(1ms);
            keeper.wire().send_unrecorded(make_frame(bench, enip::Command::nop));
        }
        bench.advise(ended, "the TCP connection goes on, because an I/O connection was opened over it");
        flows(link, bench);
        granted(bench, link.close(keeper));
    });
}

constexpr auto I = Group::inactivity;
constexpr auto W = Manner::writes;

// clang-format off
constexpr std::array cases{
    Case{"INA-01", I, "A silent session ends", "R-ENC-24", "After attribute 13 of TCP/IP, in seconds, without a message the device closes the TCP connection.", W, silent_session_ends},
    Case{"INA-02", I, "A connection that never registers ends", "R-ENC-26", "The time counts without a session too.", W, silent_connection_ends},
    Case{"INA-03", I, "A NOP is activity", "R-ENC-10", "Every encapsulation message starts the time again.", W, nop_is_activity},
    Case{"INA-04", I, "Requests over a connection are activity", "R-ENC-24", "Every encapsulation message starts the time again.", W, requests_are_activity},
    Case{"INA-05", I, "I/O goes on", "R-ENC-24", "I/O connections that were opened over it stay.", W, io_goes_on},
};
// clang-format on

}  // namespace

std::span<const Case> inactivity_cases() { return cases; }

}  // namespace servobus::scanner::conformance
