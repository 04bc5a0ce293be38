// Connections that nobody keeps alive (R-CON-18 to R-CON-21, R-CON-47).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>

#include "scanner/conformance/attribute.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"
#include "scanner/conformance/class3_link.hpp"
#include "scanner/conformance/io_link.hpp"

namespace servobus::scanner::conformance {
namespace {

using std::chrono::duration_cast;
using std::chrono::microseconds;
using namespace std::chrono_literals;

constexpr std::uint8_t times_4 = 0;
constexpr std::uint8_t times_16 = 2;
constexpr auto vendor_request = "0E 03 20 01 24 01 30 01";

IoPlan short_plan(const Candidate& candidate, microseconds rpi, std::uint8_t multiplier) {
    auto plan = usual_plan(candidate, rpi);
    plan.multiplier_code = multiplier;
    return plan;
}

/// Gone: no inputs any more, and nothing to be closed.
void is_gone(Bench& bench, Session& session, IoLink& link) {
    const auto reply = close_triad(session, link.request());
    link.forget();
    refused(bench, reply, {{0x01, 0x0107}});
}

/// Listens until the inputs stop. False when they do not.
bool starve(Bench& bench, IoLink& link, std::vector<Datagram>& taken) {
    const auto quiet = std::max<microseconds>(4 * link.t_to_o_api(), 200ms);
    return bench.require(link.listen_until_quiet(quiet, 10 * link.timeout() + 3s, taken),
                         fmt::format("the inputs go on {} ms after the last output; the timeout is {} ms",
                                     duration_cast<milliseconds>(10 * link.timeout() + 3s).count(),
                                     duration_cast<milliseconds>(link.timeout()).count()));
}

/// How long the inputs went on after the last output, of the attempt that comes nearest to the truth.
void ends_in_time(Bench& bench, microseconds rpi, std::uint8_t multiplier) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    std::string early;
    for (int attempt = 0; attempt < measuring_attempts; ++attempt) {
        IoLink link(session, short_plan(*candidate, rpi, multiplier));
        if (!link.is_open()) return;
        link.run(std::size_t{3}, bench.timeout());
        link.send();
        std::vector<Datagram> taken;
        if (!starve(bench, link, taken)) return;
        const auto timeout = link.timeout();
        const auto sent = link.last_sent();
        is_gone(bench, session, link);
        const auto lasted = taken.empty() ? microseconds(0) : duration_cast<microseconds>(taken.back().time - sent);
        bench.note(fmt::format("timeout {} ms: the last input came {:.1f} ms after the last output",
                               duration_cast<milliseconds>(timeout).count(),
                               static_cast<double>(lasted.count()) / 1000));
        const bool is_early = lasted < timeout - 2 * link.t_to_o_api();
        early = is_early ? fmt::format("the inputs stop {} ms after the last output; the timeout is {} ms",
                                       duration_cast<milliseconds>(lasted).count(),
                                       duration_cast<milliseconds>(timeout).count())
                         : "";
        const bool is_late = lasted > timeout + timeout / 2 + 300ms;
        if (!is_early) {
            bench.advise(!is_late, fmt::format("the inputs stop {} ms after the last output; the timeout is {} ms",
                                               duration_cast<milliseconds>(lasted).count(),
                                               duration_cast<milliseconds>(timeout).count()));
            return;
        }
    }
    bench.require(false, early);
}

/// A connection that is fed by `feed`, once for each interval, over several timeouts. `alive`: it must go on; otherwise it
/// must end.
void fed(Bench& bench, bool alive, const std::function<void(IoLink&)>& feed, bool firm = true) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    constexpr microseconds rpi = 80ms;
    constexpr int feeds = 20;  // five timeouts of four intervals
    for (int attempt = 0; attempt < measuring_attempts; ++attempt) {
        IoLink link(session, short_plan(*candidate, rpi, times_4));
        if (!link.is_open()) return;
        link.run(std::size_t{3}, bench.timeout());
        std::vector<Datagram> last;
        for (int i = 0; i < feeds; ++i) {
            feed(link);
            last = link.listen(link.o_to_t_api());
        }
        const auto reply = close_triad(session, link.request());
        link.forget();
        if (!reply) return;
        if (reply->ok() == alive) return;
        if (!alive) {
            const std::string words = "the connection is still there after five timeouts";
            firm ? bench.require(false, words) : bench.advise(false, words);
            return;
        }
        bench.note(fmt::format("attempt {}: the connection has ended, with {} inputs in the last interval", attempt + 1,
                               last.size()));
    }
    bench.require(false, "the connection ends although it is fed at its interval");
}

