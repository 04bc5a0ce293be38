#include "scanner/cli/doctor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "scanner/cli/diagnosis_output.hpp"
#include "scanner/cli/table.hpp"
#include "scanner/cli/verbs.hpp"
#include "scanner/connection_path.hpp"
#include "scanner/open_terms.hpp"

namespace servobus::scanner::cli {
namespace {

using Json = nlohmann::ordered_json;
using std::chrono::microseconds;
using std::chrono::nanoseconds;

/// Of the original's size, how often another one came, and which.
void count_sizes(const CapturedFlow& flow, std::size_t right, IoTraffic::Direction& direction) {
    std::uint64_t most = 0;
    for (const auto& [size, count] : flow.sizes) {
        if (size == right) continue;
        direction.other_size_packets += count;
        if (count > most) direction.other_size = size;
        most = std::max(most, count);
    }
}

/// Whether the first octets of a direction are a run/idle header, as far as anybody can tell from outside: the drive's
/// own connections have it in O->T, and elsewhere it is one when nothing else was seen there.
bool has_header(const CapturedOpen& open, const CapturedFlow& flow) {
    const auto path = ConnectionPath::read(open.request->path);
    if (path.o_to_t() && path.t_to_o()) {
        const auto* known = assemblies::find_connection(*path.o_to_t(), *path.t_to_o());
        if (known != nullptr && known->o_to_t_size() == open.request->o_to_t.size) {
            return known->o_to_t_format() == cip::RealTimeFormat::header32;
        }
    }
    // Idle alone may be data of zeros.
    return flow.header_odd == 0 && flow.header_run > 0;
}

IoTraffic::Direction direction_of(const CapturedOpen& open, bool o_to_t, CaptureTime end) {
    const auto& flow = o_to_t ? open.o_to_t : open.t_to_o;
    IoTraffic::Direction direction;
    direction.packets = flow.packets;
    direction.lost = flow.statistics.counters().lost;
    direction.longest_interval = flow.statistics.longest_silence();
    direction.silent = std::max(nanoseconds{}, end - (flow.packets > 0 ? flow.last : *open.answered));
    count_sizes(flow, o_to_t ? open.request->o_to_t.size : open.request->t_to_o.size, direction);
    if (o_to_t && has_header(open, flow)) direction.always_idle = flow.header_run == 0 && flow.header_idle > 0;
    const auto expected = o_to_t ? enip::Endpoint{} : open.expected_receiver();
    if (!o_to_t && !flow.destinations.empty() && !flow.destinations.contains(expected)) {
        direction.elsewhere = flow.destinations.begin()->first;
    }
    return direction;
}

IoTraffic traffic_of(const CapturedOpen& open, CaptureTime capture_end) {
    auto end = open.closing.value_or(capture_end);
    if (open.replaced) end = std::min(end, *open.replaced);
    IoTraffic traffic;
    traffic.o_to_t_api = open.reply->o_to_t_api;
    traffic.t_to_o_api = open.reply->t_to_o_api;
    traffic.o_to_t = direction_of(open, true, end);
    traffic.t_to_o = direction_of(open, false, end);
    traffic.receiver = open.expected_receiver();
    traffic.observed = end - *open.answered;
    traffic.closed = open.closing.has_value();
    return traffic;
}

std::string host_of(enip::Endpoint target) {
    auto text = enip::to_string(target);
    if (target.port == enip::tcp_port) text.erase(text.rfind(':'));
    return text;
}

// --- text

std::string answer_text(const CapturedOpen& open) {
    if (!open.answered) return "not answered";
    const auto after = duration_text(*open.answered - open.asked);
    if (!open.granted()) return fmt::format("refused after {}", after);
    return fmt::format("granted after {}: O->T 0x{:08X} every {}, T->O 0x{:08X} every {} to {}", after,
                       open.reply->o_to_t_id, duration_text(microseconds(open.reply->o_to_t_api)),
                       open.reply->t_to_o_id, duration_text(microseconds(open.reply->t_to_o_api)),
                       enip::to_string(open.expected_receiver()));
}

std::string close_text(const CapturedOpen& open, CaptureTime first) {
    if (!open.closing) return open.replaced ? "replaced by a later open with the same ids" : "not closed";
    const auto when = duration_text(*open.closing - first);
    if (!open.close_status) return fmt::format("Forward_Close at {}, not answered", when);
    return open.close_status->ok() ? fmt::format("closed at {}", when)
                                   : fmt::format("Forward_Close at {}: {}", when, cip::describe(*open.close_status));
}

std::vector<std::string> flow_row(const char* name, const CapturedFlow& flow) {
    const auto& statistics = flow.statistics;
    const auto& counters = statistics.counters();
    const auto intervals = statistics.intervals();
    const auto mean = statistics.mean_interval_ns();
    return {name,
            fmt::format("{}", flow.packets),
            fmt::format("{}", counters.lost),
            fmt::format("{}", counters.late),
            fmt::format("{}", counters.duplicated),
            duration_text(statistics.granted()),
            mean ? duration_text(nanoseconds(std::llround(*mean))) : "-",
            duration_text(intervals.p50),
            duration_text(intervals.p99),
            duration_text(intervals.p999),
            duration_text(intervals.max)};
}

std::string indented(const std::string& text, std::size_t indent) {
    std::string result;
    for (std::size_t begin = 0; begin < text.size();) {
        const auto end = text.find('\n', begin);
        result += std::string(indent, ' ') + text.substr(begin, end - begin) + '\n';
        begin = end == std::string::npos ? text.size() : end + 1;
    }
    return result;
}

std::string flow_text(const CapturedOpen& open) {
    if (!open.granted() || !open.carries_io()) return {};
    Table table({"", "packets", "lost", "late", "duplicated", "granted", "mean", "p50", "p99", "p99.9", "max"});
    table.add(flow_row("O->T", open.o_to_t));
    table.add(flow_row("T->O", open.t_to_o));
    return indented(table.text(), 2);
}

/// "1 open, 0 in trouble", and what of the file could not be used.
std::string remarks(const CaptureReport& report) {
    const auto& summary = report.summary;
    const auto& counters = report.conversation->counters();
    const auto tcp = report.conversation->tcp();
    std::string text;
    const auto remark = [&](std::uint64_t count, std::string_view what) {
        if (count > 0) text += fmt::format("{} {}\n", count, what);
    };
    remark(summary.unknown_link, "frames of an interface whose link type is not known were passed over");
    remark(summary.cut, "frames are not all there, since the capture was told to cut them");
    remark(summary.fragments, "fragments of datagrams were passed over");
    remark(summary.malformed, "frames have lengths that contradict each other");
    remark(tcp.gaps, "places where the capture has lost octets of a TCP connection");
    remark(counters.io_without_open, "class 0 or 1 datagrams belong to connections whose Forward_Open is not there");
    remark(counters.io_malformed, "datagrams at port 2222 are not of class 0 or 1");
    remark(counters.opens_left_out, "opens were left out, since there are too many");
    remark(counters.streams_left_out, "packets of TCP connections were left out, since there are too many");
    return text;
}

// --- JSON

Json flow_json(const CapturedFlow& flow) {
    const auto ms = [](nanoseconds time) { return static_cast<double>(time.count()) / 1e6; };
    const auto& statistics = flow.statistics;
    const auto& counters = statistics.counters();
    const auto intervals = statistics.intervals();
    const auto mean = statistics.mean_interval_ns();
    Json sizes = Json::array();
    for (const auto& [size, count] : flow.sizes) sizes.push_back({{"octets", size}, {"packets", count}});
    Json destinations = Json::array();
    for (const auto& [where, count] : flow.destinations) destinations.push_back(enip::to_string(where));
    return {{"packets", flow.packets},
            {"lost", counters.lost},
            {"late", counters.late},
            {"duplicated", counters.duplicated},
            {"reordered", counters.reordered},
            {"repeated", flow.repeated},
            {"granted_ms", ms(statistics.granted())},
            {"mean_ms", mean ? Json(*mean / 1e6) : Json()},
            {"interval_ms",
             {{"p50", ms(intervals.p50)},
              {"p99", ms(intervals.p99)},
              {"p99.9", ms(intervals.p999)},
              {"max", ms(intervals.max)}}},
            {"sizes", std::move(sizes)},
            {"destinations", std::move(destinations)}};
}

Json status_json(const cip::Status& status) {
    return {
        {"general", static_cast<int>(status.general)}, {"extended", status.extended}, {"text", cip::describe(status)}};
}

Json open_json(const DiagnosedOpen& diagnosed, CaptureTime first) {
    const auto& open = *diagnosed.open;
    const auto seconds = [&](CaptureTime time) { return static_cast<double>((time - first).count()) / 1e9; };
    Json json{{"originator", enip::to_string(open.originator)},
              {"target", enip::to_string(open.target)},
              {"time", seconds(open.asked)},
              {"granted", open.granted()}};
    json["status"] = open.answered && !open.encapsulation_status ? status_json(open.status) : Json();
    json["closed"] = open.closing ? Json(seconds(*open.closing)) : Json();
    json["diagnosis"] = diagnosis_json(diagnosed.diagnosis, host_of(open.target));
    if (open.granted() && open.carries_io()) {
        json["o_to_t"] = flow_json(open.o_to_t);
        json["t_to_o"] = flow_json(open.t_to_o);
    }
    return json;
}

Json damage_json(const CaptureSummary& summary) {
    if (!summary.damage) return nullptr;
    return {{"offset", summary.damage->offset}, {"text", summary.damage->text}};
}

}  // namespace

Diagnosis diagnose(const CapturedOpen& open, const Conversation& conversation, CaptureTime end) {
    OpenQuestion question;
    question.request = open.request;
    if (const auto route = cip::Path::parse(open.route)) question.route = *route;
    // Behind a route there is another device than the one that said who it is.
    const auto* identity = open.route.empty() ? conversation.identity(open.target.address) : nullptr;
    if (identity != nullptr) question.identity = *identity;
    if (!open.answered) return diagnose_silence(question);
    if (open.encapsulation_status) return diagnose_refusal(question, *open.encapsulation_status);
    if (!open.status.ok()) return diagnose_refusal(question, open.status);
    if (!open.granted()) return diagnose_bad_reply(question);
    if (open.carries_io()) return diagnose_traffic(question, traffic_of(open, end));
    Diagnosis diagnosis;
    diagnosis.well = true;
    diagnosis.summary = "granted; explicit messages, whose data is not looked at";
    diagnosis.asked = asked_text(*open.request, ConnectionPath::read(open.request->path));
    return diagnosis;
}

std::string report_text(const CaptureReport& report) {
    const auto first = report.summary.first.value_or(CaptureTime{});
    std::string text;
    for (std::size_t i = 0; i < report.opens.size(); ++i) {
        const auto& open = *report.opens[i].open;
        text += fmt::format("{}. {} opens a connection to {}, {} into the capture\n", i + 1,
                            enip::to_string(open.originator), enip::to_string(open.target),
                            duration_text(open.asked - first));
        text += fmt::format("  {}\n", answer_text(open));
        text += diagnosis_text(report.opens[i].diagnosis, host_of(open.target), 2);
        text += flow_text(open);
        if (open.granted()) text += fmt::format("  {}\n", close_text(open, first));
        text += '\n';
    }
    if (report.opens.empty()) text += "There is no Forward_Open in this capture.\n";
    return text + remarks(report);
}

std::string report_json(const CaptureReport& report) {
    const auto first = report.summary.first.value_or(CaptureTime{});
    Json opens = Json::array();
    for (const auto& each : report.opens) opens.push_back(open_json(each, first));
    const auto& summary = report.summary;
    const auto& counters = report.conversation->counters();
    const Json json{{"file", report.file},
                    {"packets", summary.packets},
                    {"opens", std::move(opens)},
                    {"unused",
                     {{"foreign", summary.foreign},
                      {"fragments", summary.fragments},
                      {"cut", summary.cut},
                      {"malformed", summary.malformed},
                      {"unknown_link", summary.unknown_link},
                      {"tcp_gaps", report.conversation->tcp().gaps},
                      {"io_without_open", counters.io_without_open},
                      {"io_malformed", counters.io_malformed}}},
                    {"damage", damage_json(summary)}};
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

ExitCode doctor(const Console& console, const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) return fail(console, Mistake{fmt::format("'{}' cannot be read", file)});
    Conversation conversation;
    CaptureReport report;
    report.file = file;
    report.summary = read_capture(stream, [&](const CapturedPacket& packet) { conversation.take(packet); });
    conversation.finish();
    const auto& damage = report.summary.damage;
    if (damage && report.summary.packets == 0) {
        return fail(console, Mistake{fmt::format("'{}', octet {}: {}", file, damage->offset, damage->text)});
    }
    report.conversation = &conversation;
    const auto end = report.summary.last.value_or(CaptureTime{});
    for (const auto& open : conversation.opens()) report.opens.push_back({&open, diagnose(open, conversation, end)});
    console.show(console.json ? std::string() : report_text(report),
                 console.json ? report_json(report) : std::string());
    if (damage) {
        console.say(
            fmt::format("'{}', octet {}: {}; what stands before it was read", file, damage->offset, damage->text));
        return ExitCode::usage;
    }
    const bool well = std::ranges::all_of(report.opens, [](const DiagnosedOpen& each) { return each.diagnosis.well; });
    return well ? ExitCode::done : ExitCode::refused;
}

}  // namespace servobus::scanner::cli
