#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "enip/encapsulation.hpp"
#include "tests/bench/io/adapter_process.hpp"
#include "tests/bench/io/fake_target.hpp"
#include "tests/bench/io/floors.hpp"
#include "tests/bench/io/io_run.hpp"
#include "tests/bench/io/scenarios.hpp"

namespace servobus::bench {
namespace {

Child start_originator(const Settings& settings, std::size_t drives, std::uint32_t interval_us) {
    const auto address = to_string(enip::Endpoint{settings.address, 0});
    return Child::in_role(
        {"originator", address.substr(0, address.find(':')), std::to_string(drives), std::to_string(interval_us)});
}

SenderRun originator_sends(const Settings& settings) {
    FakeTarget target(settings.address);
    auto originator = start_originator(settings, 1, settings.interval_us);
    const auto before = originator.cpu();
    const auto run = run_io(target.receiver(), std::nullopt, {.seconds = settings.seconds});
    SenderRun result{.intervals = Intervals::of(run.arrivals, settings.interval_us)};
    // It also takes a T->O datagram for each.
    result.cpu_us =
        static_cast<double>(originator.cpu() - before) / 1000 / (2.0 * static_cast<double>(run.arrivals.size()));
    const auto said = nlohmann::json::parse(originator.stop(), nullptr, false);
    if (said.is_object()) result.closed = said.value("closed", std::size_t{0});
    return result;
}

/// CPU of one end of as many bare connections, in microseconds for each datagram that it sends or takes.
double bare_fleet_cpu(const Settings& settings, std::size_t drives, std::uint32_t interval_us) {
    constexpr std::uint16_t port = enip::io_port + 1;
    const auto near = to_string(enip::Endpoint{settings.address, port});
    const auto far = to_string(enip::Endpoint{settings.address + (1U << 16), port});
    const auto count = std::to_string(drives);
    const auto interval = std::to_string(interval_us);
    auto one = Child::in_role({"fleet", near, far, count, interval});
    auto other = Child::in_role({"fleet", far, near, count, interval});
    sleep_until(monotonic() + static_cast<Nanoseconds>(settings.seconds / 2 * 1e9));
    const auto spent = static_cast<double>(one.cpu()) / 1000;
    const auto said = nlohmann::json::parse(one.stop(), nullptr, false);
    if (!said.is_object()) give_up("the bare connections have said nothing at their end");
    return spent / (said.at("sent").get<double>() + said.at("received").get<double>());
}

void measure_drives(const Settings& settings, std::size_t drives, std::uint32_t interval_us, Report& report) {
    const auto floor = bare_fleet_cpu(settings, drives, interval_us);
    const auto adapter = start_adapter(settings, drives);
    auto originator = start_originator(settings, drives, interval_us);
    std::size_t drops_before = 0;
    const auto drops = [&] {
        std::size_t result = 0;
        for (std::uint32_t i = 0; i < drives; ++i) result += dropped({settings.address + i, enip::io_port});
        return result;
    };
    drops_before = drops();
    const auto adapter_before = adapter.cpu();
    const auto originator_before = originator.cpu();
    const auto begin = monotonic();
    sleep_until(begin + static_cast<Nanoseconds>(settings.seconds * 1e9));
    const auto adapter_cpu = adapter.cpu() - adapter_before;
    const auto originator_cpu = originator.cpu() - originator_before;
    const auto elapsed = monotonic() - begin;
    const auto lost_at_adapter = drops() - drops_before;
    const auto said = nlohmann::json::parse(originator.stop(), nullptr, false);
    if (!said.is_object()) give_up("the originator has said nothing at its end");

    const auto packets = said.at("sent").get<double>() + said.at("received").get<double>();
    const auto of_a_core = [&](Nanoseconds cpu) {
        return std::round(static_cast<double>(cpu) / static_cast<double>(elapsed) * 1000) / 10;
    };
    Row row{{"drives", drives}, {"interval_us", interval_us}};
    for (const auto* key : {"sent", "received"}) row[key] = said.at(key);
    row["lost T->O"] = said.at("lost");
    row["lost O->T"] = lost_at_adapter;
    for (const auto* key : {"skipped", "stale", "closed"}) row[key] = said.at(key);
    row["least_kept_percent"] = std::round(said.at("least_kept").get<double>() * 1e5) / 1e3;
    for (const auto* key : {"p50", "p99", "p999", "max"})
        row[std::string(key) + "_us"] = rounded(said.at(key).get<double>());
    row["drift_ppm"] =
        said.at("drift_ppm").is_number() ? Row(rounded(said.at("drift_ppm").get<double>())) : Row(nullptr);
    row["adapter_core_percent"] = of_a_core(adapter_cpu);
    row["originator_core_percent"] = of_a_core(originator_cpu);
    const auto each = [&](Nanoseconds cpu) { return static_cast<double>(cpu) / 1000 / packets; };
    row["adapter_cpu_us"] = rounded(each(adapter_cpu));
    row["originator_cpu_us"] = rounded(each(originator_cpu));
    row["floor_cpu_us"] = rounded(floor);
    row["adapter_x_floor"] = rounded(each(adapter_cpu) / floor);
    row["originator_x_floor"] = rounded(each(originator_cpu) / floor);
    report.add(row);
}

}  // namespace

void measure_originator_intervals(const Settings& settings, Report& report) {
    report.table(
        "originator", fmt::format("Packet interval of O->T, {} us granted in both directions", settings.interval_us),
        "As for T->O; the target is a bare receiver and a bare paced sender. The load is that of another adapter "
        "on the same machine.");
    const auto run = [&] { return originator_sends(settings); };
    compare_with_floors(settings, "originator", "alone", run, report);
    auto beside = settings;
    beside.address += 1U << 16;  // 127.61.x.1: the fake target has the other.
    const auto adapter = start_adapter(beside);
    auto load = start_load(beside);
    compare_with_floors(settings, "originator", "beside the load", run, report);
    report.add(Row{{"what", "load"}, {"attributes_per_second", rounded(stop_load(load))}});
}

void measure_many_drives(const Settings& settings, Report& report) {
    report.table(
        "many", "Many drives in one adapter, one originator owns them all",
        "Jitter is that of T->O as the originator takes it, of all connections together; lost O->T are datagrams "
        "dropped at the adapter's sockets. CPU is that of each end for a datagram that it sends or takes; the floor is "
        "one "
        "end of as many bare connections: one system call for all that it sends, one for each socket that takes.");
    for (const auto interval_us : settings.many_intervals_us) {
        for (const auto drives : settings.drives) measure_drives(settings, drives, interval_us, report);
    }
}

}  // namespace servobus::bench
