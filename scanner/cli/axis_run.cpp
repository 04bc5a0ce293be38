// Every verb of `axis` from the connection to the exit code.
#include <fmt/format.h>

#include <algorithm>

#include "scanner/cli/axis.hpp"
#include "scanner/cli/json_output.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace std::chrono_literals;

/// As people see it move, and not more requests than that needs.
constexpr Time poll_interval = 8ms;
/// A recording shows the axis at rest before and after a motion.
constexpr Time lead = 50ms;
constexpr Time tail = 150ms;

AxisOutcome record_only(AxisRunner& runner, const AxisOptions& options) {
    // Ctrl-C ends the recording, and concerns nobody who moves the axis.
    if (runner.watch(options.duration.value_or(1s)) == AxisRunner::End::failed) return {{}, runner.failure(), false};
    return {fmt::format("Recorded {} samples", runner.samples().size()), {}, false};
}

AxisOutcome record_around(AxisRunner& runner, const AxisOptions& options, const AxisVerb& verb) {
    const auto begin = std::chrono::steady_clock::now();
    if (runner.watch(lead) == AxisRunner::End::failed) return {{}, runner.failure(), false};
    auto outcome = verb(runner, options);
    if (outcome.failure || outcome.interrupted) return outcome;
    const auto passed = std::chrono::duration_cast<Time>(std::chrono::steady_clock::now() - begin);
    // Whatever happens now, the verb is done.
    (void)runner.watch(std::max(tail, options.duration.value_or(0s) - passed));
    return outcome;
}

AxisOutcome perform(AxisRunner& runner, const AxisOptions& options, const AxisVerb& verb) {
    if (auto failure = runner.read(planning_values())) return {{}, std::move(*failure), false};
    if (!verb) return record_only(runner, options);
    if (options.traces.empty()) return verb(runner, options);
    return record_around(runner, options, verb);
}

/// How fast it was, which a slow network decides.
std::string trace_line(const std::string& file, const Samples& samples) {
    const double time = samples.size() < 2 ? 0 : samples.back().time - samples.front().time;
    const double apart = samples.size() < 2 ? 0 : 1000 * time / static_cast<double>(samples.size() - 1);
    return fmt::format("{}: {} samples, {:.1f} ms apart\n", file, samples.size(), apart);
}

std::optional<Failure> write_traces(const AxisOptions& options, const Samples& samples, const std::string& title) {
    for (const auto& file : options.traces) {
        if (!write_trace_file(file, samples, title)) {
            return Failure{ExitCode::fault, fmt::format("'{}' could not be written", file)};
        }
    }
    return std::nullopt;
}

void halt_if_interrupted(AxisRunner& runner, AxisOutcome& outcome) {
    if (!outcome.interrupted) return;
    const auto halt = runner.halt();
    outcome.failure = Failure{halt.stands ? ExitCode::interrupted : ExitCode::axis, "interrupted; " + halt.text};
}

}  // namespace

ExitCode run_axis(const Console& console, const Settings& settings, const AxisOptions& options, const std::string& name,
                  const AxisVerb& verb) {
    const auto where = parse_host(options.host);
    if (!where) return fail(console, where.error());
    for (const auto& file : options.traces) {
        if (const auto mistake = check_trace_file(file)) return fail(console, *mistake, options.host);
    }
    const Interruption interruption(console.interruptions);
    Link link(settings, *where);
    if (const auto failure = link.open()) return fail(console, *failure, options.host);
    AxisLink axis(link);
    const bool recording = !options.traces.empty();
    AxisRunner runner(console, axis, interruption, recording ? options.interval : poll_interval, recording);
    auto outcome = perform(runner, options, verb);
    halt_if_interrupted(runner, outcome);

    // What went wrong is worth seeing, too.
    const auto title = outcome.failure ? outcome.failure->text : outcome.sentence;
    const auto unwritten = write_traces(options, runner.samples(), fmt::format("{} {}: {}", options.host, name, title));
    if (outcome.failure) return fail(console, *outcome.failure, options.host);
    std::string text = outcome.sentence + '\n';
    for (const auto& file : options.traces) text += trace_line(file, runner.samples());
    console.show(text, axis_json(options.host, name, outcome, runner, options.traces));
    return unwritten ? fail(Console{console.out, console.err}, *unwritten, options.host) : ExitCode::done;
}

}  // namespace servobus::scanner::cli
