// Inputs that go to a group (R-MC, R-CON-33, R-CPF-8).
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "enip/encapsulation.hpp"
#include "scanner/conformance/attribute.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"
#include "scanner/conformance/io_link.hpp"

namespace servobus::scanner::conformance {
namespace {

constexpr std::uint16_t tcp_ip = 0xF5;

/// A case that has an open connection with multicast inputs.
template <class Then>
void with_group(Bench& bench, Then then) {
    const auto* candidate = harmless_multicast(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    IoLink link(session, multicast_plan(*candidate, usual_rpi));
    if (link.is_open()) then(session, *candidate, link);
}

void tells_group(Bench& bench) {
    with_group(bench, [&](Session&, const Candidate&, IoLink& link) {
        const auto& items = link.reply()->items;
        const auto found = std::ranges::find(items, enip::ItemType::sockaddr_t_to_o, &enip::Item::type);
        if (!bench.require(found != items.end(), "the reply does not tell the group")) return;
        const auto address = enip::SocketAddress::parse(found->data);
        if (!bench.require(address.has_value(),
                           fmt::format("the socket address has {} octets and not 16", found->data.size())))
            return;
        constexpr std::uint16_t inet = 2;
        bench.require(address->family == inet, fmt::format("family {}", address->family));
        bench.require(enip::is_multicast(address->address),
                      fmt::format("{} is no multicast address", enip::address_text(address->address)));
        bench.advise(address->port == enip::io_port, fmt::format("port {} and not 2222", address->port));
        bench.advise(std::ranges::all_of(address->zero, [](std::uint8_t octet) { return octet == 0; }),
                     "the eight octets behind the address are not zero");
    });
}

/// What the TCP/IP Interface object says about groups.
struct Allocation {
    bool chosen = false;
    std::uint16_t count = 0;
    std::uint32_t first = 0;
};

std::optional<Allocation> allocation(Session& session) {
    const auto value = read(session, {tcp_ip, 1, 9}, Presence::optional);
    if (!value || value->size() != 8) return std::nullopt;
    cip::Reader reader(*value);
    Allocation allocation;
    allocation.chosen = reader.u8() == 1;
    reader.take(1);
    allocation.count = reader.u16();
    allocation.first = reader.u32();
    return allocation;
}

void group_is_allocated(Bench& bench) {
    with_group(bench, [&](Session& session, const Candidate&, IoLink& link) {
        const auto told = allocation(session);
        if (!told) return;
        const auto group = link.receiver().address;
        const bool inside = group >= told->first && group - told->first < told->count;
        bench.require(inside, fmt::format("the group is {}; allocated are {} from {} on", enip::address_text(group),
                                          told->count, enip::address_text(told->first)));
    });
}

void group_by_algorithm(Bench& bench) {
    with_group(bench, [&](Session& session, const Candidate&, IoLink& link) {
        const auto told = allocation(session);
        const auto interface = read(session, {tcp_ip, 1, 5}, Presence::optional);
        if (!told || !interface || interface->size() < 8) return;
        if (told->chosen) return bench.skip("somebody has chosen the groups");
        cip::Reader reader(*interface);
        const auto address = reader.u32();
        const auto mask = reader.u32();
        const auto host = address & ~mask;
        constexpr std::uint32_t base = 0xEFC00100;
        constexpr std::uint32_t each = 32;
        const auto first = base + ((host - 1) & 0x3FF) * each;
        const auto group = link.receiver().address;
        bench.advise(group >= first && group < first + each,
                     fmt::format("the group is {}; by the algorithm it is one of 32 from {} on",
                                 enip::address_text(group), enip::address_text(first)));
    });
}

void inputs_come(Bench& bench) {
    with_group(bench, [&](Session&, const Candidate&, IoLink& link) { flows(link, bench); });
}

void time_to_live(Bench& bench) {
    with_group(bench, [&](Session& session, const Candidate&, IoLink& link) {
        const auto value = peek(session, {tcp_ip, 1, 8});
        const unsigned expected = value && value->size() == 1 ? (*value)[0] : 1;
        const auto taken = link.run(std::size_t{3}, bench.timeout());
        if (!bench.require(!taken.empty(), "the inputs do not come")) return;
        const unsigned ttl = taken.front().ttl;
        if (ttl == 0) return bench.skip("the system does not tell the TTL of what it receives");
        // A router on the way takes one off.
        bench.require(ttl <= expected, fmt::format("TTL {} came; the device says {}", ttl, expected));
        bench.advise(ttl == expected, fmt::format("TTL {} came; the device says {}", ttl, expected));
    });
}

void target_chooses_id(Bench& bench) {
    with_group(bench, [&](Session&, const Candidate&, IoLink& link) {
        bench.advise(link.grant().reply.t_to_o_id != link.request().t_to_o_id,
                     "the id of a group's inputs is the one that one of its receivers has proposed");
    });
}

void joins(Bench& bench) {
    with_group(bench, [&](Session& session, const Candidate& candidate, IoLink& first) {
        if (candidate.owns()) return bench.skip("the device has no connection that can be opened twice");
        if (!flows(first, bench)) return;
        IoLink second(session, multicast_plan(candidate, first.t_to_o_api()));
        if (!second.is_open()) return;
        bench.require(second.receiver() == first.receiver(),
                      fmt::format("the second receiver is sent to {}, the first to {}",
                                  enip::to_string(second.receiver()), enip::to_string(first.receiver())));
        bench.require(second.grant().reply.t_to_o_id == first.grant().reply.t_to_o_id, "the same inputs have two ids");
        flows(second, bench);
    });
}

void joins_at_another_interval(Bench& bench) {
    with_group(bench, [&](Session& session, const Candidate& candidate, IoLink& first) {
        if (candidate.owns()) return bench.skip("the device has no connection that can be opened twice");
        if (!flows(first, bench)) return;
        auto plan = multicast_plan(candidate, 2 * first.t_to_o_api());
        const auto open = open_of(session, plan);
        const auto reply = try_open(session, open);
        if (!reply) return;
        if (reply->ok()) {
            const auto grant = cip::ForwardOpenReply::parse(reply->response.data);
            const bool another = grant && grant->t_to_o_id != first.grant().reply.t_to_o_id;
            const bool honest = grant && grant->t_to_o_api == first.grant().reply.t_to_o_api;
            bench.require(another || honest, "the same inputs are promised at two intervals");
            return;
        }
        refused(bench, reply, {{0x01, 0x0112}, {0x01, 0x0801}}, {{0x01, 0x0111}}, Weight::any);
        const auto wanted = cip::RpiRefusal::from(reply->response.status);
        if (wanted)
            bench.advise(wanted->t_to_o == first.t_to_o_api().count(),
                         fmt::format("{} us would be acceptable, and {} us is what runs", wanted->t_to_o,
                                     first.t_to_o_api().count()));
    });
}

void goes_on_without_the_first(Bench& bench) {
    with_group(bench, [&](Session& session, const Candidate& candidate, IoLink& first) {
        if (candidate.owns()) return bench.skip("the device has no connection that can be opened twice");
        if (!flows(first, bench)) return;
        IoLink second(session, multicast_plan(candidate, first.t_to_o_api()));
        if (!second.is_open() || !granted(bench, first.close())) return;
        flows(second, bench);
    });
}

void stops_with_the_last(Bench& bench) {
    with_group(bench, [&](Session&, const Candidate&, IoLink& link) {
        if (!flows(link, bench) || !granted(bench, link.close())) return;
        link.listen(std::chrono::milliseconds(5));
        const auto late = link.listen(10 * link.t_to_o_api());
        bench.require(late.empty(),
                      fmt::format("{} datagrams came to the group after the reply to the Forward_Close", late.size()));
    });
}

void one_by_one_beside(Bench& bench) {
    with_group(bench, [&](Session& session, const Candidate& candidate, IoLink& group) {
        if (candidate.owns() || !candidate.point_to_point)
            return bench.skip("the device has no connection that can be opened both ways");
        if (!flows(group, bench)) return;
        IoLink alone(session, usual_plan(candidate, usual_rpi));
        if (!alone.is_open()) return;
        flows(alone, bench);
        flows(group, bench);
    });
}

constexpr auto M = Group::multicast;
constexpr auto R = Manner::reads;

// clang-format off
constexpr std::array cases{
    Case{"MCA-01", M, "The reply tells the group", "R-CPF-8", "A socket address T->O: family 2, a multicast address, port 2222.", R, tells_group},
    Case{"MCA-02", M, "The group is among those of the device", "R-MC-2", "Attribute 9 of TCP/IP has the first address and the number.", R, group_is_allocated},
    Case{"MCA-03", M, "The group follows from the address", "R-MC-1", "239.192.1.0 and 32 for each host; unless somebody has chosen the groups.", R, group_by_algorithm},
    Case{"MCA-04", M, "The inputs come to the group", "R-MC-3", "One group for each producing point.", R, inputs_come},
    Case{"MCA-05", M, "The TTL is the one of the device", "R-TCP-8", "Attribute 8 of TCP/IP, 1 where it is not there.", R, time_to_live},
    Case{"MCA-06", M, "The device chooses the id", "R-CON-16", "The producer chooses the id of multicast inputs.", R, target_chooses_id},
    Case{"MCA-07", M, "A second receiver joins", "R-CON-33", "The same id and the same group.", R, joins},
    Case{"MCA-08", M, "A second receiver takes the interval that there is", "R-CON-33", "Another is answered 0x0112 with the one that runs; or the one that runs is granted.", R, joins_at_another_interval},
    Case{"MCA-09", M, "The inputs go on without the first receiver", "R-CON-33", "When the first closes the others go on.", R, goes_on_without_the_first},
    Case{"MCA-10", M, "The inputs stop with the last receiver", "R-CON-37", "No datagram leaves after the reply to the last Forward_Close.", R, stops_with_the_last},
    Case{"MCA-11", M, "A point-to-point connection has a stream of its own", "R-CON-33", "Beside a group it gets its own datagrams.", R, one_by_one_beside},
};
// clang-format on

}  // namespace

std::span<const Case> multicast_cases() { return cases; }

}  // namespace servobus::scanner::conformance
