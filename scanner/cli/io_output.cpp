#include "scanner/cli/io_output.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cip/hex.hpp"
#include "cip/status.hpp"
#include "scanner/cli/io_data.hpp"
#include "scanner/cli/text_output.hpp"

namespace servobus::scanner::cli {
namespace {

using Json = nlohmann::ordered_json;
using Duration = IntervalStatistics::Duration;
using Kind = assemblies::Member::Kind;

/// Octets in a line of a table without names, and lines of it at most.
constexpr std::size_t line_octets = 16;
constexpr std::size_t max_hex_lines = 16;

double milliseconds(Duration duration) { return static_cast<double>(duration.count()) / 1e6; }
double microseconds(Duration duration) { return static_cast<double>(duration.count()) / 1e3; }

std::string line(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n'; }

std::string direction_text(std::string_view name, const IoDirection& direction, std::string_view what_they_are,
                           std::chrono::microseconds granted) {
    const auto what = direction.format == cip::RealTimeFormat::heartbeat
                          ? std::string("heartbeat")
                          : fmt::format("{} octets{}, {}", direction.data_octets,
                                        what_they_are.empty() ? std::string() : fmt::format(" ({})", what_they_are),
                                        cip::name(direction.format));
    return fmt::format("{}  point {}: {}; connection size {}, every {} ms", name, direction.point, what,
                       direction.connection_size(), static_cast<double>(granted.count()) / 1000);
}

std::string distribution_text(const IntervalStatistics::Distribution& times) {
    return fmt::format("p50 {:.3f}, p99 {:.3f}, p99.9 {:.3f}, max {:.3f} ms", milliseconds(times.p50),
                       milliseconds(times.p99), milliseconds(times.p999), milliseconds(times.max));
}

Json distribution_json(const IntervalStatistics::Distribution& times) {
    return {{"p50", microseconds(times.p50)},
            {"p99", microseconds(times.p99)},
            {"p99_9", microseconds(times.p999)},
            {"max", microseconds(times.max)}};
}

std::string drift_text(const IoReport& report) {
    const auto drift = report.received.drift_ppm();
    if (!drift || !report.cyclic) return {};
    return fmt::format("drift {:+.1f} ppm, mean interval {:.6f} ms\n", *drift,
                       *report.received.mean_interval_ns() / 1e6);
}

Json statistics_json(const IoReport& report) {
    const auto& received = report.received;
    const auto& count = received.counters();
    const auto mean = received.mean_interval_ns();
    const auto drift = received.drift_ppm();
    return {{"seconds", report.open_for.count()},
            {"openings", report.openings},
            {"sent", report.sent},
            {"received", count.packets},
            {"lost", count.lost},
            {"late", count.late},
            {"duplicated", count.duplicated},
            {"reordered", count.reordered},
            {"wrong_size", report.wrong_size},
            {"granted_us", microseconds(received.granted())},
            {"interval_us", distribution_json(received.intervals())},
            {"error_us", distribution_json(received.errors())},
            {"longest_silence_us", microseconds(received.longest_silence())},
            {"mean_interval_us", mean ? Json(*mean / 1000) : Json()},
            {"drift_ppm", drift && report.cyclic ? Json(*drift) : Json()}};
}

Json direction_json(const IoDirection& direction, std::uint32_t id, std::chrono::microseconds granted,
                    enip::Endpoint to) {
    return {{"point", direction.point},
            {"octets", direction.data_octets},
            {"connection_size", direction.connection_size()},
            {"format", std::string(format_key(direction.format))},
            {"interval_us", granted.count()},
            {"connection_id", id},
            {"to", enip::to_string(to)}};
}

std::string column_name(const IoField& field) {
    return field.unit().empty() ? field.name() : fmt::format("{} [{}]", field.name(), field.unit());
}

bool is_shown(const IoField& field) { return field.kind != Kind::padding; }

/// An idle sender without data, or a heartbeat, shows nothing.
bool has_members(const IoFields& fields, std::size_t octets) {
    if (fields.empty()) return false;
    return octets > 0 && octets >= fields.back().offset + fields.back().octets;
}

Json to_json(const eds::Value& value) {
    if (const auto* text = std::get_if<std::string>(&value)) return printable(*text);
    if (const auto* fraction = std::get_if<double>(&value)) return *fraction;
    const auto* whole = std::get_if<std::int64_t>(&value);
    return whole != nullptr ? Json(*whole) : Json();
}

/// For a table: numbers alone, a text in quotes.
std::string cell(const eds::Value& value) {
    if (const auto* fraction = std::get_if<double>(&value)) return fmt::format("{}", *fraction);
    if (const auto* whole = std::get_if<std::int64_t>(&value)) return fmt::format("{}", *whole);
    const auto* text = std::get_if<std::string>(&value);
    return text != nullptr ? '"' + printable(*text) + '"' : std::string();
}

}  // namespace

std::string opened_text(const ConnectionTask& task, const IoOpened& opened) {
    const auto way = [](enip::Endpoint to, std::uint32_t id) {
        return fmt::format(", to {}, id 0x{:08X}\n", enip::to_string(to), id);
    };
    const auto& reply = opened.reply;
    return direction_text("O->T", task.plan.o_to_t, task.output_name, opened.o_to_t_interval()) +
           way(opened.target, reply.o_to_t_id) +
           direction_text("T->O", task.plan.t_to_o, task.input_name, opened.t_to_o_interval()) +
           way(opened.receiver, reply.t_to_o_id);
}

std::string report_text(const IoReport& report) {
    const auto& received = report.received;
    const auto& count = received.counters();
    std::string text = fmt::format("{:.3f} s: sent {}, received {}, lost {}, late {}, duplicated {}, out of order {}",
                                   report.open_for.count(), report.sent, count.packets, count.lost, count.late,
                                   count.duplicated, count.reordered);
    if (report.wrong_size > 0) text += fmt::format(", {} of a wrong size", report.wrong_size);
    if (report.openings > 1) text += fmt::format(", opened {} times", report.openings);
    text += '\n';
    if (received.interval_count() == 0) return text;
    return text +
           fmt::format("interval, granted {:.3f} ms: {}\n", milliseconds(received.granted()),
                       distribution_text(received.intervals())) +
           fmt::format("error of the interval: {}; longest silence {:.3f} ms\n", distribution_text(received.errors()),
                       milliseconds(received.longest_silence())) +
           drift_text(report);
}

std::string report_line(const IoReport& report) {
    const auto& count = report.received.counters();
    const auto intervals = report.received.intervals();
    return fmt::format(
        "{:.1f} s  {} in, {} out, {} lost, {} late  interval p50 {:.3f}, p99 {:.3f}, max {:.3f} of {:.3f} ms",
        report.open_for.count(), count.packets, report.sent, count.lost, count.late, milliseconds(intervals.p50),
        milliseconds(intervals.p99), milliseconds(intervals.max), milliseconds(report.received.granted()));
}

std::string inputs_line(const IoFields& fields, cip::ByteView data) {
    if (!has_members(fields, data.size())) return cip::to_hex(data);
    std::vector<std::string> words;
    for (const auto& field : fields) {
        if (!is_shown(field)) continue;
        const auto unit = field.unit().empty() ? std::string() : " " + field.unit();
        words.push_back(fmt::format("{} {}{}", field.name(), text_in(field, data), unit));
    }
    return fmt::format("{}", fmt::join(words, ", "));
}

std::vector<std::string> inputs_table(const IoFields& fields, cip::ByteView data) {
    std::vector<std::string> lines;
    if (has_members(fields, data.size())) {
        for (const auto& field : fields) {
            if (!is_shown(field)) continue;
            auto text = fmt::format("{:<30}{:>20} {:<10}", field.name(), text_in(field, data), field.unit());
            const auto meaning = meaning_in(field, data);
            text += meaning.empty() ? std::string() : " " + meaning;
            text.erase(text.find_last_not_of(' ') + 1);
            lines.push_back(std::move(text));
        }
        return lines;
    }
    for (std::size_t at = 0; at < data.size() && lines.size() < max_hex_lines; at += line_octets) {
        const auto part = data.subspan(at, std::min(line_octets, data.size() - at));
        lines.push_back(fmt::format("{:5}  {}", at, cip::to_hex(part)));
    }
    constexpr auto shown = line_octets * max_hex_lines;
    if (data.size() > shown) lines.push_back(fmt::format("       and {} more octets", data.size() - shown));
    return lines;
}

std::string opened_line_json(const std::string& host, const ConnectionTask& task, const IoOpened& opened) {
    const auto& reply = opened.reply;
    return line(
        {{"event", "opened"},
         {"host", host},
         {"attempt", opened.attempt},
         {"o_to_t", direction_json(task.plan.o_to_t, reply.o_to_t_id, opened.o_to_t_interval(), opened.target)},
         {"t_to_o", direction_json(task.plan.t_to_o, reply.t_to_o_id, opened.t_to_o_interval(), opened.receiver)}});
}

std::string input_line_json(const IoFields& fields, const IoInput& input, double seconds) {
    Json json{{"event", "input"},
              {"time", seconds},
              {"sequence", input.sequence},
              {"fresh", input.fresh},
              {"run", input.run}};
    if (has_members(fields, input.data.size())) {
        auto& values = json["values"] = Json::object();
        for (const auto& field : fields) {
            if (is_shown(field)) values[field.name()] = to_json(value_in(field, input.data));
        }
    } else {
        json["data"] = cip::to_hex(input.data);
    }
    return line(json);
}

std::string closed_line_json(const IoClosed& closed, const std::string& text) {
    Json json{{"event", "closed"}, {"reason", std::string(name(closed.reason))}, {"text", text}};
    json["next_try_ms"] = closed.next_try ? Json(closed.next_try->count()) : Json();
    return line(json);
}

std::string end_line_json(const std::string& host, const IoReport& report, const std::optional<Failure>& failure,
                          const std::string& diagnosis) {
    Json json{{"event", "end"}, {"host", host}, {"statistics", statistics_json(report)}};
    if (failure) {
        auto& error = json["error"] = {{"kind", std::string(row_of(failure->code).kind)},
                                       {"text", failure->text},
                                       {"exit_code", static_cast<int>(failure->code)}};
        if (failure->status) {
            error["general"] = static_cast<int>(failure->status->general);
            error["extended"] = failure->status->extended;
        }
    }
    if (!diagnosis.empty()) json["diagnosis"] = Json::parse(diagnosis, nullptr, false);
    return line(json);
}

std::string csv_header(const IoFields& fields, std::size_t octets) {
    std::string text = "time [s],sequence,fresh,run";
    if (!has_members(fields, octets)) return text + ",data\n";
    for (const auto& field : fields) {
        if (is_shown(field)) text += ',' + column_name(field);
    }
    return text + '\n';
}

std::string csv_line(const IoFields& fields, const IoInput& input, double seconds) {
    auto text = fmt::format("{:.6f},{},{},{}", seconds, input.sequence, input.fresh ? 1 : 0, input.run ? 1 : 0);
    if (fields.empty()) return text + ',' + cip::to_hex(input.data) + '\n';
    for (const auto& field : fields) {
        if (!is_shown(field)) continue;
        text += ',';
        // What came without data has empty cells.
        if (has_members(fields, input.data.size())) text += cell(value_in(field, input.data));
    }
    return text + '\n';
}

}  // namespace servobus::scanner::cli
