// I/O datagrams and their intervals (R-IO, R-CON-17, R-CON-50).
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "cip/hex.hpp"
#include "enip/encapsulation.hpp"
#include "enip/io_packet.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"
#include "scanner/conformance/io_link.hpp"

namespace servobus::scanner::conformance {
namespace {

using std::chrono::microseconds;
using namespace std::chrono_literals;

constexpr std::size_t some = 20;

template <class Then>
void with_link(Bench& bench, microseconds rpi, Then then, const std::function<void(IoPlan&)>& change = {}) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    auto plan = usual_plan(*candidate, rpi);
    if (change) change(plan);
    IoLink link(session, plan);
    if (link.is_open()) then(*candidate, link);
}

std::vector<Datagram> some_of(Bench& bench, IoLink& link) {
    auto taken = link.run(some, bench.timeout());
    bench.require(taken.size() >= some, fmt::format("{} datagrams came", taken.size()));
    return taken;
}

void form(Bench& bench) {
    with_link(bench, usual_rpi, [&](const Candidate&, IoLink& link) {
        const auto size = link.request().t_to_o.size;
        for (const auto& each : some_of(bench, link)) {
            if (!bench.require(each.data.size() == size || link.request().t_to_o.variable,
                               fmt::format("a data item of {} octets; the connection has {}", each.data.size(), size)))
                return;
            const auto expected = enip::io_packet_overhead + each.data.size();
            if (!bench.advise(each.octets.size() == expected,
                              fmt::format("{} octets behind the data item", each.octets.size() - expected)))
                return;
        }
        bench.require(link.strays() == 0, fmt::format("{} datagrams with another id, or none", link.strays()));
    });
}

void sequence(Bench& bench) {
    with_link(bench, usual_rpi, [&](const Candidate&, IoLink& link) {
        const auto taken = some_of(bench, link);
        // A datagram may be lost on the way, and none may come twice.
        std::size_t gaps = 0;
        for (std::size_t i = 1; i < taken.size(); ++i) {
            const auto step = taken[i].sequence - taken[i - 1].sequence;
            if (!bench.require(step != 0 && step < 0x80000000,
                               fmt::format("sequence number {} behind {}", taken[i].sequence, taken[i - 1].sequence)))
                return;
            if (step != 1) ++gaps;
        }
        constexpr std::size_t few = 2;
        bench.require(gaps <= few,
                      fmt::format("{} of {} sequence numbers do not follow the one before", gaps, taken.size()));
    });
}

void count(Bench& bench) {
    with_link(bench, usual_rpi, [&](const Candidate&, IoLink& link) {
        const auto taken = some_of(bench, link);
        for (std::size_t i = 1; i < taken.size(); ++i) {
            if (taken[i].sequence - taken[i - 1].sequence != 1) continue;
            const auto before = taken[i - 1].count();
            const auto now = taken[i].count();
            if (!before || !now) return;
            const auto step = static_cast<std::uint16_t>(*now - *before);
            const bool same = std::equal(taken[i].data.begin() + 2, taken[i].data.end(), taken[i - 1].data.begin() + 2,
                                         taken[i - 1].data.end());
            if (!bench.require(step <= 1, fmt::format("sequence count {} behind {}", *now, *before))) return;
            if (!bench.require(step == 1 || same, "new data with the sequence count of the old")) return;
        }
    });
}

/// The average over the whole time, from what the kernel has stamped. What a busy machine delays weighs less the longer it
/// takes, a wrong interval does not.
std::optional<double> deviation(const std::vector<Datagram>& taken, microseconds interval) {
    if (taken.size() < 2) return std::nullopt;
    const auto steps = taken.back().sequence - taken.front().sequence;
    if (steps == 0) return std::nullopt;
    const std::chrono::duration<double, std::micro> time = taken.back().time - taken.front().time;
    return time.count() / steps / static_cast<double>(interval.count()) - 1;
}

void keeps_interval(Bench& bench, IoLink& link) {
    constexpr double allowed = 0.02;
    constexpr int windows = 12;
    const auto interval = link.t_to_o_api();
    const auto window = std::max<microseconds>(500ms, 40 * interval);
    std::vector<Datagram> taken;
    std::optional<double> off;
    for (int i = 0; i < windows; ++i) {
        auto more = link.run(window);
        taken.insert(taken.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
        off = deviation(taken, interval);
        if (off && std::abs(*off) <= allowed) break;
    }
    if (!bench.require(off.has_value(), "the inputs do not come")) return;
    bench.note(fmt::format("{} datagrams at {} us: {:+.2f} %", taken.size(), interval.count(), *off * 100));
    bench.require(std::abs(*off) <= allowed,
                  fmt::format("an interval of {} us is promised; on average it is {:.0f} us", interval.count(),
                              static_cast<double>(interval.count()) * (1 + *off)));
}

void keeps(Bench& bench, microseconds rpi) {
    with_link(bench, rpi, [&](const Candidate&, IoLink& link) { keeps_interval(bench, link); });
}

void jitter(Bench& bench) {
    with_link(bench, 10ms, [&](const Candidate&, IoLink& link) {
        const auto taken = link.run(1s);
        std::chrono::nanoseconds longest{0};
        for (std::size_t i = 1; i < taken.size(); ++i)
            longest = std::max<std::chrono::nanoseconds>(longest, taken[i].time - taken[i - 1].time);
        if (!bench.require(taken.size() > 1, "the inputs do not come")) return;
        const auto milli = static_cast<double>(longest.count()) / 1e6;
        bench.note(fmt::format("the longest of {} intervals of 10 ms was {:.2f} ms", taken.size() - 1, milli));
        // The least multiplier ends a connection after four of them.
        bench.advise(longest < 4 * link.t_to_o_api(),
                     fmt::format("an interval of {} us took {:.1f} ms", link.t_to_o_api().count(), milli));
    });
}

void two_intervals(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    if (candidate->owns()) return bench.skip("the device has no connection that can be opened twice");
    IoLink fast(session, usual_plan(*candidate, 10ms));
    IoLink slow(session, usual_plan(*candidate, 30ms));
    if (!fast.is_open() || !slow.is_open()) return;
    keeps_interval(bench, fast);
    keeps_interval(bench, slow);
}

void first_datagram(Bench& bench) {
    with_link(bench, 100ms, [&](const Candidate&, IoLink& link) {
        const auto begin = std::chrono::steady_clock::now();
        const auto taken = link.run(std::size_t{1}, bench.timeout());
        if (!bench.require(!taken.empty(), "the inputs do not come")) return;
        const auto took = std::chrono::duration_cast<milliseconds>(taken.front().time - begin);
        bench.note(fmt::format("the first datagram came after {} ms", took.count()));
        bench.advise(
            took <= link.t_to_o_api() + 100ms,
            fmt::format("the first datagram came {} ms after the reply; the interval is 100 ms", took.count()));
    });
}

void source(Bench& bench) {
    with_link(bench, usual_rpi, [&](const Candidate&, IoLink& link) {
        const auto taken = some_of(bench, link);
        if (taken.empty()) return;
        const auto port = link.grant().target.port;
        bench.advise(
            taken.front().peer.port == port,
            fmt::format("the inputs leave from port {}; outputs are taken at {}", taken.front().peer.port, port));
    });
}

void run_idle_header(Bench& bench) {
    with_link(bench, usual_rpi, [&](const Candidate& candidate, IoLink& link) {
        if (candidate.plan.t_to_o.format != cip::RealTimeFormat::header32)
            return bench.skip("the inputs have no run/idle header");
        for (const auto& each : some_of(bench, link)) {
            cip::Reader reader(each.data);
            reader.take(cip::sequence_count_octets);
            const auto header = reader.u32();
            if (!bench.require(reader.ok() && (header & ~0xFU) == 0,
                               fmt::format("a run/idle header of 0x{:08X}: bits 4 to 31 are reserved", header)))
                return;
        }
    });
}

void on_change(Bench& bench, enip::Trigger trigger, bool Candidate::*feature) {
    const auto* candidate = bench.subject().harmless();
    if (candidate != nullptr && !(candidate->*feature))
        return bench.skip("the connection is not said to have this trigger");
    with_link(
        bench, usual_rpi,
        [&](const Candidate&, IoLink& link) {
            const auto taken = link.run(600ms);
            const auto off = deviation(taken, link.t_to_o_api());
            if (!bench.require(off.has_value(), "the inputs do not come")) return;
            bench.note(
                fmt::format("{} datagrams at {} us: {:+.2f} %", taken.size(), link.t_to_o_api().count(), *off * 100));
            constexpr double allowed = 0.1;
            bench.require(
                *off <= allowed,
                fmt::format(
                    "without a change a datagram comes at each interval of {} us; on average they come {:.0f} % later",
                    link.t_to_o_api().count(), *off * 100));
        },
        [&](IoPlan& plan) { plan.trigger = trigger; });
}

void stray_outputs(Bench& bench) {
    with_link(bench, usual_rpi, [&](const Candidate&, IoLink& link) {
        if (!flows(link, bench)) return;
        // An id that nobody has, a wrong size, an old number: all are dropped, and the inputs go on.
        link.send({.connection_id = link.grant().reply.o_to_t_id ^ 0x00FF0000, .sequence = 1});
        link.send({.data = cip::Bytes(200)});
        link.send({.sequence = link.last_sequence()});
        flows(link, bench);
    });
}

constexpr auto P = Group::production;
constexpr auto R = Manner::reads;

// clang-format off
constexpr std::array cases{
    Case{"PRD-01", P, "A datagram is an address item and a data item", "R-IO-2", "Two items: 0x8002 with id and sequence number, 0x00B1 of the connection's size.", R, form},
    Case{"PRD-02", P, "The sequence number grows by one", "R-IO-5", "The 32-bit number is one more with each datagram.", R, sequence},
    Case{"PRD-03", P, "The sequence count grows with new data", "R-IO-5", "The 16-bit count is one more with new data, and may stay with old.", R, count},
    Case{"PRD-04", P, "An interval of 10 ms is kept", "R-CON-17", "On average within 2 % of what the reply has promised.", R, [](Bench& b) { keeps(b, 10ms); }},
    Case{"PRD-05", P, "An interval of 2 ms is kept", "R-CON-17", "On average within 2 % of what the reply has promised.", R, [](Bench& b) { keeps(b, 2ms); }},
    Case{"PRD-06", P, "An interval of 25 ms is kept", "R-CON-17", "On average within 2 % of what the reply has promised.", R, [](Bench& b) { keeps(b, 25ms); }},
    Case{"PRD-07", P, "An odd interval is kept", "R-CON-17", "On average within 2 % of what the reply has promised: 7.3 ms, or to what it is rounded.", R, [](Bench& b) { keeps(b, 7300us); }},
    Case{"PRD-08", P, "Two connections keep their intervals", "R-CON-17", "Each has an interval of its own.", R, two_intervals},
    Case{"PRD-09", P, "No interval is much too long", "R-CON-50", "What varies is told; four times the interval would end a connection.", R, jitter},
    Case{"PRD-10", P, "The first datagram comes within an interval", "R-CON-50", "The first T->O datagram leaves within one interval of the reply.", R, first_datagram},
    Case{"PRD-11", P, "The inputs leave from the I/O port", "R-IO-11", "From port 2222, or the one that the reply tells.", R, source},
    Case{"PRD-12", P, "The run/idle header is sound", "R-IO-1", "Bit 0 run, bits 1 to 3 ownership, the others 0.", R, run_idle_header},
    Case{"PRD-13", P, "Change of state sends at each interval at the latest", "R-CON-50", "Without a change a datagram is sent at each interval.", R, [](Bench& b) { on_change(b, enip::Trigger::change_of_state, &Candidate::change_of_state); }},
    Case{"PRD-14", P, "The application trigger sends at each interval at the latest", "R-CON-50", "Without a change a datagram is sent at each interval.", R, [](Bench& b) { on_change(b, enip::Trigger::application, &Candidate::application); }},
    Case{"PRD-15", P, "Outputs that do not fit are dropped", "R-IO-7", "Another id, another size, an old number: dropped without effect.", R, stray_outputs},
};
// clang-format on

}  // namespace

std::span<const Case> production_cases() { return cases; }

}  // namespace servobus::scanner::conformance
