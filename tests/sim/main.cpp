// sim: plays scenarios against the adapter and the originator in virtual time. Exit codes: 0 everything holds, 1 an invariant
// is broken, 2 wrong usage or a file that is no scenario.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include "tests/sim/shrink.hpp"
#include "tests/sim/world.hpp"

namespace servobus::sim {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr int holds = 0;
constexpr int broken = 1;
constexpr int wrong_usage = 2;

struct Options {
    std::uint64_t seed = 1;
    std::uint64_t seeds = 1;
    double hours = 1.0 / 60;
    bool hours_given = false;
    bool shrinks = false;
    bool traces = false;
    bool prints = false;
    std::string replay;
};

std::string clock_text(microseconds time) { return fmt::format("{:.6f} s", Seconds(time).count()); }

void print(const Statistics& sum, Seconds real) {
    const auto& [owners, onlookers, listeners, class3, refused, closed, timed_out, taken, stale, foreign, answers,
                 lost] = sum.targets;
    const auto& [io, requests, discovered] = sum.originators;
    const auto& wire = sum.wire;
    fmt::print("  {} events, {:.0f} s simulated in {:.2f} s\n", sum.events, sum.simulated.count(), real.count());
    fmt::print(
        "  lines: {} datagrams sent, {} delivered, {} lost, {} doubled, {} held back; {} TCP connections, {} reset\n",
        wire.sent, wire.delivered, wire.lost, wire.duplicated, wire.reordered, wire.streams, wire.resets);
    fmt::print(
        "  drives: opened for {} owners, {} input only, {} listen only, {} class 3; {} refused, {} closed, {} timed "
        "out\n",
        owners, onlookers, listeners, class3, refused, closed, timed_out);
    fmt::print("  drives: {} datagrams taken, {} stale, {} foreign; {} replies; {} owners lost in motion\n", taken,
               stale, foreign, answers, lost);
    fmt::print("  originators: {} opened, {} timed out; {} inputs, {} datagrams dropped\n", io.opened, io.timed_out,
               io.inputs, io.dropped);
    fmt::print("  originators: {} requests, {} answered, {} timed out, {} aborted; {} found by broadcast\n",
               requests.requests, requests.answered, requests.timed_out, requests.aborted, discovered);
}

void print(const Outcome& outcome, const Scenario& scenario) {
    const auto& text = law(outcome.violation->invariant);
    fmt::print("BROKEN: {} ({})\n  {}\n  seed {}, {} after the beginning\n  {}\n  what was done before:\n", text.name,
               text.rules, text.words, scenario.seed, clock_text(outcome.failed_at), outcome.violation->what);
    for (const auto& line : outcome.last) fmt::print("    {}\n", line);
    fmt::print("  what arrived before:\n");
    for (const auto& line : outcome.arrived) fmt::print("    {}\n", line);
}

std::optional<Failure> play(const Scenario& scenario) {
    const auto outcome = World(scenario).run();
    if (!outcome.violation) return std::nullopt;
    return Failure{outcome.violation->invariant, outcome.failed_at};
}

void shrink_and_print(const Scenario& scenario, const Outcome& outcome) {
    const auto small = shrink(scenario, {outcome.violation->invariant, outcome.failed_at}, play);
    fmt::print("shrunk in {} plays from {} actions to {}; fails {} after the beginning. For `sim --replay`:\n{}",
               small.plays, scenario.actions.size(), small.scenario.actions.size(), clock_text(small.failure.at),
               to_json(small.scenario));
}

/// The exit code.
int run(const Scenario& scenario, const Options& options) {
    const auto began = std::chrono::steady_clock::now();
    const auto trace = [](const std::string& line) { fmt::print("  {}\n", line); };
    World world(scenario);
    const auto outcome = options.traces ? world.run(trace) : world.run();
    const Seconds real = std::chrono::steady_clock::now() - began;
    fmt::print("seed {}: {} drives, {} nodes, {} connections, {} clients, {} actions\n", scenario.seed,
               scenario.drives.size(), scenario.nodes, scenario.connections.size(), scenario.clients.size(),
               scenario.actions.size());
    print(outcome.statistics, real);
    std::fflush(stdout);
    if (!outcome.violation) return holds;
    print(outcome, scenario);
    std::fflush(stdout);
    if (options.shrinks) shrink_and_print(scenario, outcome);
    return broken;
}

microseconds length_of(double hours) {
    return std::chrono::duration_cast<microseconds>(std::chrono::duration<double, std::ratio<3600>>(hours));
}

int replay(const Options& options) {
    std::ifstream file(options.replay);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    std::string mistake;
    auto scenario = from_json(text, mistake);
    if (!file || !scenario) {
        fmt::print(stderr, "sim: {}: {}\n", options.replay, scenario ? "cannot be read" : mistake);
        return wrong_usage;
    }
    if (options.hours_given) scenario->length = length_of(options.hours);
    return run(*scenario, options);
}

int run(const Options& options) {
    if (!options.replay.empty()) return replay(options);
    int worst = holds;
    for (auto seed = options.seed; seed < options.seed + options.seeds; ++seed) {
        const auto scenario = draw(seed, length_of(options.hours));
        if (options.prints) {
            fmt::print("{}", to_json(scenario));
            continue;
        }
        worst = std::max(worst, run(scenario, options));
    }
    return worst;
}

}  // namespace
}  // namespace servobus::sim

int main(int argc, char** argv) {
    servobus::sim::Options options;
    CLI::App app(
        "Plays scenarios against the adapter and the originator in virtual time, and looks at the invariants after "
        "each event.");
    app.add_option("--seed", options.seed, "the scenario that is drawn from this number")->capture_default_str();
    app.add_option("--seeds", options.seeds, "so many seeds, from --seed on")->capture_default_str();
    auto* hours = app.add_option("--hours", options.hours, "how long, in hours of virtual time; a minute unless given");
    app.add_flag("--shrink", options.shrinks, "makes a failing scenario as small as it gets, and prints it");
    app.add_flag("--trace", options.traces, "prints each action when it happens");
    app.add_flag("--print", options.prints, "prints the scenarios and plays none");
    app.add_option("--replay", options.replay, "plays the scenario of this file");
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp& help) {
        return app.exit(help);
    } catch (const CLI::ParseError& error) {
        app.exit(error);
        return servobus::sim::wrong_usage;
    }
    options.hours_given = hours->count() > 0;
    return servobus::sim::run(options);
}
