// Every verb of `axis` from the connection to the exit code.
#include <fmt/format.h>

#include <algorithm>

#include "scanner/cli/axis.hpp"
#include "scanner/cli/explicit_axis_link.hpp"
#include "scanner/cli/io.hpp"
#include "scanner/cli/io_axis_link.hpp"
#include "scanner/cli/io_runner.hpp"
#include "scanner/cli/json_output.hpp"
#include "scanner/cli/originator_process_data.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace std::chrono_literals;

/// As people see it move, and not more requests than that needs.
constexpr Time poll_interval = 8ms;
/// A recording shows the axis at rest before and after a motion.
constexpr Time lead = 50ms;
constexpr Time tail = 150ms;
/// Over an I/O connection, when nobody says another.
constexpr std::chrono::microseconds usual_rpi = 4ms;

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

struct Done {
    AxisOutcome outcome;
    std::optional<Failure> unwritten{};
};

ExitCode tell(const Console& console, const AxisOptions& options, const std::string& name, const AxisRunner& runner,
              const Done& done) {
    if (done.outcome.failure) return fail(console, *done.outcome.failure, options.host);
    std::string text = done.outcome.sentence + '\n';
    for (const auto& file : options.traces) text += trace_line(file, runner.samples());
    console.show(text, axis_json(options.host, name, done.outcome, runner, options.traces));
    return done.unwritten ? fail(Console{console.out, console.err}, *done.unwritten, options.host) : ExitCode::done;
}

/// `leave` is called when nothing is to be done with the axis any more.
ExitCode run_over(const Console& console, const AxisOptions& options, const std::string& name, const AxisVerb& verb,
                  const Interruption& interruption, AxisLink& axis,
                  const std::function<void(AxisRunner&, AxisOutcome&)>& leave) {
    const bool recording = !options.traces.empty();
    // The inputs of a connection come at their own rate.
    const auto interval = options.io ? Time(0) : recording ? options.interval : poll_interval;
    AxisRunner runner(console, axis, interruption, interval, recording);
    Done done{perform(runner, options, verb)};
    halt_if_interrupted(runner, done.outcome);
    leave(runner, done.outcome);
    // What went wrong is worth seeing, too.
    const auto title = done.outcome.failure ? done.outcome.failure->text : done.outcome.sentence;
    done.unwritten = write_traces(options, runner.samples(), fmt::format("{} {}: {}", options.host, name, title));
    return tell(console, options, name, runner, done);
}

Parsed<ConnectionTask> axis_task(const AxisOptions& options, const Settings& settings) {
    auto task = make_task(options.connection, settings.route, usual_rpi);
    if (task && !task->has_outputs()) {
        return Mistake{
            fmt::format("an axis cannot be moved over '{}', which has no outputs", options.connection.connection)};
    }
    return task;
}

ExitCode run_over_io(const Console& console, const AxisOptions& options, const std::string& name, const AxisVerb& verb,
                     const Interruption& interruption, Link& link, const Host& host, const ConnectionTask& task) {
    ExplicitAxisLink messages(link);
    auto outputs = read_outputs(link, *task.outputs.layout);
    if (!outputs) return fail(console, outputs.error(), options.host);
    OriginatorProcessData data(link, host, task, std::move(*outputs));
    if (const auto failure = data.open()) {
        const auto code = fail(console, *failure, options.host);
        if (!console.json && data.closed()) console.say(diagnosis_of(*data.closed(), task, options.host, false));
        return code;
    }
    IoAxisLink axis(messages, data);
    return run_over(console, options, name, verb, interruption, axis, [&](AxisRunner& runner, AxisOutcome& outcome) {
        data.close();
        if (outcome.failure || runner.refresh()) return;
        // Its owner is gone, so it stops (docs/motion.md).
        outcome.sentence += fmt::format("; without the connection the drive is {}", situation(runner.state()));
    });
}

}  // namespace

ExitCode run_axis(const Console& console, const Settings& settings, const AxisOptions& options, const std::string& name,
                  const AxisVerb& verb) {
    const auto where = parse_host(options.host);
    if (!where) return fail(console, where.error());
    for (const auto& file : options.traces) {
        if (const auto mistake = check_trace_file(file)) return fail(console, *mistake, options.host);
    }
    const auto task = axis_task(options, settings);
    if (!task) return fail(console, task.error(), options.host);
    const Interruption interruption(console.interruptions);
    Link link(settings, *where);
    if (const auto failure = link.open()) return fail(console, *failure, options.host);
    if (options.io) return run_over_io(console, options, name, verb, interruption, link, *where, *task);
    ExplicitAxisLink axis(link);
    return run_over(console, options, name, verb, interruption, axis, [](AxisRunner&, AxisOutcome&) {});
}

}  // namespace servobus::scanner::cli
