#include "eds/lint.hpp"

#include <algorithm>

#include "cip/hex.hpp"
#include "eds/lint_rules.hpp"

namespace servobus::eds {

std::vector<Finding> lint(const Document& document) {
    auto sheet = read(document);
    auto findings = std::move(sheet.findings);
    Notes notes(findings);
    for (const auto rule :
         {lint_sections, lint_identity, lint_parameters, lint_assemblies, lint_connections, lint_network}) {
        rule({document, sheet}, notes);
    }
    std::ranges::stable_sort(findings, {}, &Finding::line);
    return findings;
}

std::vector<Finding> lint(std::string_view octets) {
    const auto document = parse(octets);
    return document ? lint(*document) : std::vector<Finding>{document.error()};
}

std::string path_objection(const DataSheet& sheet, const PathPattern& path) {
    for (const auto& part : path.parts) {
        const auto* reference = std::get_if<PathPattern::Parameter>(&part);
        if (reference != nullptr && sheet.parameter(reference->number) == nullptr) {
            return "the path names Param" + std::to_string(reference->number) + ", which is not there";
        }
    }
    const auto octets = path.octets();
    if (!octets) return {};
    const auto list = segments(*octets);
    if (!list) return "the path '" + cip::to_hex(*octets) + "' has a segment that does not exist, or is cut";
    if (list->encode() != *octets) return "the path '" + cip::to_hex(*octets) + "' lacks the padding of wide segments";
    return {};
}

}  // namespace servobus::eds
