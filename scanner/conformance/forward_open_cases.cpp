// Forward_Opens that must be granted (R-CON-1 to R-CON-17).
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "cip/services.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"
#include "scanner/conformance/io_link.hpp"

namespace servobus::scanner::conformance {
namespace {

const std::array no_room{Code{0x02}, Code{0x01, 0x0113}, Code{0x01, 0x011A}};

bool has_no_room(const Reply& reply) {
    return std::ranges::any_of(no_room, [&](const Code& code) { return code.matches(reply.response.status); });
}

/// Must be granted, if there is room.
void must_open(Bench& bench, const std::optional<Reply>& reply, std::string_view what, bool firm = true) {
    if (!reply || reply->ok()) return;
    if (has_no_room(*reply)) return bench.skip("the device has no connection left");
    const auto words = fmt::format("{} refused with {}", what, cip::describe(reply->response.status));
    if (firm) {
        bench.require(false, words);
    } else {
        bench.advise(false, words);
    }
}

void opens_and_flows(Bench& bench, const Candidate& candidate) {
    Session session(bench);
    if (!session.is_open()) return;
    bench.note(fmt::format("the connection '{}'", candidate.name));
    IoLink link(session, usual_plan(candidate, usual_rpi));
    if (link.is_open()) flows(link, bench);
}

void each_of_kind(Bench& bench, Kind kind) {
    if (of_kind(bench, kind) == nullptr) return;
    for (const auto& each : bench.subject().options().candidates) {
        if (each.kind == kind) opens_and_flows(bench, each);
    }
}

void each_listener(Bench& bench) {
    if (of_kind(bench, Kind::listen_only) == nullptr) return;
    bool any = false;
    for (const auto& each : bench.subject().options().candidates) {
        if (each.kind != Kind::listen_only) continue;
        const auto& all = bench.subject().options().candidates;
        const auto companion = std::ranges::find_if(all, [&](const Candidate& other) {
            return other.kind == Kind::input_only && other.multicast &&
                   other.plan.t_to_o.point == each.plan.t_to_o.point;
        });
        if (companion == all.end()) continue;
        any = true;
        Session session(bench);
        if (!session.is_open()) return;
        bench.note(fmt::format("'{}' beside '{}'", each.name, companion->name));
        IoLink owner(session, multicast_plan(*companion, usual_rpi));
        if (!owner.is_open()) return;
        owner.run(std::size_t{1}, bench.timeout());
        auto plan = multicast_plan(each, owner.t_to_o_api());
        IoLink listener(session, plan);
        if (listener.is_open()) flows(listener, bench);
    }
    if (!any) bench.skip("no input-only connection with multicast inputs goes with it");
}

/// Opens what `change` makes of the harmless connection.
void opens(Bench& bench, const Change& change, bool firm = true) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    must_open(bench, try_open(session, open_of(session, usual_plan(*candidate, usual_rpi), change)), "it is", firm);
}

/// Opens a plan that `change` makes of the usual one.
void opens_plan(Bench& bench, const std::function<void(IoPlan&)>& change, bool firm = true) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    auto plan = usual_plan(*candidate, usual_rpi);
    change(plan);
    must_open(bench, try_open(session, open_of(session, plan)), "it is", firm);
}

void large_form(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    auto plan = usual_plan(*candidate, usual_rpi);
    plan.large = true;
    const auto reply = try_open(session, open_of(session, plan));
    if (is_unsupported(reply)) return bench.skip("the device has no Large_Forward_Open");
    must_open(bench, reply, "it is");
}

void multipliers(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    for (std::uint8_t code = 0; code < 8; ++code) {
        auto plan = usual_plan(*candidate, usual_rpi);
        plan.multiplier_code = code;
        must_open(bench, try_open(session, open_of(session, plan)), fmt::format("multiplier code {} is", code));
    }
}

void priorities(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    for (unsigned priority = 0; priority < 4; ++priority) {
        if ((candidate->priorities >> priority & 1) == 0) continue;
        auto plan = usual_plan(*candidate, usual_rpi);
        plan.t_to_o.priority = static_cast<cip::Priority>(priority);
        must_open(bench, try_open(session, open_of(session, plan)), fmt::format("T->O priority {} is", priority));
    }
}

/// Opened where the device is said to have it; elsewhere refused in the right way.
void if_announced(Bench& bench, bool announced, const std::function<void(IoPlan&)>& change,
                  std::initializer_list<Code> right) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    auto plan = usual_plan(*candidate, usual_rpi);
    change(plan);
    const auto reply = try_open(session, open_of(session, plan));
    if (!reply || reply->ok()) return;
    if (announced) return must_open(bench, reply, "it is");
    refused(bench, reply, right, {}, Weight::any);
}

bool announces(Bench& bench, bool Candidate::*feature) {
    const auto* candidate = bench.subject().harmless();
    return candidate != nullptr && candidate->*feature;
}

