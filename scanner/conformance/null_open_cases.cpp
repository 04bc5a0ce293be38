// Forward_Opens that open nothing (R-CON-23).
#include <fmt/format.h>

#include <array>

#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"
#include "scanner/conformance/io_link.hpp"

namespace servobus::scanner::conformance {
namespace {

using cip::ConnectionType;

void make_null(cip::ConnectionParameters& direction) {
    direction.type = ConnectionType::null;
    direction.size = 0;
}

void make_null(cip::ForwardOpen& open) {
    make_null(open.o_to_t);
    make_null(open.t_to_o);
}

/// A null open may be granted, and then nothing is open; or it is refused as such.
void judge(Bench& bench, const std::optional<Reply>& reply) {
    if (!reply || reply->ok()) return;
    refused(bench, reply, {{0x01, 0x0132}}, {}, Weight::any);
}

void opens_nothing(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    const auto open =
        open_of(session, usual_plan(*candidate, usual_rpi), [](cip::ForwardOpen& each) { make_null(each); });
    const auto reply = session.call(open_request(open));
    judge(bench, reply);
    check_refusal_data(bench, reply, open);
    refused(bench, close_triad(session, open), {{0x01, 0x0107}}, {}, Weight::any);
}

void leaves_the_open_one(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    IoLink link(session, usual_plan(*candidate, usual_rpi));
    if (!link.is_open() || !flows(link, bench)) return;
    auto open = link.request();
    make_null(open);
    const auto reply = session.call(open_request(open));
    if (reply && !reply->ok()) refused(bench, reply, {{0x01, 0x0132}}, {{0x01, 0x0100}}, Weight::any);
    flows(link, bench);
}

void half_null(Bench& bench, bool o_to_t) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    const auto open = open_of(session, usual_plan(*candidate, usual_rpi),
                              [&](cip::ForwardOpen& each) { make_null(o_to_t ? each.o_to_t : each.t_to_o); });
    const auto reply = try_open(session, open);
    // Some devices have connections of one direction alone.
    const std::uint16_t word = o_to_t ? 0x0123 : 0x0124;
    refused(bench, reply, {{0x01, word}}, {}, Weight::soft);
    check_refusal_data(bench, reply, open);
}

void wrong_key(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    auto plan = usual_plan(*candidate, usual_rpi);
    const auto& identity = bench.subject().identity;
    if (!identity) return bench.skip("the device does not say who it is");
    plan.key = cip::ElectronicKey{.vendor = static_cast<std::uint16_t>(identity->vendor ^ 0x0F0F)};
    const auto open = open_of(session, plan, [](cip::ForwardOpen& each) { make_null(each); });
    refused(bench, session.call(open_request(open)), {{0x01, 0x0132}, {0x01, 0x0114}}, {}, Weight::any);
}

void malformed(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    auto request = open_request(
        open_of(session, usual_plan(*candidate, usual_rpi), [](cip::ForwardOpen& each) { make_null(each); }));
    request.data.resize(20);
    refused(bench, session.call(request), {0x13}, {}, Weight::any);
}

constexpr auto N = Group::null_open;
constexpr auto R = Manner::reads;

// clang-format off
constexpr std::array cases{
    Case{"NUL-01", N, "A null open opens nothing", "R-CON-23", "Both directions null: it is answered 0x0132, or granted, and nothing is open.", R, opens_nothing},
    Case{"NUL-02", N, "A null open leaves an open connection alone", "R-CON-23", "With the triad of an open connection it is answered 0x0132, or granted; the connection goes on.", R, leaves_the_open_one},
    Case{"NUL-03", N, "A null O->T alone", "R-CON-23", "Extended status 0x0123, where there are no such connections.", R, [](Bench& b) { half_null(b, true); }},
    Case{"NUL-04", N, "A null T->O alone", "R-CON-23", "Extended status 0x0124, where there are no such connections.", R, [](Bench& b) { half_null(b, false); }},
    Case{"NUL-05", N, "A null open with the key of another", "R-CON-11", "It is refused as such, or for its key.", R, wrong_key},
    Case{"NUL-06", N, "A null open that is cut", "R-CON-14", "Status 0x13.", R, malformed},
};
// clang-format on

}  // namespace

std::span<const Case> null_open_cases() { return cases; }

}  // namespace servobus::scanner::conformance
