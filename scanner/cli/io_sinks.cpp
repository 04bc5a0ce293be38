#include "scanner/cli/io_sinks.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "scanner/cli/io_output.hpp"

namespace servobus::scanner::cli {
namespace {

constexpr std::chrono::milliseconds table_interval{100};

std::string next_try_text(const IoClosed& closed) {
    if (!closed.next_try) return {};
    return fmt::format("; the next try is in {} ms", closed.next_try->count());
}

}  // namespace

IoTable::IoTable(const Console& console, const ConnectionTask& task)
    : console_(console), task_(task), table_(console.err) {}

void IoTable::opened(const IoOpened& opened) {
    state_ = fmt::format("open to {}", enip::to_string(opened.target));
    next_ = {};
}

void IoTable::input(const IoInput& input, std::chrono::duration<double>) {
    data_.assign(input.data.begin(), input.data.end());
    run_ = input.run;
}

void IoTable::closed(const IoClosed& closed, const std::string& text) {
    // It is said at the end, when it is over.
    if (!closed.next_try) return;
    table_.clear();
    console_.say(text + next_try_text(closed));
    state_ = "waiting for the next try";
    next_ = {};
}

void IoTable::look(const IoReport& report) {
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) return;
    next_ = now + table_interval;
    auto lines = inputs_table(task_.input_fields, data_);
    lines.insert(lines.begin(), fmt::format("{}{}", state_, data_.empty() || run_ ? "" : ", idle"));
    lines.push_back(report_line(report));
    table_.show(lines);
}

IoLines::IoLines(const Console& console, const ConnectionTask& task, std::ostream* out)
    : console_(console), task_(task), out_(out) {}

void IoLines::opened(const IoOpened& opened) {
    if (out_ != nullptr) *out_ << opened_text(task_, opened) << std::flush;
}

void IoLines::input(const IoInput& input, std::chrono::duration<double> time) {
    if (out_ == nullptr || time.count() < next_) return;
    next_ = std::floor(time.count()) + 1;
    *out_ << fmt::format("{:.3f} s  {}{}\n", time.count(), input.run ? "" : "idle  ",
                         inputs_line(task_.input_fields, input.data))
          << std::flush;
}

void IoLines::closed(const IoClosed& closed, const std::string& text) {
    if (closed.next_try) console_.say(text + next_try_text(closed));
}

IoJsonLines::IoJsonLines(std::ostream& out, std::string host, const ConnectionTask& task)
    : out_(out), host_(std::move(host)), task_(task) {}

void IoJsonLines::opened(const IoOpened& opened) { out_ << opened_line_json(host_, task_, opened) << std::flush; }

void IoJsonLines::input(const IoInput& input, std::chrono::duration<double> time) {
    out_ << input_line_json(task_.input_fields, input, time.count());
}

void IoJsonLines::closed(const IoClosed& closed, const std::string& text) { out_ << closed_line_json(closed, text); }

void IoJsonLines::look(const IoReport&) { out_ << std::flush; }

IoCsv::IoCsv(std::ostream& out, const ConnectionTask& task) : out_(out), task_(task) {
    out_ << csv_header(task.input_fields, task.plan.t_to_o.data_octets);
}

void IoCsv::input(const IoInput& input, std::chrono::duration<double> time) {
    out_ << csv_line(task_.input_fields, input, time.count());
}

void IoCsv::look(const IoReport&) { out_ << std::flush; }

}  // namespace servobus::scanner::cli
