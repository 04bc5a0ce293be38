#include "tests/bench/io/originator_role.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "assemblies/connection.hpp"
#include "scanner/originator.hpp"
#include "tests/bench/io/sockets.hpp"
#include "tests/bench/io/statistics.hpp"

namespace servobus::bench {
namespace {

using scanner::IoConnection;
using scanner::IoState;

/// What one connection has seen of its T->O datagrams.
struct Seen {
    std::vector<Arrival> arrivals;
    std::size_t closed = 0;
};

class Owners {
public:
    Owners(net::io_context& context, std::uint32_t first, std::size_t count, std::chrono::microseconds interval)
        : originator_(context.get_executor()), interval_(interval), seen_(count) {
        auto plan = scanner::plan_of(*assemblies::find_connection("outputs"));
        plan.o_to_t.rpi = plan.t_to_o.rpi = interval;
        for (std::size_t i = 0; i < count; ++i) connections_.push_back(&add(first, i, plan));
    }

    void open() {
        for (auto* each : connections_) each->open();
    }
    void close() {
        for (auto* each : connections_) each->close();
    }
    [[nodiscard]] bool all(IoState state) const {
        return std::ranges::all_of(connections_, [&](const auto* each) { return each->state() == state; });
    }
    /// What came while not all were open says nothing.
    void forget() {
        for (auto& each : seen_) each = {};
        for (std::size_t i = 0; i < connections_.size(); ++i) before_.emplace_back(counters(i));
    }

    [[nodiscard]] nlohmann::json report() const {
        Intervals pooled;
        std::size_t closed = 0;
        std::uint64_t sent = 0;
        std::uint64_t skipped = 0;
        std::uint64_t lost = 0;
        std::uint64_t stale = 0;
        double least_kept = 1;
        for (std::size_t i = 0; i < seen_.size(); ++i) {
            const auto now = counters(i);
            sent += now.sent - before_[i].sent;
            skipped += now.skipped - before_[i].skipped;
            lost += now.lost - before_[i].lost;
            stale += now.stale - before_[i].stale;
            closed += seen_[i].closed;
            const auto intervals = Intervals::of(seen_[i].arrivals, static_cast<double>(interval_.count()));
            least_kept = std::min(least_kept, intervals.kept);
            pooled.pool(intervals);
        }
        const auto jitter = pooled.jitter();
        return {{"sent", sent},
                {"skipped", skipped},
                {"received", pooled.packets},
                {"lost", lost},
                {"stale", stale},
                {"closed", closed},
                {"least_kept", least_kept},
                {"drift_ppm", pooled.drift_ppm ? nlohmann::json(*pooled.drift_ppm) : nlohmann::json()},
                {"p50", jitter.p50},
                {"p99", jitter.p99},
                {"p999", jitter.p999},
                {"max", jitter.max}};
    }

private:
    struct Counters {
        std::uint64_t sent;
        std::uint64_t skipped;
        std::uint64_t lost;
        std::uint64_t stale;
    };
    [[nodiscard]] Counters counters(std::size_t i) const {
        const auto& sent = connections_[i]->sent();
        const auto& received = connections_[i]->received();
        return {sent.sent, sent.skipped, received.lost, received.stale};
    }

    IoConnection& add(std::uint32_t first, std::size_t i, const scanner::IoPlan& plan) {
        const auto address = static_cast<std::uint32_t>(first + i);
        scanner::IoEvents events;
        events.input = [this, i](const scanner::IoInput& input) {
            const auto time = std::chrono::nanoseconds(input.time.time_since_epoch()).count();
            seen_[i].arrivals.push_back({time, input.sequence, 0, 0});
        };
        events.output = [](std::span<std::uint8_t>) { return true; };
        events.closed = [this, i](const scanner::IoClosed&) { ++seen_[i].closed; };
        return originator_.add({.host = fmt::format("{}.{}.{}.{}", address >> 24, address >> 16 & 0xFF,
                                                    address >> 8 & 0xFF, address & 0xFF),
                                .plan = plan},
                               std::move(events));
    }

    scanner::Originator originator_;
    std::chrono::microseconds interval_;
    std::vector<Seen> seen_;
    std::vector<IoConnection*> connections_;
    std::vector<Counters> before_;
};

bool run_until(net::io_context& context, std::chrono::seconds patience, const auto& condition) {
    const auto end = std::chrono::steady_clock::now() + patience;
    while (!condition() && std::chrono::steady_clock::now() < end) context.run_for(std::chrono::milliseconds(5));
    return condition();
}

}  // namespace

int originator_role(const std::vector<std::string>& words) {
    net::io_context context(1);
    net::signal_set signals(context, SIGTERM);
    Owners owners(context, parse_address(words.at(1)), std::stoul(words.at(2)),
                  std::chrono::microseconds(std::stoll(words.at(3))));
    owners.open();
    if (!run_until(context, std::chrono::seconds(30), [&] { return owners.all(IoState::open); })) {
        give_up("the originator cannot open its connections");
    }
    owners.forget();
    fmt::print("ready\n");
    std::fflush(stdout);

    signals.async_wait([&](const auto&, int) { context.stop(); });
    context.run();
    context.restart();
    const auto report = owners.report();
    owners.close();
    run_until(context, std::chrono::seconds(5), [&] { return owners.all(IoState::closed); });
    fmt::print("{}\n", report.dump());
    return 0;
}

}  // namespace servobus::bench
