// Forward_Opens that must be refused, each with one thing wrong, because targets check in different orders (R-CON-15).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "cip/services.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"
#include "scanner/conformance/io_link.hpp"

namespace servobus::scanner::conformance {
namespace {

using cip::ConnectionType;
using PlanChange = std::function<void(IoPlan&)>;

void judge(Bench& bench, Session& session, const cip::ForwardOpen& open, std::vector<enip::Item> items,
           std::initializer_list<Code> right, std::initializer_list<Code> tolerated, Weight weight) {
    const auto reply = try_open(session, open, std::move(items));
    refused(bench, reply, right, tolerated, weight);
    check_refusal_data(bench, reply, open);
}

/// The harmless connection with a field of its Forward_Open changed.
void refuses(Bench& bench, const Change& change, std::initializer_list<Code> right,
             std::initializer_list<Code> tolerated = {}, Weight weight = Weight::any) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    judge(bench, session, open_of(session, usual_plan(*candidate, usual_rpi), change), {}, right, tolerated, weight);
}

/// The same with a path of these octets.
void refuses_path(Bench& bench, std::string_view path, std::initializer_list<Code> right,
                  std::initializer_list<Code> tolerated = {}) {
    refuses(
        bench, [&](cip::ForwardOpen& open) { open.path = hex(path); }, right, tolerated);
}

/// The same with octets in front of the usual path, or behind it.
void refuses_more_path(Bench& bench, std::string_view front, std::string_view behind, std::initializer_list<Code> right,
                       std::initializer_list<Code> tolerated = {}, Weight weight = Weight::any) {
    refuses(
        bench,
        [&](cip::ForwardOpen& open) {
            open.path = join({hex(front), open.path, hex(behind)});
        },
        right, tolerated, weight);
}

/// The size that is wrong, and the right one in the reply.
void refuses_size(Bench& bench, bool o_to_t, int difference) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    std::uint16_t right = 0;
    const auto open = open_of(session, usual_plan(*candidate, usual_rpi), [&](cip::ForwardOpen& each) {
        auto& size = o_to_t ? each.o_to_t.size : each.t_to_o.size;
        right = size;
        size = static_cast<std::uint16_t>(size + difference);
    });
    const std::uint16_t word = o_to_t ? 0x0127 : 0x0128;
    const auto reply = try_open(session, open);
    refused(bench, reply, {{0x01, word}}, {{0x01, 0x0109}, {0x01, 0x0108}}, Weight::any);
    check_refusal_data(bench, reply, open);
    if (!reply || !Code(0x01, word).matches(reply->response.status)) return;
    const auto& words = reply->response.status.extended;
    if (!bench.advise(words.size() >= 2, "the refusal does not tell the right size")) return;
    bench.require(words[1] == right,
                  fmt::format("the refusal tells {} as the right size, and it is {}", words[1], right));
}

std::uint32_t unused_point(Bench& bench) {
    std::set<std::uint32_t> used;
    for (const auto& each : bench.subject().options().candidates) {
        used.insert({each.plan.o_to_t.point, each.plan.t_to_o.point, each.plan.configuration_instance.value_or(0)});
    }
    std::uint32_t point = 0xD3;
    while (used.contains(point)) --point;
    return point;
}

void refuses_points(Bench& bench, bool o_to_t, bool t_to_o, std::initializer_list<Code> right,
                    std::initializer_list<Code> tolerated) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    if (candidate->plan.application_path) return bench.skip("the connection has a path of its own kind");
    auto plan = usual_plan(*candidate, usual_rpi);
    if (o_to_t) plan.o_to_t.point = unused_point(bench);
    if (t_to_o) plan.t_to_o.point = unused_point(bench);
    judge(bench, session, open_of(session, plan), {}, right, tolerated, Weight::any);
}

