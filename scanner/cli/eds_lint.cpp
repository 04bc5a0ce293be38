// eds lint: what is wrong with a data sheet, line by line.
#include <fmt/format.h>

#include <algorithm>

#include "eds/lint.hpp"
#include "scanner/cli/eds.hpp"
#include "scanner/cli/sheet_file.hpp"
#include "scanner/cli/sheet_json.hpp"
#include "scanner/cli/text_output.hpp"

namespace servobus::scanner::cli {
namespace {

using Json = nlohmann::ordered_json;
using Findings = std::vector<eds::Finding>;

std::size_t count(const Findings& findings, eds::Severity severity) {
    return static_cast<std::size_t>(std::ranges::count(findings, severity, &eds::Finding::severity));
}

/// As compilers write it, so that editors find the place.
std::string line_of(const std::string& file, const eds::Finding& finding) {
    const auto place = finding.line > 0 ? fmt::format("{}:{}", file, finding.line) : file;
    return fmt::format("{}: {}: {}\n", place, name(finding.severity), printable(finding.words));
}

std::string text_of(const std::string& file, const Findings& findings) {
    if (findings.empty()) return fmt::format("{}: nothing found\n", file);
    std::string text;
    for (const auto& finding : findings) text += line_of(file, finding);
    const auto counted = [&](eds::Severity severity, std::string_view word) {
        const auto number = count(findings, severity);
        return fmt::format("{} {}{}", number, word, number == 1 ? "" : "s");
    };
    return text +
           fmt::format("{}, {}\n", counted(eds::Severity::error, "error"), counted(eds::Severity::warning, "warning"));
}

std::string json_of(const std::string& file, const Findings& findings) {
    Json json{{"file", file},
              {"errors", count(findings, eds::Severity::error)},
              {"warnings", count(findings, eds::Severity::warning)},
              {"findings", Json::array()}};
    for (const auto& finding : findings) {
        json["findings"].push_back({{"line", finding.line > 0 ? Json(finding.line) : Json()},
                                    {"severity", std::string(name(finding.severity))},
                                    {"text", printable(finding.words)}});
    }
    return document(json);
}

}  // namespace

ExitCode eds_lint(const Console& console, const std::string& file) {
    const auto text = read_sheet_file(file);
    if (!text) return fail(console, text.error());
    const auto findings = eds::lint(*text);
    console.show(text_of(file, findings), json_of(file, findings));
    return count(findings, eds::Severity::error) > 0 ? ExitCode::refused : ExitCode::done;
}

}  // namespace servobus::scanner::cli
