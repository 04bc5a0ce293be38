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

void measure_drives(const Settings& settings, std::uint32_t interval_us, Report& report) {
    const auto adapter = start_adapter(settings, settings.drives);
    auto originator = start_originator(settings, settings.drives, interval_us);
    std::size_t drops_before = 0;
    const auto drops = [&] {
        std::size_t result = 0;
        for (std::uint32_t i = 0; i < settings.drives; ++i) result += dropped({settings.address + i, enip::io_port});
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
    Row row{{"drives", settings.drives}, {"interval_us", interval_us}};
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
    row["cpu_us_per_packet"] = rounded(static_cast<double>(adapter_cpu + originator_cpu) / 1000 / packets);
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
        "dropped at the adapter's sockets.");
    for (const auto interval_us : settings.many_intervals_us) measure_drives(settings, interval_us, report);
}

}  // namespace servobus::bench
