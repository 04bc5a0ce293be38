// Forward_Close (R-CON-34 to R-CON-37).
#include <fmt/format.h>

#include <array>

#include "cip/services.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"
#include "scanner/conformance/class3_link.hpp"
#include "scanner/conformance/io_link.hpp"

namespace servobus::scanner::conformance {
namespace {

void unknown_triad(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto open = class3_open(bench);
    const auto reply = close_triad(session, open);
    refused(bench, reply, {{0x01, 0x0107}});
    check_refusal_data(bench, reply, open);
}

/// A case that has an open explicit connection, which every device that takes requests over connections has.
template <class Then>
void with_open(Bench& bench, Then then) {
    Session session(bench);
    if (!session.is_open()) return;
    Class3Link link(session);
    if (link.is_open()) then(session, link);
}

void reply_form(Bench& bench) {
    with_open(bench, [&](Session&, Class3Link& link) {
        const auto reply = link.close();
        if (!granted(bench, reply)) return;
        const auto& data = reply->response.data;
        constexpr std::size_t whole = 10;
        bench.require(data.size() >= whole, fmt::format("{} octets and not 10", data.size()));
        const auto parsed = cip::ForwardCloseReply::parse(data);
        if (bench.require(parsed.has_value(), "it is not triad, application reply size and a reserved octet")) {
            bench.require(parsed->triad == link.request().triad, "the reply names another connection");
        }
    });
}

void twice(Bench& bench) {
    with_open(bench, [&](Session& session, Class3Link& link) {
        if (granted(bench, link.close())) refused(bench, close_triad(session, link.request()), {{0x01, 0x0107}});
    });
}

/// A Forward_Close whose path is another: taken, because the triad counts, or refused as such, and then it is still open.
void other_path(Bench& bench, std::string_view path) {
    with_open(bench, [&](Session& session, Class3Link& link) {
        auto other = link.request();
        other.path = hex(path);
        const auto reply = close_triad(session, other);
        if (!reply) return;
        if (reply->ok()) {
            link.forget();
            return;
        }
        refused(bench, reply, {{0x01, 0x0316}}, {{0x01, 0x0315}, 0x04, 0x26}, Weight::any);
        granted(bench, link.call(hex("0E 03 20 01 24 01 30 01")));
    });
}

void wrong_length(Bench& bench, const std::function<void(cip::Bytes&)>& change, std::initializer_list<Code> right) {
    with_open(bench, [&](Session& session, Class3Link& link) {
        auto request = close_request(link.request());
        change(request.data);
        const auto reply = session.call(request);
        refused(bench, reply, right, {0x26, 0x04, {0x01, 0x0315}}, Weight::any);
        if (reply && reply->ok()) {
            link.forget();
            return;
        }
        granted(bench, link.call(hex("0E 03 20 01 24 01 30 01")));
    });
}

void other_triad(Bench& bench, const std::function<void(cip::ConnectionTriad&)>& change) {
    with_open(bench, [&](Session& session, Class3Link& link) {
        auto other = link.request();
        change(other.triad);
        refused(bench, close_triad(session, other), {{0x01, 0x0107}}, {}, Weight::any);
        granted(bench, link.call(hex("0E 03 20 01 24 01 30 01")));
    });
}

void nothing_comes_afterwards(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    IoLink link(session, usual_plan(*candidate, usual_rpi));
    if (!link.is_open() || !flows(link, bench)) return;
    const auto interval = link.t_to_o_api();
    if (!granted(bench, link.close())) return;
    // What was on its way when the reply left is here by now.
    link.listen(std::chrono::milliseconds(5));
    const auto late = link.listen(10 * interval);
    bench.require(late.empty(), fmt::format("{} datagrams came after the reply to the Forward_Close", late.size()));
}

void late_outputs_are_dropped(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    IoLink link(session, usual_plan(*candidate, usual_rpi));
    if (!link.is_open() || !flows(link, bench)) return;
    if (!granted(bench, link.close())) return;
    link.listen(std::chrono::milliseconds(5));
    constexpr int late = 5;
    for (int i = 0; i < late; ++i) link.send();
    const auto came = link.listen(5 * link.t_to_o_api());
    bench.require(came.empty(), "datagrams revive a connection that is closed");
    refused(bench, close_triad(session, link.request()), {{0x01, 0x0107}}, {}, Weight::any);
}

void from_another_session(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    Session other(bench);
    if (candidate == nullptr || !session.is_open() || !other.is_open()) return;
    IoLink link(session, usual_plan(*candidate, usual_rpi));
    if (link.is_open() && flows(link, bench)) granted(bench, link.close(other));
}

void others_go_on(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    if (candidate->owns()) return bench.skip("the device has no connection that can be opened twice");
    IoLink first(session, usual_plan(*candidate, usual_rpi));
    IoLink second(session, usual_plan(*candidate, usual_rpi));
    if (!first.is_open() || !second.is_open()) return;
    if (!granted(bench, first.close())) return;
    flows(second, bench);
}

void outlives_its_session(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session other(bench);
    if (candidate == nullptr || !other.is_open()) return;
    Session session(bench);
    if (!session.is_open()) return;
    IoLink link(session, usual_plan(*candidate, usual_rpi));
    if (!link.is_open() || !flows(link, bench)) return;
    session.wire().reset();
    // The device needs a moment to learn of it.
    link.run(std::chrono::milliseconds(200));
    flows(link, bench);
    granted(bench, link.close(other));
}

constexpr auto C = Group::forward_close;
constexpr auto R = Manner::reads;

// clang-format off
constexpr std::array cases{
    Case{"FCL-01", C, "A connection that is not there", "R-CON-36", "Extended status 0x0107, the triad, remaining path size, a reserved octet.", R, unknown_triad},
    Case{"FCL-02", C, "The reply has the triad", "R-CON-34", "Triad, application reply size 0, a reserved octet.", R, reply_form},
    Case{"FCL-03", C, "The second Forward_Close finds nothing", "R-CON-36", "Extended status 0x0107.", R, twice},
    Case{"FCL-04", C, "Another path is taken, or refused as such", "R-CON-35", "The triad counts; extended status 0x0316 where paths are compared.", R, [](Bench& b) { other_path(b, "20 04 24 01 2C 65 2C 64"); }},
    Case{"FCL-05", C, "An empty path is taken, or refused as such", "R-CON-35", "The triad counts; extended status 0x0316 where paths are compared.", R, [](Bench& b) { other_path(b, ""); }},
    Case{"FCL-06", C, "Another serial number is another connection", "R-CON-22", "Serial number, vendor and originator serial number together name a connection.", R, [](Bench& b) { other_triad(b, [](cip::ConnectionTriad& t) { t.serial_number ^= 0x5A5A; }); }},
    Case{"FCL-07", C, "Another vendor is another connection", "R-CON-22", "Serial number, vendor and originator serial number together name a connection.", R, [](Bench& b) { other_triad(b, [](cip::ConnectionTriad& t) { t.originator_vendor ^= 0x5A5A; }); }},
    Case{"FCL-08", C, "Another originator is another connection", "R-CON-22", "Serial number, vendor and originator serial number together name a connection.", R, [](Bench& b) { other_triad(b, [](cip::ConnectionTriad& t) { t.originator_serial ^= 0x5A5A5A5A; }); }},
    Case{"FCL-09", C, "A Forward_Close of nine octets", "R-CON-36", "Status 0x13; nothing is closed.", R, [](Bench& b) { wrong_length(b, [](cip::Bytes& data) { data.resize(9); }, {0x13}); }},
    Case{"FCL-10", C, "A path that is longer than the data", "R-CON-36", "Status 0x13; nothing is closed.", R, [](Bench& b) { wrong_length(b, [](cip::Bytes& data) { data[10] = static_cast<std::uint8_t>(data[10] + 1); }, {0x13}); }},
    Case{"FCL-11", C, "A path that is shorter than the data", "R-CON-36", "Status 0x15; nothing is closed.", R, [](Bench& b) { wrong_length(b, [](cip::Bytes& data) { data.insert(data.end(), {0x00, 0x00}); }, {0x15}); }},
    Case{"FCL-12", C, "After the reply nothing more is sent", "R-CON-37", "No T->O datagram leaves after the reply.", R, nothing_comes_afterwards},
    Case{"FCL-13", C, "Late outputs are dropped", "R-CON-37", "O->T datagrams of a connection that is closed have no effect.", R, late_outputs_are_dropped},
    Case{"FCL-14", C, "Any session of the originator closes", "R-CON-35", "The triad counts, not the TCP connection.", R, from_another_session},
    Case{"FCL-15", C, "Other connections go on", "R-CON-37", "What is closed is one connection.", R, others_go_on},
    Case{"FCL-16", C, "An I/O connection outlives its TCP connection", "R-ENC-25", "The end of the TCP connection does not close I/O connections.", R, outlives_its_session},
};
// clang-format on

}  // namespace

std::span<const Case> forward_close_cases() { return cases; }

}  // namespace servobus::scanner::conformance
