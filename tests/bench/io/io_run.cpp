#include "tests/bench/io/io_run.hpp"

#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <random>
#include <thread>

#include "tests/bench/io/image.hpp"

namespace servobus::bench {
namespace {

/// Longer than any latency that is measured, so that each change can be told from the one before.
constexpr Nanoseconds between_changes = 20'000'000;

/// Bits 16 to 23 are outputs; 255 values pass before one comes again.
std::uint32_t outputs_of(std::size_t change) { return static_cast<std::uint32_t>(change % 255 + 1) << 16; }

struct Change {
    Nanoseconds time;
    std::uint32_t outputs;
};

class Producer {
public:
    Producer(const Descriptor& socket, const Outlet& outlet, const RunSettings& settings)
        : socket_(socket), outlet_(outlet), peer_(to_sockaddr(outlet.peer)), settings_(settings) {}

    void run() {
        ::prctl(PR_SET_TIMERSLACK, 1);
        const auto interval = static_cast<Nanoseconds>(settings_.interval_us * 1000);
        const auto end = monotonic() + static_cast<Nanoseconds>(settings_.seconds * 1e9);
        std::minstd_rand random(1);
        // Short of a whole interval: no two datagrams closer than a fifth of it (R-CON-52 allows a quarter on average).
        std::uniform_int_distribution<Nanoseconds> offset(0, settings_.dither ? interval * 4 / 5 : 0);
        for (auto next = monotonic(); next < end; next += interval) {
            sleep_until(next + offset(random));
            send();
        }
    }

    std::vector<Change> changes;
    std::uint32_t sent = 0;

private:
    void send() {
        const auto now = monotonic();
        if (now - changed_ >= between_changes) {
            changed_ = now;
            changes.push_back({realtime(), outputs_of(changes.size())});
        }
        const auto octets =
            o_to_t(outlet_.connection, outlet_.first_sequence + sent++, changes.empty() ? 0 : changes.back().outputs);
        ::sendto(socket_.number(), octets.data(), octets.size(), 0, reinterpret_cast<const sockaddr*>(&peer_),
                 sizeof peer_);
    }

    const Descriptor& socket_;
    Outlet outlet_;
    sockaddr_in peer_;
    RunSettings settings_;
    Nanoseconds changed_ = 0;
};

/// Pairs each change with the first arrival that shows it.
std::vector<double> latencies(const std::vector<Change>& changes, const std::vector<Arrival>& arrivals) {
    std::vector<double> result;
    auto from = arrivals.begin();
    for (const auto& change : changes) {
        from = std::find_if(from, arrivals.end(), [&](const Arrival& each) { return each.time >= change.time; });
        const auto until = change.time + between_changes;
        const auto shown = std::find_if(from, arrivals.end(), [&](const Arrival& each) {
            return each.time > until || each.outputs == change.outputs;
        });
        if (shown == arrivals.end() || shown->time > until) continue;
        result.push_back(static_cast<double>(shown->time - change.time) / 1000);
    }
    return result;
}

}  // namespace

IoRun run_io(Receiver& receiver, const std::optional<Outlet>& outlet, const RunSettings& settings) {
    IoRun run;
    run.arrivals.reserve(static_cast<std::size_t>(settings.seconds * 1.1e6 / settings.interval_us) + 1000);
    receiver.drain(run.arrivals);
    run.arrivals.clear();  // What came while nobody measured.
    std::optional<Producer> producer;
    std::thread thread;
    if (outlet) {
        producer.emplace(receiver.socket(), *outlet, settings);
        thread = std::thread([&] { producer->run(); });
    }
    // The kernel writes the times down, so it is enough to come by now and then, and disturb less.
    const auto end = monotonic() + static_cast<Nanoseconds>(settings.seconds * 1e9);
    while (monotonic() < end) {
        sleep_until(monotonic() + 5'000'000);
        receiver.drain(run.arrivals);
    }
    if (producer) {
        thread.join();
        receiver.drain(run.arrivals);
        run.sent = producer->sent;
        run.changes = producer->changes.size();
        run.action_us = latencies(producer->changes, run.arrivals);
    }
    return run;
}

TimerRun run_timer(TimerKind kind, const RunSettings& settings) {
    ::prctl(PR_SET_TIMERSLACK, 1);
    const auto interval = static_cast<Nanoseconds>(settings.interval_us * 1000);
    const auto count = static_cast<std::uint32_t>(settings.seconds * 1e6 / settings.interval_us);
    const auto begin = monotonic() + interval;
    Descriptor timer;
    if (kind == TimerKind::timerfd) {
        timer = Descriptor(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC));
        const itimerspec times{to_timespec(interval), to_timespec(begin)};
        ::timerfd_settime(timer.number(), TFD_TIMER_ABSTIME, &times, nullptr);
    }
    TimerRun run;
    std::vector<Arrival> arrivals;
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto deadline = begin + i * interval;
        if (kind == TimerKind::nanosleep) {
            sleep_until(deadline);
        } else {
            std::uint64_t expired = 0;
            if (::read(timer.number(), &expired, sizeof expired) < 0) give_up_errno("timerfd");
            i += static_cast<std::uint32_t>(expired - 1);
        }
        const auto now = monotonic();
        run.late_us.push_back(static_cast<double>(now - (begin + i * interval)) / 1000);
        arrivals.push_back({now, i, 0, 0});
    }
    run.intervals = Intervals::of(arrivals, settings.interval_us);
    return run;
}

}  // namespace servobus::bench
