// Who owns, who looks on, who only listens (R-CON-28 to R-CON-33, R-ID-3, R-ID-4).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <thread>

#include "scanner/conformance/attribute.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"
#include "scanner/conformance/io_link.hpp"

namespace servobus::scanner::conformance {
namespace {

constexpr Place status_place{0x01, 1, 5};
constexpr unsigned owned_bit = 1;

std::optional<unsigned> identity_status(Session& session) {
    const auto value = read(session, status_place, Presence::required);
    if (!value || value->size() != 2) return std::nullopt;
    return cip::Reader(*value).u16();
}

/// A listener and the input-only connection that goes with it.
struct Pair {
    const Candidate* listener = nullptr;
    const Candidate* companion = nullptr;
};

std::optional<Pair> listening_pair(Bench& bench) {
    const auto& all = bench.subject().options().candidates;
    for (const auto& listener : all) {
        if (listener.kind != Kind::listen_only) continue;
        for (const auto& other : all) {
            if (other.kind == Kind::input_only && other.multicast &&
                other.plan.t_to_o.point == listener.plan.t_to_o.point)
                return Pair{&listener, &other};
        }
    }
    bench.skip("no listen-only connection is known, with an input-only one that sends the same by multicast");
    return std::nullopt;
}

void listens_to_nobody(Bench& bench) {
    const auto* candidate = of_kind(bench, Kind::listen_only);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    const auto open = open_of(session, multicast_plan(*candidate, usual_rpi));
    const auto reply = try_open(session, open);
    refused(bench, reply, {{0x01, 0x0119}});
    check_refusal_data(bench, reply, open);
}

void listens_alone(Bench& bench) {
    const auto pair = listening_pair(bench);
    Session session(bench);
    if (!pair || !session.is_open()) return;
    IoLink owner(session, multicast_plan(*pair->companion, usual_rpi));
    if (!owner.is_open()) return;
    auto plan = multicast_plan(*pair->listener, owner.t_to_o_api());
    plan.t_to_o.type = cip::ConnectionType::point_to_point;
    refused(bench, try_open(session, open_of(session, plan)), {{0x01, 0x0119}}, {{0x01, 0x0124}}, Weight::soft);
}

void listener_ends_with_others(Bench& bench) {
    const auto pair = listening_pair(bench);
    Session session(bench);
    if (!pair || !session.is_open()) return;
    IoLink owner(session, multicast_plan(*pair->companion, usual_rpi));
    if (!owner.is_open() || !flows(owner, bench)) return;
    IoLink listener(session, multicast_plan(*pair->listener, owner.t_to_o_api()));
    if (!listener.is_open() || !flows(listener, bench)) return;
    if (!granted(bench, owner.close())) return;
    listener.listen(std::chrono::milliseconds(5));
    const auto late = listener.run(10 * listener.t_to_o_api());
    bench.require(late.empty(), "the inputs go on for a listener alone");
    const auto reply = close_triad(session, listener.request());
    listener.forget();
    refused(bench, reply, {{0x01, 0x0107}}, {}, Weight::soft);
}

void several_look_on(Bench& bench) {
    const auto* candidate = of_kind(bench, Kind::input_only);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    IoLink first(session, usual_plan(*candidate, usual_rpi));
    IoLink second(session, usual_plan(*candidate, usual_rpi));
    if (!first.is_open() || !second.is_open()) return;
    flows(second, bench);
    flows(first, bench);
}

void looking_on_owns_nothing(Bench& bench) {
    const auto* candidate = of_kind(bench, Kind::input_only);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    const auto before = identity_status(session);
    IoLink link(session, usual_plan(*candidate, usual_rpi));
    if (!link.is_open() || !flows(link, bench)) return;
    const auto status = identity_status(session);
    if (!before || !status) return;
    bench.require((*before & owned_bit) == (*status & owned_bit),
                  fmt::format("the status was 0x{:04X} and is 0x{:04X} with an input-only connection: bit 0 says owned",
                              *before, *status));
}

/// An owner that is open, idle and fed while `then` looks.
template <class Then>
void with_owner(Bench& bench, Then then) {
    const auto* candidate = of_kind(bench, Kind::exclusive_owner);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    IoLink owner(session, usual_plan(*candidate, usual_rpi));
    if (owner.is_open() && flows(owner, bench)) then(session, *candidate, owner);
}

void second_owner(Bench& bench) {
    with_owner(bench, [&](Session& session, const Candidate& candidate, IoLink& owner) {
        const auto open = open_of(session, usual_plan(candidate, usual_rpi));
        const auto reply = try_open(session, open);
        refused(bench, reply, {{0x01, 0x0106}});
        check_refusal_data(bench, reply, open);
        flows(owner, bench);
    });
}

void second_owner_from_elsewhere(Bench& bench) {
    with_owner(bench, [&](Session&, const Candidate& candidate, IoLink& owner) {
        Session other(bench);
        if (!other.is_open()) return;
        const auto open = open_of(other, usual_plan(candidate, usual_rpi),
                                  [](cip::ForwardOpen& each) { each.triad.originator_serial ^= 0x00FF00FF; });
        refused(bench, try_open(other, open), {{0x01, 0x0106}});
        flows(owner, bench);
    });
}

void owner_of_another_point(Bench& bench) {
    with_owner(bench, [&](Session& session, const Candidate& candidate, IoLink& owner) {
        const auto& all = bench.subject().options().candidates;
        const auto other = std::ranges::find_if(all, [&](const Candidate& each) {
            return each.kind == Kind::exclusive_owner && each.plan.o_to_t.point != candidate.plan.o_to_t.point;
        });
        if (other == all.end()) return bench.skip("the device has one output assembly");
        // Some devices have independent outputs.
        refused(bench, try_open(session, open_of(session, usual_plan(*other, usual_rpi))), {{0x01, 0x0106}}, {},
                Weight::soft);
        flows(owner, bench);
    });
}

void looks_on_beside_owner(Bench& bench) {
    with_owner(bench, [&](Session& session, const Candidate&, IoLink& owner) {
        const auto* candidate = of_kind(bench, Kind::input_only);
        if (candidate == nullptr) return;
        IoLink link(session, usual_plan(*candidate, usual_rpi));
        if (!link.is_open()) return;
        flows(link, bench);
        flows(owner, bench);
    });
}

void ownership_ends_with_close(Bench& bench) {
    with_owner(bench, [&](Session& session, const Candidate& candidate, IoLink& owner) {
        if (!granted(bench, owner.close())) return;
        IoLink next(session, usual_plan(candidate, usual_rpi));
        if (next.is_open()) flows(next, bench);
    });
}

void status_tells_owner(Bench& bench) {
    with_owner(bench, [&](Session& session, const Candidate&, IoLink& owner) {
        const auto open = identity_status(session);
        if (!open || !granted(bench, owner.close())) return;
        const auto closed = identity_status(session);
        if (!closed) return;
        bench.require((*open & owned_bit) != 0,
                      fmt::format("the status is 0x{:04X} with an owner: bit 0 is clear", *open));
        bench.require((*closed & owned_bit) == 0,
                      fmt::format("the status is 0x{:04X} without an owner: bit 0 is set", *closed));
    });
}

void status_tells_idle(Bench& bench) {
    with_owner(bench, [&](Session& session, const Candidate& candidate, IoLink&) {
        if (candidate.plan.o_to_t.format != cip::RealTimeFormat::header32)
            return bench.skip("the outputs do not tell run and idle");
        const auto status = identity_status(session);
        if (!status) return;
        const auto extended = *status >> 4 & 0xF;
        constexpr unsigned all_idle = 7;
        bench.advise(extended == all_idle || extended == 5,
                     fmt::format("the extended device status is {}; 7 is: connected, and all idle", extended));
    });
}

void owned_outputs_cannot_be_written(Bench& bench) {
    with_owner(bench, [&](Session& session, const Candidate& candidate, IoLink& owner) {
        if (candidate.plan.application_path) return bench.skip("the connection has a path of its own kind");
        const Place place{0x04, static_cast<std::uint16_t>(candidate.plan.o_to_t.point), 3};
        const auto data = read(session, place, Presence::optional);
        if (!data) return;
        refused(bench, session.call(set_request(place, *data)), {0x0E, 0x08}, {0x10, 0x0C, 0x0F}, Weight::soft);
        flows(owner, bench);
    });
}

constexpr auto O = Group::ownership;
constexpr auto R = Manner::reads;
constexpr auto W = Manner::writes;

// clang-format off
constexpr std::array cases{
    Case{"OWN-01", O, "Nobody listens to nobody", "R-CON-32", "Without another connection listen-only is answered 0x0119.", R, listens_to_nobody},
    Case{"OWN-02", O, "A listener asks for multicast", "R-CON-32", "Point-to-point it is answered 0x0119.", R, listens_alone},
    Case{"OWN-03", O, "A listener ends with the last of the others", "R-CON-32", "When the last other connection ends the inputs stop, and the listener is gone.", R, listener_ends_with_others},
    Case{"OWN-04", O, "Several may look on", "R-CON-31", "Any number of input-only connections, up to the device's limit.", R, several_look_on},
    Case{"OWN-05", O, "Who looks on owns nothing", "R-ID-3", "Bit 0 of the status is about owners.", R, looking_on_owns_nothing},
    Case{"OWN-06", O, "A second owner is refused", "R-CON-30", "Extended status 0x0106; the owner goes on.", W, second_owner},
    Case{"OWN-07", O, "Another originator is refused", "R-CON-30", "Extended status 0x0106; the owner goes on.", W, second_owner_from_elsewhere},
    Case{"OWN-08", O, "An owner of another assembly is refused", "R-CON-30", "One owner of the whole device: extended status 0x0106. Some devices have independent outputs.", W, owner_of_another_point},
    Case{"OWN-09", O, "Others look on beside the owner", "R-CON-31", "Input-only connections do not mind an owner.", W, looks_on_beside_owner},
    Case{"OWN-10", O, "Ownership ends with the connection", "R-CON-37", "After a Forward_Close the next one owns.", W, ownership_ends_with_close},
    Case{"OWN-11", O, "The status tells of the owner", "R-ID-3", "Bit 0 is set while there is an owner.", W, status_tells_owner},
    Case{"OWN-12", O, "The status tells that all are idle", "R-ID-4", "Extended device status 7 with connections that are idle.", W, status_tells_idle},
    Case{"OWN-13", O, "Outputs that are owned cannot be written", "R-ASM-5", "Status 0x0E to a Set_Attribute_Single of the owned assembly.", W, owned_outputs_cannot_be_written},
};
// clang-format on

}  // namespace

std::span<const Case> ownership_cases() { return cases; }

}  // namespace servobus::scanner::conformance