void keeps_alive(Bench& bench) {
    fed(bench, true, [](IoLink& link) { link.send(); });
}

void old_data_keep_alive(Bench& bench) {
    fed(bench, true, [](IoLink& link) { link.send({.count = std::uint16_t{4711}}); });
}

void old_numbers_do_not(Bench& bench) {
    fed(bench, false, [](IoLink& link) { link.send({.sequence = link.last_sequence()}); });
}

void other_ids_do_not(Bench& bench) {
    fed(bench, false, [](IoLink& link) { link.send({.connection_id = link.grant().reply.o_to_t_id ^ 0x00FF0000}); });
}

void other_sizes_do_not(Bench& bench) {
    fed(
        bench, false, [](IoLink& link) { link.send({.data = cip::Bytes(123)}); }, false);
}

void is_counted(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    constexpr Place place{0x06, 1, 8};
    const auto before = read(session, place, Presence::optional);
    if (!before || before->size() != 2) return;
    IoLink link(session, short_plan(*candidate, 20ms, times_4));
    if (!link.is_open()) return;
    link.run(std::size_t{3}, bench.timeout());
    std::vector<Datagram> taken;
    if (!starve(bench, link, taken)) return;
    link.forget();
    const auto after = read(session, place, Presence::required);
    if (!after || after->size() != 2) return;
    bench.advise(*after != *before, "a connection that times out is not counted in attribute 8");
}

/// A connection that starves, and what is so afterwards.
template <class Then>
void after_starving(Bench& bench, const Candidate* candidate, Then then) {
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    IoLink link(session, short_plan(*candidate, 20ms, times_4));
    if (!link.is_open()) return;
    link.run(std::size_t{3}, bench.timeout());
    std::vector<Datagram> taken;
    if (!starve(bench, link, taken)) return;
    link.forget();
    then(session, link);
}

void triad_is_free(Bench& bench) {
    after_starving(bench, harmless(bench), [&](Session& session, IoLink& link) {
        const auto reply = try_open(session, link.request());
        granted(bench, reply);
    });
}

void others_go_on(Bench& bench) {
    const auto* candidate = harmless(bench);
    Session session(bench);
    if (candidate == nullptr || !session.is_open()) return;
    if (candidate->owns()) return bench.skip("the device has no connection that can be opened twice");
    IoLink other(session, usual_plan(*candidate, usual_rpi));
    IoLink link(session, short_plan(*candidate, 20ms, times_4));
    if (!other.is_open() || !link.is_open()) return;
    link.run(std::size_t{3}, bench.timeout());
    other.run(100ms);
    std::vector<Datagram> taken;
    if (!starve(bench, link, taken)) return;
    link.forget();
    flows(other, bench);
}

/// What a case needs while it waits.
struct Waiting {
    explicit Waiting(Bench& bench) : session(bench) {}
    Session session;
    std::unique_ptr<IoLink> io;
    std::unique_ptr<Class3Link> messages;
};

/// Nothing is ever sent: ten seconds of patience, and no more.
void waits_for_first_output(Bench& bench) {
    const auto* candidate = harmless(bench);
    if (candidate == nullptr) return;
    const auto all = std::make_shared<Waiting>(bench);
    if (!all->session.is_open()) return;
    all->io = std::make_unique<IoLink>(all->session, short_plan(*candidate, 100ms, times_4));
    if (!all->io->is_open()) return;
    constexpr milliseconds patient = 8s;
    constexpr milliseconds over = 6s;
    bench.later(patient, [all, &bench, over] {
        auto taken = all->io->listen(milliseconds(1));
        taken = all->io->listen(3 * all->io->t_to_o_api());
        bench.require(!taken.empty(), "the connection ends before ten seconds have passed without an output");
        bench.later(over, [all, &bench] {
            auto rest = all->io->listen(milliseconds(1));
            rest = all->io->listen(5 * all->io->t_to_o_api());
            bench.require(rest.empty(), "the inputs go on fourteen seconds after the reply, and no output has come");
            is_gone(bench, all->session, *all->io);
        });
    });
}

void waits_for_first_request(Bench& bench) {
    const auto all = std::make_shared<Waiting>(bench);
    if (!all->session.is_open()) return;
    all->messages = std::make_unique<Class3Link>(all->session, [](cip::ForwardOpen& open) {
        open.o_to_t_rpi = 100'000;
        open.timeout_multiplier = times_4;
    });
    if (!all->messages->is_open()) return;
    bench.later(5s, [all, &bench] {
        const auto reply = all->messages->call(hex(vendor_request));
        granted(bench, reply);
        if (!reply) all->messages->forget();
    });
}

