#include "tests/bench/io/floors.hpp"

#include <fmt/format.h>
#include <sys/socket.h>

#include <optional>
#include <thread>

#include "tests/bench/io/child.hpp"
#include "tests/bench/io/io_run.hpp"

namespace servobus::bench {
namespace {

std::string any_port_of(std::uint32_t address) { return to_string(enip::Endpoint{address, 0}); }

enip::Endpoint endpoint_of(const Settings& settings, const Child& role) {
    return {settings.address, static_cast<std::uint16_t>(std::stoul(role.first_line()))};
}

void add_timer(Report& report, const std::string& what, const std::string& condition, const TimerRun& run) {
    Row row{{"what", what + ", late by"}, {"condition", condition}, {"count", run.late_us.size()}};
    put(row, Distribution::of(run.late_us));
    report.add(row);
    Row interval{{"what", what + ", interval error"}, {"condition", condition}, {"count", run.intervals.packets}};
    put(interval, run.intervals.jitter());
    report.add(interval);
}

void add_floors(const Settings& settings, Report& report, const std::string& condition) {
    const RunSettings run{.seconds = settings.seconds, .interval_us = static_cast<double>(settings.interval_us)};
    add_timer(report, "clock_nanosleep", condition, run_timer(TimerKind::nanosleep, run));
    add_timer(report, "timerfd", condition, run_timer(TimerKind::timerfd, run));
    const auto sender = bare_sender(settings, settings.seconds);
    Row row{
        {"what", "paced UDP sender, interval error"}, {"condition", condition}, {"count", sender.intervals.packets}};
    put(row, sender.intervals.jitter());
    report.add(row);
    const auto trips = static_cast<std::size_t>(settings.seconds * 1000);
    Row udp{{"what", "UDP echo, round trip"}, {"condition", condition}, {"count", trips}};
    put(udp, Distribution::of(udp_round_trips(settings, trips, 48)));
    report.add(udp);
    Row tcp{{"what", "TCP ping-pong, round trip"}, {"condition", condition}, {"count", trips}};
    put(tcp, Distribution::of(tcp_round_trips(settings, trips, 48)));
    report.add(tcp);
}

Row ratio_row(const std::string& what, const std::string& condition, const Row& product, const Row& floor) {
    Row result{{"what", what}, {"condition", condition}};
    for (const auto* column : {"p50_us", "p99_us", "p999_us", "max_us"}) result[column] = ratio(product, floor, column);
    return result;
}

}  // namespace

SenderRun bare_sender(const Settings& settings, double seconds) {
    Receiver receiver({settings.own_address(), 0});
    const auto sender =
        Child::in_role({"sender", any_port_of(settings.address), to_string(local_endpoint(receiver.socket())),
                        std::to_string(settings.interval_us), "1"});
    const auto before = sender.cpu();
    const auto run =
        run_io(receiver, std::nullopt, {.seconds = seconds, .interval_us = static_cast<double>(settings.interval_us)});
    SenderRun result{.intervals = Intervals::of(run.arrivals, settings.interval_us)};
    result.cpu_us = static_cast<double>(sender.cpu() - before) / 1000 / static_cast<double>(run.arrivals.size());
    return result;
}

void compare_with_floors(const Settings& settings, const std::string& product, const std::string& condition,
                         const std::function<SenderRun()>& run, Report& report) {
    const auto add = [&](const std::string& what, const SenderRun& figures) {
        auto row = interval_row(what, condition, figures.intervals);
        row["cpu_us_per_packet"] = rounded(figures.cpu_us);
        row["closed"] = figures.closed;
        report.add(row);
        return row;
    };
    auto floor = bare_sender(settings, settings.seconds / 2);
    add("bare sender, before", floor);
    const auto alone = add(product, run());
    const auto after = bare_sender(settings, settings.seconds / 2);
    add("bare sender, after", after);

    SenderRun beside;
    std::thread sender([&] { beside = bare_sender(settings, settings.seconds); });
    const auto together = run();
    sender.join();
    const auto beside_row = add("bare sender, at the same time", beside);
    const auto together_row = add(product + ", at the same time", together);

    floor.intervals.pool(after.intervals);
    const auto base = interval_row("", condition, floor.intervals);
    report.add(ratio_row(product + " / bare sender before and after", condition, alone, base));
    report.add(ratio_row(product + " / bare sender at the same time", condition, together_row, beside_row));
}

std::vector<double> udp_round_trips(const Settings& settings, std::size_t count, std::size_t octets) {
    const auto echo = Child::in_role({"udp-echo", any_port_of(settings.address)});
    const auto socket = udp_socket({settings.own_address(), 0});
    const auto peer = to_sockaddr(endpoint_of(settings, echo));
    if (::connect(socket.number(), reinterpret_cast<const sockaddr*>(&peer), sizeof peer) != 0)
        give_up_errno("connect");
    cip::Bytes data(octets);
    return timed(count, [&] {
        send_all(socket, data);
        static_cast<void>(::recv(socket.number(), data.data(), data.size(), 0));
    });
}

std::vector<double> tcp_round_trips(const Settings& settings, std::size_t count, std::size_t octets) {
    const auto echo = Child::in_role({"tcp-echo", any_port_of(settings.address)});
    const auto socket = tcp_connect(endpoint_of(settings, echo));
    cip::Bytes data(octets);
    return timed(count, [&] {
        send_all(socket, data);
        static_cast<void>(receive_all(socket, data));
    });
}

void measure_floors(const Settings& settings, Report& report) {
    report.table("floors", "Floors",
                 "What bare programs reach on this machine; alone, and beside a process that never sleeps.");
    add_floors(settings, report, "alone");
    const auto busy = Child::in_role({"spin"});
    add_floors(settings, report, "busy core");
}

}  // namespace servobus::bench