/// One application path of the usual ones is left, or one is added.
void refuses_point_count(Bench& bench, std::size_t count, std::initializer_list<Code> right,
                         std::initializer_list<Code> tolerated) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    if (candidate->plan.application_path) return bench.skip("the connection has a path of its own kind");
    auto plan = usual_plan(*candidate, usual_rpi);
    cip::Path path({cip::logical(cip::LogicalType::class_id, cip::class_id::assembly)});
    for (std::size_t i = 0; i < count; ++i)
        path.segments.emplace_back(cip::logical(cip::LogicalType::connection_point, plan.t_to_o.point));
    plan.application_path = path;
    plan.configuration.clear();
    judge(bench, session, open_of(session, plan), {}, right, tolerated, Weight::any);
}

/// An interval that nobody keeps: refused, or another is granted.
void too_short_interval(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    const auto open =
        open_of(session, usual_plan(*candidate, usual_rpi), [](cip::ForwardOpen& each) { each.t_to_o_rpi = 1; });
    const auto reply = try_open(session, open);
    if (!reply) return;
    if (reply->ok()) {
        const auto grant = cip::ForwardOpenReply::parse(reply->response.data);
        constexpr std::uint32_t possible = 100;
        if (bench.require(grant.has_value(), "the reply cannot be read")) {
            bench.require(grant->t_to_o_api >= possible,
                          fmt::format("an interval of {} us is promised", grant->t_to_o_api));
            bench.advise(false, fmt::format("1 us asked, {} us granted", grant->t_to_o_api));
        }
        return;
    }
    refused(bench, reply, {{0x01, 0x0112}, {0x01, 0x0111}}, {}, Weight::any);
    check_refusal_data(bench, reply, open);
    if (!Code(0x01, 0x0112).matches(reply->response.status)) return;
    const auto wanted = cip::RpiRefusal::from(reply->response.status);
    if (!bench.advise(wanted.has_value(), "the refusal does not tell which intervals are acceptable")) return;
    const bool tells = wanted->t_to_o_kind != cip::RpiKind::acceptable && wanted->t_to_o > 1;
    bench.require(tells, fmt::format("the refusal calls {} us acceptable (kind {})", wanted->t_to_o,
                                     static_cast<int>(wanted->t_to_o_kind)));
}

void duplicate(Bench& bench, const Change& change) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    IoLink link(session, usual_plan(*candidate, usual_rpi));
    if (!link.is_open() || !flows(link, bench)) return;
    auto again = link.request();
    if (change) change(again);
    const auto reply = session.call(open_request(again));
    refused(bench, reply, {{0x01, 0x0100}}, {}, Weight::any);
    check_refusal_data(bench, reply, again);
    flows(link, bench);
}

/// The data of the request as octets.
void refuses_raw(Bench& bench, const std::function<void(cip::Bytes&)>& change, std::initializer_list<Code> right,
                 std::initializer_list<Code> tolerated, bool large = false) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    auto plan = usual_plan(*candidate, usual_rpi);
    plan.large = large;
    auto open = open_of(session, plan);
    auto request = open_request(open);
    change(request.data);
    const auto reply = session.call(request);
    if (large && is_unsupported(reply)) return bench.skip("the device has no Large_Forward_Open");
    refused(bench, reply, right, tolerated, Weight::any);
    if (reply && reply->ok()) static_cast<void>(close_triad(session, open));
}

void refuses_item(Bench& bench, std::initializer_list<std::string_view> addresses, Weight weight = Weight::soft) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    std::vector<enip::Item> items;
    for (const auto address : addresses) items.push_back({enip::ItemType::sockaddr_t_to_o, hex(address)});
    judge(bench, session, open_of(session, usual_plan(*candidate, usual_rpi)), std::move(items), {{0x01, 0x0205}}, {},
          weight);
}

void redundant_owner(Bench& bench) {
    const auto* candidate = harmless(bench);
    if (candidate == nullptr) return;
    if (candidate->kind == Kind::redundant_owner) return bench.skip("the device has redundant owners");
    refuses(
        bench, [](cip::ForwardOpen& open) { open.o_to_t.redundant_owner = true; }, {{0x01, 0x0125}}, {}, Weight::soft);
}

