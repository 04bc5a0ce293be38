// Measures messages, memory and class 1 traffic, the latter in the terms of the ODVA performance test documents, beside floors measured in the same run:
// packet interval against the granted one, jitter, drift, action and response latency, throughput, CPU. It reports and
// never fails on a figure; it ends with 3 when it cannot measure at all.
#include <sched.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include "tests/bench/io/roles.hpp"
#include "tests/bench/io/scenarios.hpp"
#include "tests/bench/io/sockets.hpp"

namespace servobus::bench {
namespace {

const std::map<std::string, void (*)(const Settings&, Report&)> parts{
    {"floors", measure_floors},         {"target", measure_target_intervals},
    {"latency", measure_latencies},     {"requests", measure_request_rates},
    {"memory", measure_memory},         {"start", measure_start},
    {"throughput", measure_throughput}, {"originator", measure_originator_intervals},
    {"many", measure_many_drives},
};

/// 127.60.x.1, where x is this process' own as far as a number of processes can tell.
std::uint32_t address_of_this_run() {
    return 127U << 24 | 60U << 16 | (static_cast<std::uint32_t>(::getpid()) & 0xFF) << 8 | 1;
}

int run(int argc, char** argv) {
    Settings settings;
    settings.address = address_of_this_run();
    settings.adapter = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "servobus-adapter";
    std::vector<std::string> chosen{"floors", "target",     "latency",    "requests", "memory",
                                    "start",  "throughput", "originator", "many"};
    std::vector<double> many_ms;
    std::string json;
    int priority = 0;

    CLI::App app("Measures the adapter and the originator over sockets, beside floors.", "servobus_io_bench");
    std::vector<std::string> names = chosen;
    app.add_option("--parts", chosen, "What to measure (all unless given)")
        ->delimiter(',')
        ->check(CLI::IsMember(names));
    app.add_option("--seconds", settings.seconds, "How long each measurement takes (10 unless given)");
    app.add_option("--interval", settings.interval_us, "Packet interval in microseconds (1000 unless given)");
    app.add_option("--load-rate", settings.load_rate, "Attributes a second that the load reads (80000 unless given)");
    app.add_option("--load-attributes", settings.load_attributes, "Of them with each request (1 unless given)");
    app.add_option("--drives", settings.drives, "How many drives `many` and `memory` have (1,7,8,32,128 unless given)")
        ->delimiter(',');
    app.add_option("--rpi", many_ms, "The packet intervals of `many` in ms (1 unless given)")->delimiter(',');
    app.add_option("--adapter", settings.adapter, "The program servobus-adapter");
    app.add_option("--adapter-option", settings.adapter_options, "Handed on to it; may be given again")
        ->allow_extra_args(false);
    app.add_option("--realtime", priority, "Runs all of it, floors too, with this real-time priority (SCHED_FIFO)")
        ->check(CLI::Range(1, 99));
    app.add_option("--json", json, "Writes the figures to this file as well");
    CLI11_PARSE(app, argc, argv);

    if (std::ranges::any_of(settings.drives, [](std::size_t drives) { return drives < 1 || drives > 200; })) {
        give_up("--drives takes 1 to 200 of them, as many as a range of addresses has room for");
    }
    if (!many_ms.empty()) {
        settings.many_intervals_us.clear();
        for (const auto ms : many_ms) settings.many_intervals_us.push_back(static_cast<std::uint32_t>(ms * 1000));
    }
    // Every process of the benchmark inherits it.
    const sched_param realtime{priority};
    if (priority > 0 && ::sched_setscheduler(0, SCHED_FIFO, &realtime) != 0) give_up_errno("--realtime");
    Report report;
    report.set("realtime_priority", priority);
    report.set("seconds", settings.seconds);
    report.set("cores", ::sysconf(_SC_NPROCESSORS_ONLN));
    for (const auto& part : chosen) parts.at(part)(settings, report);
    if (!json.empty() && !(std::ofstream(json) << report.json() << '\n')) give_up("cannot write " + json);
    return 0;
}

}  // namespace
}  // namespace servobus::bench

int main(int argc, char** argv) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    if (words.size() > 1 && words[0] == "--role") return servobus::bench::play({words.begin() + 1, words.end()});
    return servobus::bench::run(argc, argv);
}
