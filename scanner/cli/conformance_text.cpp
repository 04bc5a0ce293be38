#include <fmt/format.h>

#include "cip/hex.hpp"
#include "scanner/cli/conformance_output.hpp"
#include "scanner/cli/text_output.hpp"

namespace servobus::scanner::cli {
namespace {

using conformance::Manner;
using Verdict = conformance::Outcome;
using conformance::Report;
using conformance::Result;
using conformance::Step;

/// Octets of one message that are worth a person's time.
constexpr std::size_t shown_octets = 96;
constexpr auto indent = "            ";

std::string_view mark(Verdict outcome) { return outcome == Verdict::fail ? "FAIL" : conformance::name(outcome); }

std::string step_text(const Step& step) {
    auto text = fmt::format("{}{}  {}\n", indent, conformance::name(step.kind), printable(step.words));
    if (step.size == 0) return text;
    const auto shown = cip::ByteView(step.octets).first(std::min(step.octets.size(), shown_octets));
    const auto rest = step.size > shown.size() ? fmt::format(" … {} octets in all", step.size) : std::string();
    return text + fmt::format("{}      {}{}\n", indent, cip::to_hex(shown), rest);
}

}  // namespace

std::string conformance_head(const std::string& host, const conformance::Subject& subject) {
    std::string text = fmt::format("{}: ", host);
    if (const auto& identity = subject.identity) {
        const auto vendor = vendor_name(identity->vendor);
        text += fmt::format("{}, revision {}.{}, serial number {}, vendor {}{}\n", printable(identity->product_name),
                            identity->major_revision, identity->minor_revision, identity->serial_number,
                            identity->vendor, vendor.empty() ? "" : fmt::format(" ({})", vendor));
    } else {
        text += "it does not say who it is\n";
    }
    const auto& candidates = subject.options().candidates;
    text += fmt::format("{}; {}\n",
                        subject.writes() ? "with leave to write and to own outputs, which stay idle"
                                         : "read-only: nothing is written, and no output is owned",
                        candidates.empty() ? "no I/O connection is known, for want of --eds"
                                           : fmt::format("{} I/O connections are known", candidates.size()));
    return text;
}

std::string conformance_group(conformance::Group group) {
    const auto& row = conformance::row_of(group);
    return fmt::format("\n{}: {}\n", row.name, row.title);
}

std::string conformance_result(const Result& result, bool verbose) {
    const auto& which = *result.which;
    auto text = fmt::format("  {:<8}  {:<6}  {}", mark(result.outcome), which.id, which.title);
    if (result.outcome == Verdict::skipped) return text + fmt::format(": {}\n", printable(result.reason));
    text += '\n';
    const bool explains = result.outcome != Verdict::pass;
    if (!explains && !verbose) return text;
    text += fmt::format("{}{}: {}\n", indent, which.rule, which.words);
    for (const auto& finding : result.findings) {
        const bool lesser = result.outcome == Verdict::fail && !finding.firm;
        text += fmt::format("{}- {}{}\n", indent, lesser ? "advisory: " : "", printable(finding.words));
    }
    if (result.outcome == Verdict::advisory && !verbose) return text;
    for (const auto& step : result.record.steps()) text += step_text(step);
    if (result.record.left_out() > 0) text += fmt::format("{}and {} more\n", indent, result.record.left_out());
    return text;
}

std::string conformance_summary(const Report& report) {
    const auto seconds = static_cast<double>(report.took.count()) / 1000;
    auto text =
        fmt::format("\n{} cases in {:.1f} s: {} pass, {} advisory, {} fail, {} skipped\n", report.results.size(),
                    seconds, report.count(Verdict::pass), report.count(Verdict::advisory), report.count(Verdict::fail),
                    report.count(Verdict::skipped));
    if (report.lost) text += "The device does not answer any more.\n";
    return text;
}

std::string conformance_list(ConformanceCases cases) {
    std::string text;
    std::optional<conformance::Group> group;
    for (const auto* each : cases) {
        if (group != each->group) text += conformance_group(each->group).substr(group ? 0 : 1);
        group = each->group;
        text += fmt::format("  {:<6}  {:<6}  {:<8}  {}\n", each->id, each->manner == Manner::writes ? "writes" : "",
                            each->rule, each->title);
    }
    return text;
}

}  // namespace servobus::scanner::cli