void configuration_data(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    auto plan = usual_plan(*candidate, usual_rpi);
    if (!plan.configuration_instance && !plan.application_path)
        return bench.skip("the connection has no configuration");
    constexpr std::size_t too_many = 64;
    plan.configuration.resize(plan.configuration.size() + too_many);
    judge(bench, session, open_of(session, plan), {}, {{0x01, 0x0126}},
          {{0x01, 0x0129}, {0x01, 0x0315}, {0x01, 0x0118}, 0x15}, Weight::any);
}

void inhibit_above_interval(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    if (!candidate->change_of_state) return bench.skip("the connection knows no change of state");
    auto plan = usual_plan(*candidate, usual_rpi);
    plan.trigger = enip::Trigger::change_of_state;
    plan.inhibit = plan.t_to_o.rpi + std::chrono::milliseconds(5);
    judge(bench, session, open_of(session, plan), {}, {{0x01, 0x011B}}, {}, Weight::soft);
}

void size_without_header(Bench& bench) {
    const auto* candidate = of_kind(bench, Kind::exclusive_owner);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    if (candidate->plan.o_to_t.format != cip::RealTimeFormat::header32)
        return bench.skip("the outputs have no run/idle header");
    const auto open = open_of(session, usual_plan(*candidate, usual_rpi), [](cip::ForwardOpen& each) {
        each.o_to_t.size = static_cast<std::uint16_t>(each.o_to_t.size - cip::run_idle_octets);
    });
    judge(bench, session, open, {}, {{0x01, 0x0127}}, {{0x01, 0x0109}}, Weight::any);
}

void leaves_nothing_behind(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    constexpr int times = 40;
    for (int i = 0; i < times; ++i) {
        const auto reply = try_open(session, open_of(session, usual_plan(*candidate, usual_rpi),
                                                     [](cip::ForwardOpen& open) { open.t_to_o.size = 500; }));
        if (!reply || !bench.require(!reply->ok(), "a wrong size is granted")) return;
    }
    IoLink link(session, usual_plan(*candidate, usual_rpi));
    if (bench.require(link.is_open(), fmt::format("after {} refused opens a right one is refused", times)))
        flows(link, bench);
}

constexpr auto F = Group::forward_open;
constexpr auto R = Manner::reads;
constexpr auto W = Manner::writes;

