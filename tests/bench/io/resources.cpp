// What a process costs before it does anything: memory, and the time until it answers.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <vector>

#include "tests/bench/io/adapter_process.hpp"
#include "tests/bench/io/link.hpp"
#include "tests/bench/io/scenarios.hpp"

namespace servobus::bench {
namespace {

/// A line of /proc/PID/status, in KiB.
double status_kib(const Child& child, const std::string& name) {
    std::ifstream status(fmt::format("/proc/{}/status", child.id()));
    for (std::string word; status >> word;) {
        double value = 0;
        if (word == name + ":" && status >> value) return value;
    }
    give_up("the system does not tell " + name);
}

double resident_kib(const Child& child) { return status_kib(child, "VmRSS"); }

constexpr std::size_t sessions = 64;
constexpr std::size_t starts = 15;

Row memory_row(const std::string& what, double kib) { return {{"what", what}, {"kib", rounded(kib)}}; }

double start_ms(const std::function<Child()>& start) {
    std::vector<double> times;
    for (std::size_t i = 0; i < starts; ++i) {
        const auto begin = monotonic();
        const auto child = start();
        times.push_back(static_cast<double>(monotonic() - begin) / 1e6);
    }
    std::ranges::sort(times);
    return times[times.size() / 2];
}

}  // namespace

void measure_memory(const Settings& settings, Report& report) {
    report.table("memory", "Memory",
                 "Resident, of the whole process with its libraries. Of sessions, connections and further drives: by "
                 "how much it "
                 "has grown, for each.");
    const auto bare = Child::in_role({"tcp-reply", to_string(enip::Endpoint{settings.address, 0}), "64", "64"});
    report.add(memory_row("bare server (this program)", resident_kib(bare)));
    const auto adapter = start_adapter(settings);
    const auto one = resident_kib(adapter);
    report.add(memory_row("one drive", one));
    report.add(memory_row("one drive, without what is mapped from files", status_kib(adapter, "RssAnon")));
    {
        std::vector<ExplicitClient> clients;
        for (std::size_t i = 0; i < sessions; ++i) clients.emplace_back(explicit_endpoint(settings));
        report.add(memory_row("each session", (resident_kib(adapter) - one) / sessions));
    }
    {
        const auto before = resident_kib(adapter);
        const Link link({.target = explicit_endpoint(settings), .local_address = settings.own_address()});
        report.add(memory_row("an I/O connection with its session", resident_kib(adapter) - before));
    }
    Settings many = settings;
    many.address += 256;
    const auto further = std::ranges::max(settings.drives);
    const auto fleet = start_adapter(many, further + 1);
    report.add(memory_row(fmt::format("each of {} further drives", further),
                          (resident_kib(fleet) - one) / static_cast<double>(further)));
}

void measure_start(const Settings& settings, Report& report) {
    report.table("start", "Start",
                 fmt::format("From the start of the process to its first answer, the median of {}.", starts));
    const auto bare = start_ms([&] {
        return Child::in_role({"tcp-reply", to_string(enip::Endpoint{settings.address, 0}), "64", "64"});
    });
    const auto adapter = start_ms([&] { return start_adapter(settings); });
    report.add({{"what", "bare server"}, {"ms", rounded(bare)}, {"x_floor", 1}});
    report.add({{"what", "adapter"}, {"ms", rounded(adapter)}, {"x_floor", rounded(adapter / bare)}});
}

}  // namespace servobus::bench
