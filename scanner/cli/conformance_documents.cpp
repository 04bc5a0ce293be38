#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "cip/hex.hpp"
#include "scanner/cli/conformance_output.hpp"
#include "scanner/cli/sheet_json.hpp"
#include "scanner/cli/text_output.hpp"

namespace servobus::scanner::cli {
namespace {

using Json = nlohmann::ordered_json;
using conformance::Case;
using conformance::Manner;
using Verdict = conformance::Outcome;
using conformance::Report;
using conformance::Result;

Json case_json(const Case& which) {
    return {{"id", which.id},           {"group", conformance::row_of(which.group).name},
            {"title", which.title},     {"rule", which.rule},
            {"rule_text", which.words}, {"writes", which.manner == Manner::writes}};
}

Json result_json(const Result& result) {
    auto json = case_json(*result.which);
    json["outcome"] = conformance::name(result.outcome);
    json["milliseconds"] = result.took.count();
    if (result.outcome == Verdict::skipped) json["reason"] = printable(result.reason);
    json["findings"] = Json::array();
    for (const auto& finding : result.findings) {
        json["findings"].push_back({{"failure", finding.firm}, {"text", printable(finding.words)}});
    }
    json["exchange"] = Json::array();
    for (const auto& step : result.record.steps()) {
        Json entry{{"kind", conformance::name(step.kind)}, {"text", printable(step.words)}};
        if (step.size > 0) {
            entry["octets"] = step.size;
            entry["hex"] = cip::to_hex(step.octets);
        }
        json["exchange"].push_back(std::move(entry));
    }
    json["left_out"] = result.record.left_out();
    return json;
}

// ---------------------------------------------------------------------------------------------------------------- JUnit

/// Printable text, and what XML takes for itself written otherwise.
std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : printable(text)) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                out += c;
        }
    }
    return out;
}

/// The lines of a text, each escaped by itself: line ends are no characters that cannot be printed.
std::string escaped_lines(std::string_view text) {
    std::string out;
    while (!text.empty()) {
        const auto end = std::min(text.find('\n'), text.size());
        out += escaped(text.substr(0, end));
        if (end < text.size()) out += '\n';
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return out;
}

std::string first_finding(const Result& result) {
    for (const auto& finding : result.findings) {
        if (finding.firm) return finding.words;
    }
    return {};
}

std::string seconds(std::chrono::milliseconds time) {
    return fmt::format("{:.3f}", static_cast<double>(time.count()) / 1000);
}

std::string test_case(const Result& result) {
    const auto& which = *result.which;
    auto text =
        fmt::format("    <testcase classname=\"conformance.{}\" name=\"{} {}\" time=\"{}\"",
                    conformance::row_of(which.group).name, which.id, escaped(which.title), seconds(result.took));
    switch (result.outcome) {
        case Verdict::pass:
            return text + "/>\n";
        case Verdict::skipped:
            return text + fmt::format(">\n      <skipped message=\"{}\"/>\n    </testcase>\n", escaped(result.reason));
        case Verdict::fail:
            return text + fmt::format(">\n      <failure type=\"{}\" message=\"{}\">{}</failure>\n    </testcase>\n",
                                      which.rule, escaped(first_finding(result)),
                                      escaped_lines(conformance_result(result, true)));
        case Verdict::advisory:
            return text + fmt::format(">\n      <system-out>{}</system-out>\n    </testcase>\n",
                                      escaped_lines(conformance_result(result, true)));
    }
    return text + "/>\n";
}

struct Counts {
    std::size_t tests = 0;
    std::size_t failures = 0;
    std::size_t skipped = 0;
    std::chrono::milliseconds took{};

    void add(const Result& result) {
        ++tests;
        if (result.outcome == Verdict::fail) ++failures;
        if (result.outcome == Verdict::skipped) ++skipped;
        took += result.took;
    }
    [[nodiscard]] std::string attributes() const {
        return fmt::format("tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"{}\" time=\"{}\"", tests, failures,
                           skipped, seconds(took));
    }
};

}  // namespace

std::string conformance_json(const std::string& host, const conformance::Subject& subject, const Report& report) {
    Json json{{"host", host}};
    if (const auto& identity = subject.identity) {
        json["identity"] = {{"vendor", identity->vendor},
                            {"device_type", identity->device_type},
                            {"product_code", identity->product_code},
                            {"revision", fmt::format("{}.{}", identity->major_revision, identity->minor_revision)},
                            {"serial_number", identity->serial_number},
                            {"product_name", printable(identity->product_name)}};
    }
    json["writes"] = subject.writes();
    json["connections"] = Json::array();
    for (const auto& each : subject.options().candidates) {
        json["connections"].push_back({{"name", printable(each.name)}, {"kind", conformance::name(each.kind)}});
    }
    json["counts"] = {{"cases", report.results.size()},
                      {"pass", report.count(Verdict::pass)},
                      {"advisory", report.count(Verdict::advisory)},
                      {"fail", report.count(Verdict::fail)},
                      {"skipped", report.count(Verdict::skipped)}};
    json["milliseconds"] = report.took.count();
    json["interrupted"] = report.interrupted;
    json["lost"] = report.lost;
    json["results"] = Json::array();
    for (const auto& result : report.results) json["results"].push_back(result_json(result));
    return document(json);
}

std::string conformance_list_json(ConformanceCases cases) {
    Json json{{"cases", Json::array()}};
    for (const auto* each : cases) json["cases"].push_back(case_json(*each));
    return document(json);
}

std::string conformance_junit(const std::string& host, const Report& report) {
    Counts all;
    std::map<conformance::Group, Counts> counts;
    std::map<conformance::Group, std::string> cases;
    for (const auto& result : report.results) {
        all.add(result);
        counts[result.which->group].add(result);
        cases[result.which->group] += test_case(result);
    }
    all.took = report.took;
    auto text = fmt::format("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"conformance of {}\" {}>\n",
                            escaped(host), all.attributes());
    for (const auto& [group, lines] : cases) {
        text += fmt::format("  <testsuite name=\"{}\" hostname=\"{}\" {}>\n{}  </testsuite>\n",
                            conformance::row_of(group).name, escaped(host), counts[group].attributes(), lines);
    }
    return text + "</testsuites>\n";
}

}  // namespace servobus::scanner::cli
