// `open`: does this connection work, and if not, why.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "scanner/cli/interruption.hpp"
#include "scanner/cli/io.hpp"
#include "scanner/cli/io_output.hpp"

namespace servobus::scanner::cli {
namespace {

using Json = nlohmann::ordered_json;

std::string well_text(const ConnectionTask& task, const Host& host, const IoOpened& opened, const IoReport& report) {
    return fmt::format("All is well: {} opened the connection, and its first datagram came after {:.1f} ms\n",
                       to_string(host), report.first_input->count() * 1000) +
           opened_text(task, opened);
}

std::string document(const std::string& host, const ConnectionTask& task, const std::optional<IoOpened>& opened,
                     const IoReport& report, const std::optional<Failure>& failure, const std::string& diagnosis) {
    Json json{{"host", host}};
    if (opened) {
        json["opened"] = Json::parse(opened_line_json(host, task, *opened));
        json["opened"].erase("event");
        json["opened"].erase("host");
    }
    json["first_input_ms"] = report.first_input ? Json(report.first_input->count() * 1000) : Json();
    if (failure) {
        json["error"] = {{"kind", std::string(row_of(failure->code).kind)},
                         {"text", failure->text},
                         {"exit_code", static_cast<int>(failure->code)}};
        if (failure->status) {
            json["error"]["general"] = static_cast<int>(failure->status->general);
            json["error"]["extended"] = failure->status->extended;
        }
    }
    if (!diagnosis.empty()) json["diagnosis"] = Json::parse(diagnosis, nullptr, false);
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace

ExitCode open(const Console& console, const Settings& settings, const IoArguments& arguments) {
    const auto host = parse_host(arguments.host);
    if (!host) return fail(console, host.error());
    auto task = make_task(arguments.connection, settings.route);
    if (!task) return fail(console, task.error(), arguments.host);
    // It is only looked whether it works: nothing is to happen in the device.
    task->run = false;
    const Interruption interruption(console.interruptions);
    auto outputs = prepare(*task, settings, *host);
    if (!outputs) return fail(console, outputs.error(), arguments.host);
    IoRunner runner(settings, *host, *task, std::move(*outputs), false, {});
    runner.run([&] { return runner.report().first_input.has_value() || interruption.count() > 0; });
    runner.close();

    const auto& report = runner.report();
    const auto& opened = runner.last_opened();
    std::optional<Failure> failure;
    std::string diagnosis;
    if (runner.over()) {
        failure = failure_of(*runner.over(), *host, settings.timeout);
        diagnosis =
            diagnosis_of(*runner.over(), *task, arguments.host, console.json, opened ? &*opened : nullptr, &report);
    } else if (!report.first_input) {
        failure = Failure{ExitCode::interrupted, "interrupted before the first datagram"};
    }
    console.show(failure ? std::string() : well_text(*task, *host, *opened, report),
                 console.json ? document(arguments.host, *task, opened, report, failure, diagnosis) : std::string());
    if (!failure) return ExitCode::done;
    console.say(failure->text);
    if (!console.json) console.say(diagnosis);
    return failure->code;
}

}  // namespace servobus::scanner::cli
