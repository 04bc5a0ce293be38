// `io`: from the options to the statistics at the end.
#include <fmt/format.h>

#include <fstream>
#include <iostream>
#include <memory>

#include "scanner/cli/interruption.hpp"
#include "scanner/cli/io.hpp"
#include "scanner/cli/io_capture.hpp"
#include "scanner/cli/io_output.hpp"
#include "scanner/cli/io_sinks.hpp"

namespace servobus::scanner::cli {
namespace {

/// Everybody who looks on, and the files that they write.
class Audience {
public:
    Audience(const Console& console, const IoArguments& arguments, const ConnectionTask& task, const Host& host)
        : console_(console), arguments_(arguments), task_(task), host_(host) {}

    std::optional<Mistake> gather() {
        const bool csv_to_out = arguments_.csv == "-";
        if (console_.json && csv_to_out) return Mistake{"--json and '--csv -' both want the standard output"};
        if (!arguments_.csv.empty()) {
            if (!csv_to_out && !open(csv_file_, arguments_.csv)) return unwritable(arguments_.csv);
            add(std::make_unique<IoCsv>(csv_to_out ? console_.out : csv_file_, task_));
        }
        if (!arguments_.pcapng.empty()) {
            if (!open(capture_file_, arguments_.pcapng)) return unwritable(arguments_.pcapng);
            add(std::make_unique<IoCapture>(capture_file_, host_.port));
        }
        if (console_.json) add(std::make_unique<IoJsonLines>(console_.out, arguments_.host, task_));
        if (console_.terminal) {
            add(std::make_unique<IoTable>(console_, task_));
        } else {
            add(std::make_unique<IoLines>(console_, task_, console_.json || csv_to_out ? nullptr : &console_.out));
        }
        return std::nullopt;
    }

    [[nodiscard]] std::vector<IoSink*> sinks() const {
        std::vector<IoSink*> list;
        for (const auto& each : sinks_) list.push_back(each.get());
        return list;
    }

    /// The table goes, files are complete. Which one could not be written.
    std::optional<Failure> dismiss() {
        sinks_.clear();
        for (const auto& [stream, name] : {std::pair<std::ofstream&, const std::string&>{csv_file_, arguments_.csv},
                                           {capture_file_, arguments_.pcapng}}) {
            if (!stream.is_open()) continue;
            stream.close();
            if (stream.fail()) return Failure{ExitCode::fault, fmt::format("'{}' could not be written", name)};
        }
        return std::nullopt;
    }

private:
    void add(std::unique_ptr<IoSink> sink) { sinks_.push_back(std::move(sink)); }
    static bool open(std::ofstream& file, const std::string& name) {
        file.open(name, std::ios::binary | std::ios::trunc);
        return file.is_open();
    }
    static Mistake unwritable(const std::string& name) { return {fmt::format("'{}' cannot be written", name)}; }

    const Console& console_;
    const IoArguments& arguments_;
    const ConnectionTask& task_;
    const Host& host_;
    std::ofstream csv_file_;
    std::ofstream capture_file_;
    std::vector<std::unique_ptr<IoSink>> sinks_;
};

/// How it ended: what was never open, and what was lost, is a failure.
std::optional<Failure> ending(const IoRunner& runner, const Host& host, const Settings& settings, bool is_open) {
    if (runner.over()) return failure_of(*runner.over(), host, settings.timeout);
    if (is_open) return std::nullopt;
    return Failure{ExitCode::no_connection,
                   fmt::format("the connection to {} was not open at the end", to_string(host))};
}

struct End {
    std::optional<Failure> failure{};
    std::string diagnosis{};
};

ExitCode tell(const Console& console, const IoArguments& arguments, const IoReport& report, const End& end) {
    const auto code = end.failure ? end.failure->code : ExitCode::done;
    if (console.json) {
        console.out << end_line_json(arguments.host, report, end.failure, end.diagnosis) << std::flush;
    } else if (report.openings > 0) {
        // What is in the table must not be followed by something else.
        if (arguments.csv == "-") {
            console.say(report_text(report));
        } else {
            console.out << report_text(report) << std::flush;
        }
    }
    if (end.failure) console.say(end.failure->text);
    if (!console.json) console.say(end.diagnosis);
    return code;
}

}  // namespace

ExitCode io(const Console& console, const Settings& settings, const IoArguments& arguments) {
    const auto host = parse_host(arguments.host);
    if (!host) return fail(console, host.error());
    auto task = make_task(arguments.connection, settings.route);
    if (!task) return fail(console, task.error(), arguments.host);
    if (const auto refused = enip::asio::apply(arguments.scheduling)) {
        return fail(console, Mistake{*refused}, arguments.host);
    }
    Audience audience(console, arguments, *task, *host);
    if (const auto mistake = audience.gather()) return fail(console, *mistake, arguments.host);
    const Interruption interruption(console.interruptions);
    auto outputs = prepare(*task, settings, *host);
    if (!outputs) {
        (void)audience.dismiss();
        return tell(console, arguments, IoReport(task->plan.t_to_o.rpi), {outputs.error(), {}});
    }
    IoRunner runner(settings, *host, *task, std::move(*outputs), !arguments.no_reopen, audience.sinks());
    const auto begin = std::chrono::steady_clock::now();
    runner.run([&] {
        const auto passed = std::chrono::steady_clock::now() - begin;
        return interruption.count() > 0 || (arguments.duration && passed >= *arguments.duration);
    });
    // Whoever presses Ctrl-C while it opens has not been kept waiting by anything that failed.
    const bool fine = runner.is_open() || interruption.count() > 0;
    runner.close();
    End end;
    end.failure = ending(runner, *host, settings, fine);
    if (runner.over()) {
        const auto& opened = runner.last_opened();
        end.diagnosis = diagnosis_of(*runner.over(), *task, arguments.host, console.json, opened ? &*opened : nullptr,
                                     &runner.report());
    }
    const auto unwritten = audience.dismiss();
    if (!end.failure) end.failure = unwritten;
    return tell(console, arguments, runner.report(), end);
}

}  // namespace servobus::scanner::cli