void other_trigger(Bench& bench, enip::Trigger trigger, bool Candidate::*feature) {
    if_announced(bench, announces(bench, feature), [&](IoPlan& plan) { plan.trigger = trigger; },
                 {{0x01, 0x0103}, {0x01, 0x011D}});
}

void variable_size(Bench& bench) {
    if_announced(bench, announces(bench, &Candidate::variable),
                 [](IoPlan& plan) {
                     plan.o_to_t.variable = true;
                     plan.t_to_o.variable = true;
                 },
                 {{0x01, 0x011F}, {0x01, 0x0120}, {0x01, 0x0127}, {0x01, 0x0128}, {0x01, 0x0108}});
}

/// The usual path with `change` made to each of its logical segments.
void other_path(Bench& bench, const std::function<void(cip::LogicalSegment&)>& change) {
    opens_plan(
        bench,
        [&](IoPlan& plan) {
            auto path = plan.path();
            for (auto& segment : path.segments) {
                if (auto* logical = std::get_if<cip::LogicalSegment>(&segment)) change(*logical);
            }
            plan.application_path = std::move(path);
            plan.configuration.clear();
        },
        false);
}

void class_each_time(Bench& bench) {
    opens_plan(
        bench,
        [](IoPlan& plan) {
            cip::Path path;
            for (auto& segment : plan.path().segments) {
                const auto* logical = std::get_if<cip::LogicalSegment>(&segment);
                const bool point = logical != nullptr && logical->type == cip::LogicalType::connection_point;
                if (point && !plan.application_path)
                    path.segments.emplace_back(cip::logical(cip::LogicalType::class_id, cip::class_id::assembly));
                path.segments.push_back(segment);
            }
            plan.application_path = std::move(path);
            plan.configuration.clear();
        },
        false);
}

/// The Forward_Open with octets of its data changed that are no fields.
void opens_raw(Bench& bench, const std::function<void(cip::Bytes&)>& change) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    auto open = open_of(session, usual_plan(*candidate, usual_rpi));
    auto request = open_request(open);
    change(request.data);
    const auto reply = session.call(request);
    must_open(bench, reply, "it is");
    if (reply && reply->ok()) static_cast<void>(close_triad(session, open));
}

void reply_form(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    IoLink link(session, usual_plan(*candidate, usual_rpi));
    if (!link.is_open()) return;
    const auto& data = link.reply()->response.data;
    const auto& reply = link.grant().reply;
    constexpr std::size_t whole = 26;
    bench.require(data.size() >= whole, fmt::format("{} octets and not 26", data.size()));
    bench.advise(data.size() == whole,
                 fmt::format("an application reply of {} octets", data.size() - std::min(data.size(), whole)));
    bench.require(reply.triad == link.request().triad, "the reply names another connection");
    bench.require(reply.o_to_t_id != 0, "the O->T id is 0");
    if (link.request().t_to_o.type == cip::ConnectionType::point_to_point) {
        bench.require(reply.t_to_o_id == link.request().t_to_o_id,
                      fmt::format("the T->O id is 0x{:08X}; the originator has chosen 0x{:08X}", reply.t_to_o_id,
                                  link.request().t_to_o_id));
    }
}

void intervals(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    IoLink link(session, usual_plan(*candidate, usual_rpi));
    if (!link.is_open()) return;
    const auto check = [&](std::string_view direction, std::uint32_t asked, std::uint32_t got) {
        if (!bench.require(got != 0, fmt::format("an {} interval of 0", direction))) return;
        bench.advise(got == asked, fmt::format("{}: {} us asked, {} us granted", direction, asked, got));
    };
    check("O->T", link.request().o_to_t_rpi, link.grant().reply.o_to_t_api);
    check("T->O", link.request().t_to_o_rpi, link.grant().reply.t_to_o_api);
}

void ids_differ(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open() || candidate->owns()) {
        if (candidate != nullptr && candidate->owns())
            bench.skip("the device has no connection that can be opened twice");
        return;
    }
    std::uint32_t first_id = 0;
    {
        IoLink first(session, usual_plan(*candidate, usual_rpi));
        IoLink second(session, usual_plan(*candidate, usual_rpi));
        if (!first.is_open() || !second.is_open()) return;
        first_id = first.grant().reply.o_to_t_id;
        bench.require(first_id != second.grant().reply.o_to_t_id, "two connections have the same O->T id");
    }
    IoLink third(session, usual_plan(*candidate, usual_rpi));
    if (third.is_open())
        bench.advise(third.grant().reply.o_to_t_id != first_id,
                     "an O->T id is used again as soon as its connection is closed");
}

void many_in_a_row(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    constexpr int times = 40;
    for (int i = 0; i < times; ++i) {
        const auto reply = try_open(session, open_of(session, usual_plan(*candidate, usual_rpi)));
        if (!reply ||
            !bench.require(reply->ok(), fmt::format("connection {} of {} one after the other is refused with {}", i + 1,
                                                    times, cip::describe(reply->response.status))))
            return;
    }
}

