#include <fmt/format.h>

#include <sys/socket.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "enip/encapsulation.hpp"
#include "tests/bench/io/adapter_process.hpp"
#include "tests/bench/io/floors.hpp"
#include "tests/bench/io/image.hpp"
#include "tests/bench/io/link.hpp"
#include "tests/bench/io/scenarios.hpp"

namespace servobus::bench {
namespace {

LinkSettings link_settings(const Settings& settings) {
    return {.target = explicit_endpoint(settings),
            .local_address = settings.own_address(),
            .interval_us = settings.interval_us};
}

/// The receiver of this machine's UDP 2222, without the datagrams of connections that are over.
std::vector<Arrival> only(std::uint32_t connection, std::vector<Arrival> arrivals) {
    std::erase_if(arrivals, [&](const Arrival& each) { return each.connection != connection; });
    return arrivals;
}

SenderRun adapter_sends(const Settings& settings, const Child& adapter) {
    Receiver receiver({settings.own_address(), enip::io_port});
    const Link link(link_settings(settings));
    const auto before = adapter.cpu();
    const auto run = run_io(receiver, link.outlet(), {.seconds = settings.seconds, .interval_us = link.interval_us()});
    const auto spent = static_cast<double>(adapter.cpu() - before) / 1000;
    const auto arrivals = only(link.t_to_o_id(), run.arrivals);
    return {.intervals = Intervals::of(arrivals, link.interval_us()),
            .cpu_us = spent / static_cast<double>(arrivals.size() + run.sent)};
}

// --- latency -------------------------------------------------------------------------------------------------------

Row latency_row(const std::string& what, const std::string& condition, std::vector<double> values) {
    Row row{{"what", what}, {"condition", condition}, {"count", values.size()}};
    put(row, Distribution::of(std::move(values)));
    return row;
}

void add_with_ratio(Row row, const Row& base, Report& report) {
    row["x_floor_p50"] = ratio(row, base, "p50_us");
    row["x_floor_p99"] = ratio(row, base, "p99_us");
    report.add(row);
}

void add_floor(Row row, Report& report) {
    row["x_floor_p50"] = 1;
    row["x_floor_p99"] = 1;
    report.add(row);
}

void measure_responses(const Settings& settings, Report& report) {
    ExplicitClient client(explicit_endpoint(settings));
    const auto frame = client.frame(read_position());
    const auto count = static_cast<std::size_t>(settings.seconds * 1000);
    const auto base = latency_row("TCP ping-pong", "alone", tcp_round_trips(settings, count, frame.size()));
    add_floor(base, report);
    const auto requests = [&] { return timed(count, [&] { static_cast<void>(client.exchange(frame)); }); };
    add_with_ratio(latency_row("response, Get_Attribute_Single", "alone", requests()), base, report);

    Receiver receiver({settings.own_address(), enip::io_port});
    Link link(link_settings(settings));
    std::vector<double> answers;
    std::thread asker([&] { answers = requests(); });
    static_cast<void>(run_io(receiver, link.outlet(), {.seconds = settings.seconds}));
    asker.join();
    add_with_ratio(latency_row("response, Get_Attribute_Single", "beside I/O", std::move(answers)), base, report);
}

std::vector<double> bare_actions(const Settings& settings, const std::string& role) {
    Receiver receiver({settings.own_address(), 0});
    std::vector<std::string> words{role, to_string(enip::Endpoint{settings.address, 0})};
    if (role == "paced-echo") {
        words.push_back(to_string(local_endpoint(receiver.socket())));
        words.push_back(std::to_string(settings.interval_us));
    }
    const auto child = Child::in_role(std::move(words));
    const Outlet outlet{.peer = {settings.address, static_cast<std::uint16_t>(std::stoul(child.first_line()))}};
    return run_io(receiver, outlet, {.seconds = settings.seconds, .dither = true}).action_us;
}

std::vector<double> adapter_actions(const Settings& settings, std::uint8_t trigger) {
    Receiver receiver({settings.own_address(), enip::io_port});
    auto how = link_settings(settings);
    how.trigger = trigger;
    const Link link(how);
    return run_io(receiver, link.outlet(), {.seconds = settings.seconds, .dither = true}).action_us;
}

void measure_actions(const Settings& settings, Report& report) {
    const auto paced = latency_row("bare paced echo", "cyclic", bare_actions(settings, "paced-echo"));
    add_floor(paced, report);
    add_with_ratio(latency_row("action, 103 to 100", "cyclic", adapter_actions(settings, 0)), paced, report);
    const auto echo = latency_row("bare UDP echo", "change of state", bare_actions(settings, "udp-echo"));
    add_floor(echo, report);
    add_with_ratio(latency_row("action, 103 to 100", "change of state", adapter_actions(settings, 1)), echo, report);
}

// --- throughput ----------------------------------------------------------------------------------------------------

/// Frames a second over one TCP connection, `window` of them on their way at a time.
double pipelined(const Descriptor& socket, const cip::Bytes& frame, std::size_t reply_octets, double seconds) {
    constexpr std::size_t window = 64;
    cip::Bytes out;
    for (std::size_t i = 0; i < window; ++i) out.insert(out.end(), frame.begin(), frame.end());
    cip::Bytes in(window * reply_octets);
    const auto begin = monotonic();
    std::size_t done = 0;
    while (static_cast<double>(monotonic() - begin) < seconds * 1e9) {
        send_all(socket, out);
        if (!receive_all(socket, in)) give_up("a connection was closed while requests were on their way");
        done += window;
    }
    return static_cast<double>(done) / (static_cast<double>(monotonic() - begin) / 1e9);
}

void measure_requests(const Settings& settings, const Child& adapter, Report& report) {
    ExplicitClient client(explicit_endpoint(settings));
    const auto frame = client.frame(read_position());
    const auto reply = client.exchange(frame).size();

    const auto echo = Child::in_role({"tcp-echo", to_string(enip::Endpoint{settings.address, 0})});
    const auto socket = tcp_connect({settings.address, static_cast<std::uint16_t>(std::stoul(echo.first_line()))});
    const auto measure = [&](const Child& process, const auto& run) {
        const auto before = process.cpu();
        const auto rate = run();
        const auto cpu = static_cast<double>(process.cpu() - before) / 1000 / (rate * settings.seconds);
        return std::pair(rate, cpu);
    };
    const auto floor = measure(echo, [&] { return pipelined(socket, frame, frame.size(), settings.seconds); });
    const auto product = measure(adapter, [&] { return pipelined(client.socket(), frame, reply, settings.seconds); });
    const auto row = [](const std::string& what, std::pair<double, double> figures, double x_floor) {
        return Row{{"what", what},
                   {"per_second", rounded(figures.first)},
                   {"cpu_us_each", rounded(figures.second)},
                   {"x_floor", rounded(x_floor)}};
    };
    report.add(row("TCP echo, 64 on their way", floor, 1));
    report.add(row("explicit requests, 64 on their way", product, product.first / floor.first));
}

struct Flood {
    double reached = 0;  ///< datagrams a second
    std::size_t dropped = 0;
};

/// Sends `rate` datagrams a second in bursts of a millisecond.
Flood flood(const Descriptor& socket, Outlet& outlet, double rate, double seconds) {
    const auto peer = to_sockaddr(outlet.peer);
    const auto before = dropped(outlet.peer);
    const auto begin = monotonic();
    const auto end = begin + static_cast<Nanoseconds>(seconds * 1e9);
    std::uint64_t sent = 0;
    for (auto next = begin; monotonic() < end; next += second / 1000) {
        sleep_until(next);
        const auto due = static_cast<std::uint64_t>(static_cast<double>(next - begin) / 1e9 * rate);
        for (; sent < due; ++sent) {
            const auto octets = o_to_t(outlet.connection, outlet.first_sequence++, 0);
            ::sendto(socket.number(), octets.data(), octets.size(), 0, reinterpret_cast<const sockaddr*>(&peer),
                     sizeof peer);
        }
    }
    const auto spent = static_cast<double>(monotonic() - begin) / 1e9;
    sleep_until(monotonic() + second / 10);
    return {.reached = static_cast<double>(sent) / spent, .dropped = dropped(outlet.peer) - before};
}

/// The highest of the rates that passes without a loss, and that this program can send.
double highest_rate(const Descriptor& socket, Outlet outlet, double seconds) {
    constexpr double close_enough = 0.95;
    double best = 0;
    for (const double rate : {5e3, 1e4, 2e4, 4e4, 6e4, 8e4, 1e5, 1.5e5, 2e5, 3e5, 4e5}) {
        const auto [reached, lost] = flood(socket, outlet, rate, seconds);
        if (lost > 0 || reached < rate * close_enough) break;
        best = rate;
    }
    return best;
}

void measure_datagrams(const Settings& settings, Report& report) {
    const auto step = std::min(settings.seconds, 2.0);
    const auto sink = Child::in_role({"udp-sink", to_string(enip::Endpoint{settings.address, 0})});
    const auto socket = udp_socket({settings.own_address(), 0});
    const Outlet bare{.peer = {settings.address, static_cast<std::uint16_t>(std::stoul(sink.first_line()))}};
    const auto floor = highest_rate(socket, bare, step);

    Receiver receiver({settings.own_address(), enip::io_port});
    const Link link(link_settings(settings));
    const auto product = highest_rate(receiver.socket(), link.outlet(), step);
    report.add(Row{{"what", "bare receiver, datagrams without a loss"}, {"per_second", floor}, {"x_floor", 1}});
    report.add(Row{{"what", "adapter, O->T datagrams of one connection without a loss"},
                   {"per_second", product},
                   {"x_floor", floor > 0 ? rounded(product / floor) : 0}});
}

}  // namespace

void measure_target_intervals(const Settings& settings, Report& report) {
    report.table(
        "target", fmt::format("Packet interval of T->O, {} us granted in both directions", settings.interval_us),
        "Error of the measured against the granted interval, by the kernel's receive times; CPU is all that the "
        "adapter "
        "did for a datagram in either direction, the load's requests included. The floor is a process that sleeps "
        "to absolute deadlines and sends.");
    const auto adapter = start_adapter(settings);
    const auto run = [&] { return adapter_sends(settings, adapter); };
    compare_with_floors(settings, "adapter", "alone", run, report);
    auto load = start_load(settings);
    compare_with_floors(settings, "adapter", "beside the load", run, report);
    report.add(Row{{"what", "load"},
                   {"attributes_per_second", rounded(stop_load(load))},
                   {"attributes_per_request", settings.load_attributes}});
}

void measure_latencies(const Settings& settings, Report& report) {
    report.table(
        "latency", "Action and response latency",
        "Action: from sending a changed output (DigitalOutputsXENAX of 103) to the first T->O datagram that shows "
        "it (in 100), sent at random times within the interval. Response: an explicit request and its reply. Each "
        "beside the bare row above it.");
    const auto adapter = start_adapter(settings);
    measure_responses(settings, report);
    measure_actions(settings, report);
}

void measure_throughput(const Settings& settings, Report& report) {
    report.table(
        "throughput", "Throughput without a loss",
        "The highest of several rates that this program can send and at which the receiver's socket drops nothing, "
        "and explicit requests one after the other. x_floor is the share of the bare rate above.");
    const auto adapter = start_adapter(settings);
    measure_requests(settings, adapter, report);
    measure_datagrams(settings, report);
}

}  // namespace servobus::bench
