// Where the doctor is asked about a connection that did not open, or that was silent.
#include <nlohmann/json.hpp>

#include "scanner/cli/diagnosis_output.hpp"
#include "scanner/cli/io.hpp"
#include "scanner/open_doctor.hpp"

namespace servobus::scanner::cli {
namespace {

IoTraffic traffic_of(const IoOpened& opened, const IoReport& report) {
    IoTraffic traffic;
    traffic.o_to_t_api = opened.reply.o_to_t_api;
    traffic.t_to_o_api = opened.reply.t_to_o_api;
    traffic.o_to_t.packets = report.sent;
    traffic.t_to_o.packets = report.received.counters().packets;
    traffic.t_to_o.lost = report.received.counters().lost;
    traffic.t_to_o.longest_interval = report.received.longest_silence();
    traffic.receiver = opened.receiver;
    traffic.observed = std::chrono::duration_cast<std::chrono::nanoseconds>(report.open_for);
    return traffic;
}

std::optional<Diagnosis> ask_doctor(const OpenQuestion& question, const IoClosed& closed, const IoOpened* opened,
                                    const IoReport* report) {
    switch (closed.reason) {
        case CloseReason::refused:
            return diagnose_refusal(question, closed.status);
        case CloseReason::bad_reply:
            return diagnose_bad_reply(question);
        case CloseReason::unreachable:
            // Without a request it has not come to that, and the error says what is wrong.
            if (closed.request && closed.error == make_error_code(Error::timeout)) return diagnose_silence(question);
            return std::nullopt;
        case CloseReason::timed_out:
            // What once flowed was opened as it should be.
            if (opened == nullptr || report == nullptr || report->received.counters().packets > 0) return std::nullopt;
            return diagnose_traffic(question, traffic_of(*opened, *report));
        case CloseReason::asked:
        case CloseReason::no_socket:
            return std::nullopt;
    }
    return std::nullopt;
}

}  // namespace

std::string diagnosis_of(const IoClosed& closed, const ConnectionTask& task, const std::string& host, bool json,
                         const IoOpened* opened, const IoReport* report) {
    OpenQuestion question;
    question.request = closed.request;
    question.route = task.plan.route;
    // A path of another form has no words on the command line but the data sheet.
    if (!task.plan.application_path) question.plan = task.plan;
    const auto diagnosis = ask_doctor(question, closed, opened, report);
    if (!diagnosis || diagnosis->well) return {};
    return json ? diagnosis_json(*diagnosis, host).dump() : diagnosis_text(*diagnosis, host);
}

}  // namespace servobus::scanner::cli