constexpr auto F = Group::forward_open;
constexpr auto R = Manner::reads;
constexpr auto W = Manner::writes;

// clang-format off
constexpr std::array cases{
    Case{"FWO-01", F, "Each input-only connection opens", "R-CON-31", "It is granted, and its inputs come.", R, [](Bench& b) { each_of_kind(b, Kind::input_only); }},
    Case{"FWO-02", F, "Each exclusive owner opens", "R-CON-28", "It is granted, and its inputs come; the outputs are idle.", W, [](Bench& b) { each_of_kind(b, Kind::exclusive_owner); }},
    Case{"FWO-03", F, "Each listen-only connection opens", "R-CON-32", "Beside a connection with multicast inputs it is granted, and the same inputs come.", R, each_listener},
    Case{"FWO-04", F, "The large form means the same", "R-CON-2", "Large_Forward_Open differs in two wider fields; where it is not there, 0x08.", R, large_form},
    Case{"FWO-05", F, "Each timeout multiplier is taken", "R-CON-6", "Codes 0 to 7 are 4 to 512.", R, multipliers},
    Case{"FWO-06", F, "Each priority is taken", "R-CON-3", "As the data sheet has them.", R, priorities},
    Case{"FWO-07", F, "Variable sizes are taken, or refused as such", "R-CON-7", "Extended status 0x011F, 0x0120, 0x0127 or 0x0128 where there are none.", R, variable_size},
    Case{"FWO-08", F, "Change of state is taken, or refused as such", "R-CON-5", "Extended status 0x0103 or 0x011D where it is not there.", R, [](Bench& b) { other_trigger(b, enip::Trigger::change_of_state, &Candidate::change_of_state); }},
    Case{"FWO-09", F, "The application trigger is taken, or refused as such", "R-CON-5", "Extended status 0x0103 or 0x011D where it is not there.", R, [](Bench& b) { other_trigger(b, enip::Trigger::application, &Candidate::application); }},
    Case{"FWO-10", F, "A path of 16 bits means the same", "R-CON-10", "Points and instances may have 8 or 16 bits.", R, [](Bench& b) { other_path(b, [](cip::LogicalSegment& each) { each.width = cip::Width::bits16; }); }},
    Case{"FWO-11", F, "Points may be named as instances", "R-CON-10", "Instance and connection point mean the same in front of an assembly.", R, [](Bench& b) { other_path(b, [](cip::LogicalSegment& each) { if (each.type == cip::LogicalType::connection_point) each.type = cip::LogicalType::instance; }); }},
    Case{"FWO-12", F, "The class may stand before each point", "R-CON-10", "It may be repeated.", R, class_each_time},
    Case{"FWO-13", F, "The configuration may be left out", "R-CON-12", "Two paths are O->T and T->O; some stacks insist on three.", R, [](Bench& b) { opens_plan(b, [](IoPlan& plan) { plan.configuration_instance.reset(); }, false); }},
    Case{"FWO-14", F, "The reply has ids, triad and intervals", "R-CON-13", "26 octets; the T->O id is the originator's.", R, reply_form},
    Case{"FWO-15", F, "The interval is the one that was asked for", "R-CON-17", "It is granted as asked; a target that rounds says so in the reply.", R, intervals},
    Case{"FWO-16", F, "Reserved octets do not matter", "R-CON-1", "The three octets behind the multiplier are ignored.", R, [](Bench& b) { opens_raw(b, [](cip::Bytes& data) { data[19] = 0xFF; data[20] = 0xFF; data[21] = 0xFF; }); }},
    Case{"FWO-17", F, "The timeout of the request does not matter", "R-CON-1", "Priority, tick and ticks are not checked.", R, [](Bench& b) { opens_raw(b, [](cip::Bytes& data) { data[0] = 0x07; data[1] = 0xFF; }); }},
    Case{"FWO-18", F, "An O->T id of the originator does not matter", "R-CON-16", "The target chooses the id of what it consumes.", R, [](Bench& b) { opens(b, [](cip::ForwardOpen& open) { open.o_to_t_id = 0xDEADBEEF; }); }},
    Case{"FWO-19", F, "Ids are unique", "R-CON-16", "Each connection has an O->T id of its own.", R, ids_differ},
    Case{"FWO-20", F, "A connection of the server direction opens", "R-CON-5", "Bit 7 of the transport octet does not matter in class 1.", R, [](Bench& b) { opens(b, [](cip::ForwardOpen& open) { open.transport.server = true; }, false); }},
    Case{"FWO-21", F, "Connections that were closed are given back", "R-CON-37", "A Forward_Close frees what the connection had.", R, many_in_a_row},
};
// clang-format on

}  // namespace

std::span<const Case> forward_open_cases() { return cases; }

}  // namespace servobus::scanner::conformance
