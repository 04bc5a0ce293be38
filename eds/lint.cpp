#include "eds/lint.hpp"

#include <fmt/format.h>

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

void check_path(const DataSheet& sheet, const PathPattern& path, std::size_t line, std::string_view owner,
                Notes& notes) {
    for (const auto& part : path.parts) {
        const auto* reference = std::get_if<PathPattern::Parameter>(&part);
        if (reference == nullptr || sheet.parameter(reference->number) != nullptr) continue;
        notes.error(line, fmt::format("{}: the path names Param{}, which is not there", owner, reference->number));
    }
    const auto octets = path.octets();
    if (!octets) return;
    const auto shown = cip::to_hex(cip::ByteView(*octets).first(std::min<std::size_t>(octets->size(), 16)));
    const auto list = segments(*octets);
    if (!list) {
        notes.error(line, fmt::format("{}: the path '{}' has a segment that does not exist, or is cut", owner, shown));
    } else if (list->encode() != *octets) {
        notes.warning(line, fmt::format("{}: the path '{}' lacks the padding of wide segments", owner, shown));
    }
}

std::vector<const Entry*> numbered(const Document& document, std::string_view section, std::string_view prefix) {
    std::vector<const Entry*> entries;
    const auto* found = document.find(section);
    if (found == nullptr) return entries;
    for (const auto& entry : found->entries) {
        if (number_behind(prefix, entry.keyword)) entries.push_back(&entry);
    }
    return entries;
}

bool is_of_a_vendor(std::string_view keyword) {
    const auto digits = std::min(keyword.find_first_not_of("0123456789"), keyword.size());
    return digits > 0 && digits < keyword.size() && keyword[digits] == '_';
}

}  // namespace servobus::eds
