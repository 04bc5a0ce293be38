#include "eds/finding.hpp"

#include <fmt/format.h>

namespace servobus::eds {

std::string_view name(Severity severity) { return severity == Severity::error ? "error" : "warning"; }

std::string_view shown(std::string_view text) { return text.substr(0, 40); }

std::string to_text(const Finding& finding) {
    if (finding.line == 0) return fmt::format("{}: {}", name(finding.severity), finding.words);
    return fmt::format("line {}: {}: {}", finding.line, name(finding.severity), finding.words);
}

}  // namespace servobus::eds