// clang-format off
constexpr std::array cases{
    Case{"FWR-01", F, "An O->T interval of 0 is refused", "R-CON-17", "Status 0x01, extended status 0x0111.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.o_to_t_rpi = 0; }, {{0x01, 0x0111}}, {{0x01, 0x0112}}); }},
    Case{"FWR-02", F, "A T->O interval of 0 is refused", "R-CON-17", "Status 0x01, extended status 0x0111.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.t_to_o_rpi = 0; }, {{0x01, 0x0111}}, {{0x01, 0x0112}}); }},
    Case{"FWR-03", F, "An interval that nobody keeps is not promised", "R-CON-14", "Extended status 0x0112 tells which intervals are acceptable; or a longer one is granted.", R, too_short_interval},
    Case{"FWR-04", F, "An interval of 71 minutes is refused", "R-CON-17", "Status 0x01, extended status 0x0112 or 0x0111.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.t_to_o_rpi = 0xFFFFFFFF; }, {{0x01, 0x0112}, {0x01, 0x0111}}, {}, Weight::soft); }},
    Case{"FWR-05", F, "An O->T size that is one too large", "R-CON-14", "Extended status 0x0127 and the right size.", R, [](Bench& b) { refuses_size(b, true, 1); }},
    Case{"FWR-06", F, "An O->T size that is one too small", "R-CON-14", "Extended status 0x0127 and the right size.", R, [](Bench& b) { refuses_size(b, true, -1); }},
    Case{"FWR-07", F, "A T->O size that is one too large", "R-CON-14", "Extended status 0x0128 and the right size.", R, [](Bench& b) { refuses_size(b, false, 1); }},
    Case{"FWR-08", F, "A T->O size that is one too small", "R-CON-14", "Extended status 0x0128 and the right size.", R, [](Bench& b) { refuses_size(b, false, -1); }},
    Case{"FWR-09", F, "A T->O size of 0", "R-CON-40", "Extended status 0x0128, or 0x0108.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.t_to_o.size = 0; }, {{0x01, 0x0128}, {0x01, 0x0108}}, {{0x01, 0x0109}}); }},
    Case{"FWR-10", F, "The largest T->O size of the small form", "R-CON-14", "Extended status 0x0128.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.t_to_o.size = 511; }, {{0x01, 0x0128}}, {{0x01, 0x0109}}); }},
    Case{"FWR-11", F, "An O->T point that is not there", "R-CON-40", "Extended status 0x012A; some stacks say 0x012F or 0x0315.", R, [](Bench& b) { refuses_points(b, true, false, {{0x01, 0x012A}}, {{0x01, 0x012F}, {0x01, 0x0315}, {0x01, 0x0117}}); }},
    Case{"FWR-12", F, "A T->O point that is not there", "R-CON-40", "Extended status 0x012B; some stacks say 0x012F or 0x0315.", R, [](Bench& b) { refuses_points(b, false, true, {{0x01, 0x012B}}, {{0x01, 0x012F}, {0x01, 0x0315}, {0x01, 0x0117}}); }},
    Case{"FWR-13", F, "No point is there", "R-CON-40", "Extended status 0x0117, 0x012A or 0x012B.", R, [](Bench& b) { refuses_points(b, true, true, {{0x01, 0x0117}, {0x01, 0x012A}, {0x01, 0x012B}}, {{0x01, 0x012F}, {0x01, 0x0315}}); }},
    Case{"FWR-14", F, "One point is not enough", "R-CON-12", "Extended status 0x012F; other path errors are seen too.", R, [](Bench& b) { refuses_point_count(b, 1, {{0x01, 0x012F}}, {{0x01, 0x0315}, {0x01, 0x0117}, {0x01, 0x012A}, {0x01, 0x0123}}); }},
    Case{"FWR-15", F, "Four points are too many", "R-CON-12", "Extended status 0x0315; other path errors are seen too.", R, [](Bench& b) { refuses_point_count(b, 4, {{0x01, 0x0315}}, {{0x01, 0x012F}, {0x01, 0x0117}, {0x01, 0x0129}}); }},
    Case{"FWR-16", F, "A class that is not there", "R-CON-40", "Extended status 0x0315.", R, [](Bench& b) { refuses_path(b, "20 C7 24 01 2C 65 2C 64", {{0x01, 0x0315}}, {{0x01, 0x0117}, {0x01, 0x012F}, 0x05}); }},
    Case{"FWR-17", F, "A path without a class", "R-CON-40", "Extended status 0x0315.", R, [](Bench& b) { refuses_path(b, "2C 65 2C 64", {{0x01, 0x0315}}, {{0x01, 0x0117}, {0x01, 0x012F}, 0x04, 0x05}); }},
    Case{"FWR-18", F, "An empty path", "R-CON-40", "Extended status 0x0315.", R, [](Bench& b) { refuses_path(b, "", {{0x01, 0x0315}}, {{0x01, 0x0117}, {0x01, 0x012F}, 0x04, 0x05}); }},
    Case{"FWR-19", F, "A symbol that nobody knows", "R-PTH-9", "Extended status 0x0315, or 0x012C to 0x012E.", R, [](Bench& b) { refuses_path(b, "91 05 4E 6F 6E 65 21 00", {{0x01, 0x0315}, {0x01, 0x012C}, {0x01, 0x012D}, {0x01, 0x012E}}, {{0x01, 0x0117}, 0x04, 0x05}); }},
    Case{"FWR-20", F, "A reserved segment", "R-CON-40", "Extended status 0x0315.", R, [](Bench& b) { refuses_more_path(b, "", "E0 01", {{0x01, 0x0315}}, {0x04}); }},
    Case{"FWR-21", F, "A segment that is cut off", "R-CON-40", "Extended status 0x0315.", R, [](Bench& b) { refuses_more_path(b, "", "2D 00", {{0x01, 0x0315}}, {0x04, 0x26, 0x13}); }},
    Case{"FWR-22", F, "An attribute behind the points", "R-CON-40", "Extended status 0x0315.", R, [](Bench& b) { refuses_more_path(b, "", "30 03", {{0x01, 0x0315}}, {{0x01, 0x012F}, 0x04}, Weight::soft); }},
    Case{"FWR-23", F, "A route through a port that is not there", "R-CM-10", "Extended status 0x0311.", R, [](Bench& b) { refuses_more_path(b, "0D 03", "", {{0x01, 0x0311}}, {{0x01, 0x0312}, {0x01, 0x0315}, 0x04}); }},
    Case{"FWR-24", F, "A route to an address where nobody is", "R-CM-10", "Extended status 0x0312.", R, [](Bench& b) { refuses_more_path(b, "01 63", "", {{0x01, 0x0312}}, {{0x01, 0x0311}, {0x01, 0x0315}, 0x04}); }},
    Case{"FWR-25", F, "A reserved O->T type", "R-CON-23", "Extended status 0x0123.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.o_to_t.type = ConnectionType::reserved; }, {{0x01, 0x0123}}, {{0x01, 0x0108}}); }},
    Case{"FWR-26", F, "A reserved T->O type", "R-CON-23", "Extended status 0x0124.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.t_to_o.type = ConnectionType::reserved; }, {{0x01, 0x0124}}, {{0x01, 0x0108}}); }},
    Case{"FWR-27", F, "O->T by multicast", "R-CON-23", "Extended status 0x0123 where it is not there.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.o_to_t.type = ConnectionType::multicast; }, {{0x01, 0x0123}}, {{0x01, 0x0108}, {0x01, 0x0205}}, Weight::soft); }},
    Case{"FWR-28", F, "Multiplier code 8 is reserved", "R-CON-6", "Extended status 0x0133; some stacks do not look.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.timeout_multiplier = 8; }, {{0x01, 0x0133}}, {}, Weight::soft); }},
    Case{"FWR-29", F, "Multiplier code 255 is reserved", "R-CON-6", "Extended status 0x0133; some stacks do not look.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.timeout_multiplier = 255; }, {{0x01, 0x0133}}, {}, Weight::soft); }},
    Case{"FWR-30", F, "Transport class 2 is refused", "R-CON-5", "Extended status 0x0103 or 0x011C.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.transport.transport_class = 2; }, {{0x01, 0x0103}, {0x01, 0x011C}}); }},
    Case{"FWR-31", F, "Transport class 6 is refused", "R-CON-5", "Extended status 0x0103 or 0x011C.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.transport.transport_class = 6; }, {{0x01, 0x0103}, {0x01, 0x011C}}); }},
    Case{"FWR-32", F, "Transport class 15 is refused", "R-CON-5", "Extended status 0x0103 or 0x011C.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.transport.transport_class = 15; }, {{0x01, 0x0103}, {0x01, 0x011C}}); }},
    Case{"FWR-33", F, "Trigger 3 is refused", "R-CON-5", "Extended status 0x0103 or 0x011D.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.transport.trigger = 3; }, {{0x01, 0x0103}, {0x01, 0x011D}}, {}, Weight::soft); }},
    Case{"FWR-34", F, "Trigger 7 is refused", "R-CON-5", "Extended status 0x0103 or 0x011D.", R, [](Bench& b) { refuses(b, [](cip::ForwardOpen& o) { o.transport.trigger = 7; }, {{0x01, 0x0103}, {0x01, 0x011D}}, {}, Weight::soft); }},
    Case{"FWR-35", F, "A connection that is open cannot be opened again", "R-CON-26", "Extended status 0x0100; the open one goes on.", R, [](Bench& b) { duplicate(b, {}); }},
    Case{"FWR-36", F, "A triad that is open stands for one connection", "R-CON-26", "Extended status 0x0100, whatever else is asked for.", R, [](Bench& b) { duplicate(b, [](cip::ForwardOpen& o) { o.t_to_o_rpi *= 2; o.timeout_multiplier = 3; }); }},
    Case{"FWR-37", F, "A Forward_Open of 35 octets", "R-CON-14", "Status 0x13, no extended status.", R, [](Bench& b) { refuses_raw(b, [](cip::Bytes& data) { data.resize(35); }, {0x13}, {{0x01, 0x0315}}); }},
    Case{"FWR-38", F, "A Forward_Open without data", "R-CON-14", "Status 0x13, no extended status.", R, [](Bench& b) { refuses_raw(b, [](cip::Bytes& data) { data.clear(); }, {0x13}, {}); }},
    Case{"FWR-39", F, "A connection path that is longer than the data", "R-CON-14", "Status 0x13, no extended status.", R, [](Bench& b) { refuses_raw(b, [](cip::Bytes& data) { data[35] = static_cast<std::uint8_t>(data[35] + 1); }, {0x13}, {0x26, {0x01, 0x0315}, 0x04}); }},
    Case{"FWR-40", F, "A connection path that is shorter than the data", "R-CON-14", "Status 0x15, no extended status.", R, [](Bench& b) { refuses_raw(b, [](cip::Bytes& data) { data.insert(data.end(), {0x00, 0x00}); }, {0x15}, {{0x01, 0x0315}}); }},
    Case{"FWR-41", F, "A Large_Forward_Open that is cut", "R-CON-14", "Status 0x13, no extended status.", R, [](Bench& b) { refuses_raw(b, [](cip::Bytes& data) { data.resize(39); }, {0x13}, {{0x01, 0x0315}}, true); }},
    Case{"FWR-42", F, "A Large_Forward_Open of the largest size", "R-CON-14", "Extended status 0x0128.", R, [](Bench& b) { refuses_raw(b, [](cip::Bytes& data) { data[34] = 0xFF; data[35] = 0xFF; }, {{0x01, 0x0128}}, {{0x01, 0x0109}, {0x01, 0x0108}}, true); }},
    Case{"FWR-43", F, "A redundant owner where there are none", "R-CON-15", "Extended status 0x0125.", R, redundant_owner},
    Case{"FWR-44", F, "More configuration data than there are", "R-CON-14", "Extended status 0x0126 and the right size.", R, configuration_data},
    Case{"FWR-45", F, "A socket address of another family", "R-CPF-9", "Extended status 0x0205; some stacks do not look.", R, [](Bench& b) { refuses_item(b, {"00 09 08 AE 00 00 00 00 00 00 00 00 00 00 00 00"}); }},
    Case{"FWR-46", F, "A socket address without a port", "R-CPF-9", "Extended status 0x0205; some stacks do not look.", R, [](Bench& b) { refuses_item(b, {"00 02 00 00 00 00 00 00 00 00 00 00 00 00 00 00"}); }},
    Case{"FWR-47", F, "A socket address of eight octets", "R-CPF-9", "Extended status 0x0205; some stacks do not look.", R, [](Bench& b) { refuses_item(b, {"00 02 08 AE 00 00 00 00"}); }},
    Case{"FWR-48", F, "Two socket addresses for one direction", "R-CPF-9", "Extended status 0x0205; some stacks do not look.", R, [](Bench& b) { refuses_item(b, {"00 02 08 AE 00 00 00 00 00 00 00 00 00 00 00 00", "00 02 08 AF 00 00 00 00 00 00 00 00 00 00 00 00"}); }},
    Case{"FWR-49", F, "An inhibit time above the interval", "R-CON-51", "Extended status 0x011B.", R, inhibit_above_interval},
    Case{"FWR-50", F, "A size that forgets the run/idle header", "R-CON-7", "Extended status 0x0127 and the right size.", W, size_without_header},
    Case{"FWR-51", F, "Refused opens leave nothing behind", "R-CON-15", "What is refused holds nothing.", R, leaves_nothing_behind},
};
// clang-format on

}  // namespace

std::span<const Case> refused_open_cases() { return cases; }

}  // namespace servobus::scanner::conformance