void messages_time_out(Bench& bench) {
    const auto all = std::make_shared<Waiting>(bench);
    if (!all->session.is_open()) return;
    all->messages = std::make_unique<Class3Link>(all->session, [](cip::ForwardOpen& open) {
        open.o_to_t_rpi = 100'000;
        open.timeout_multiplier = times_4;
    });
    if (!all->messages->is_open() || !granted(bench, all->messages->call(hex(vendor_request)))) return;
    bench.later(2s, [all, &bench] {
        all->messages->expect_silence(hex(vendor_request),
                                      "a request two seconds after the last; the timeout is 400 ms", false);
        const auto reply = close_triad(all->session, all->messages->request());
        all->messages->forget();
        refused(bench, reply, {{0x01, 0x0107}});
    });
}

void ownership_is_free(Bench& bench) {
    const auto* candidate = of_kind(bench, Kind::exclusive_owner);
    after_starving(bench, candidate, [&](Session& session, const IoLink&) {
        IoLink next(session, usual_plan(*candidate, usual_rpi));
        if (next.is_open()) flows(next, bench);
    });
}

void status_tells(Bench& bench) {
    after_starving(bench, of_kind(bench, Kind::exclusive_owner), [&](Session& session, const IoLink&) {
        const auto value = read(session, {0x01, 1, 5}, Presence::required);
        if (!value || value->size() != 2) return;
        const unsigned status = cip::Reader(*value).u16();
        bench.require((status & 1) == 0,
                      fmt::format("the status is 0x{:04X}: bit 0 says owned, and the owner has timed out", status));
        constexpr unsigned faulted = 2;
        const auto extended = status >> 4 & 0xF;
        bench.advise(extended == faulted || extended == 5,
                     fmt::format("the extended device status is {}; 2 is: a connection has timed out", extended));
    });
}

constexpr auto T = Group::timeouts;
constexpr auto R = Manner::reads;
constexpr auto W = Manner::writes;

// clang-format off
constexpr std::array cases{
    Case{"TMO-01", T, "Ten seconds for the first output", "R-CON-19", "Before the first datagram the timeout is ten seconds, or longer; then the connection ends.", R, waits_for_first_output},
    Case{"TMO-02", T, "Ten seconds for the first request", "R-CON-19", "Before the first message of an explicit connection the timeout is ten seconds, or longer.", R, waits_for_first_request},
    Case{"TMO-03", T, "An explicit connection ends without requests", "R-CON-47", "After interval times multiplier without a message it is closed.", R, messages_time_out},
    Case{"TMO-04", T, "A connection ends after four intervals", "R-CON-18", "Neither early nor very late: interval times multiplier after the last output. Then it is gone.", R, [](Bench& b) { ends_in_time(b, 50ms, times_4); }},
    Case{"TMO-05", T, "A connection ends after 16 intervals", "R-CON-18", "Neither early nor very late: interval times multiplier after the last output. Then it is gone.", R, [](Bench& b) { ends_in_time(b, 25ms, times_16); }},
    Case{"TMO-06", T, "Outputs keep a connection alive", "R-CON-20", "Every datagram that fits starts the time again.", R, keeps_alive},
    Case{"TMO-07", T, "Old data keep a connection alive", "R-CON-20", "A datagram with the sequence count of the one before starts the time again.", R, old_data_keep_alive},
    Case{"TMO-08", T, "Old sequence numbers do not", "R-IO-5", "A datagram that is not newer than the last is dropped without effect.", R, old_numbers_do_not},
    Case{"TMO-09", T, "Outputs for others do not", "R-IO-7", "A datagram with another id is dropped without effect.", R, other_ids_do_not},
    Case{"TMO-10", T, "Outputs of another size do not", "R-IO-8", "A datagram of another size is dropped without effect.", R, other_sizes_do_not},
    Case{"TMO-11", T, "A timeout is counted", "R-CM-3", "Attribute 8 of the Connection Manager counts connections that time out.", R, is_counted},
    Case{"TMO-12", T, "The triad is free afterwards", "R-CON-21", "What timed out is gone, and can be opened again.", R, triad_is_free},
    Case{"TMO-13", T, "Others go on", "R-CON-21", "What times out is one connection.", R, others_go_on},
    Case{"TMO-14", T, "Ownership is free afterwards", "R-CON-21", "The next owner is taken at once.", W, ownership_is_free},
    Case{"TMO-15", T, "The status tells of it", "R-ID-4", "Bit 0 is clear; extended device status 2.", W, status_tells},
};
// clang-format on

}  // namespace

std::span<const Case> timeout_cases() { return cases; }

}  // namespace servobus::scanner::conformance
