// All that is done with a data sheet, for texts that nobody has written on purpose. What was read is written in the plain
// form and read again as the same, without a warning.
#pragma once

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "eds/data_sheet.hpp"
#include "eds/document.hpp"
#include "eds/lint.hpp"

namespace servobus::test {

/// Ends the program with a sentence: fuzzer and test both show it, with the stack of the sanitizer.
inline void require_of_sheet(bool holds, const char* sentence, std::string_view text) {
    if (holds) return;
    std::fprintf(stderr, "%s:\n%.*s\n", sentence, static_cast<int>(text.size()), text.data());
    std::abort();
}

inline std::string plain_string(std::string_view value) {
    std::string text = "\"";
    for (const char c : value) {
        if (c == '"' || c == '\\') text.push_back('\\');
        if (c == '\n') {
            text += "\\n";
        } else {
            text.push_back(c);
        }
    }
    return text + '"';
}

inline std::string plain_text(const eds::Document& document) {
    std::string text;
    for (const auto& section : document.sections) {
        text += "[" + section.name + "]\n";
        for (const auto& entry : section.entries) {
            text += entry.keyword + " = ";
            for (const auto& field : entry.fields) {
                if (&field != &entry.fields.front()) text += ",";
                text += field.kind == eds::Field::Kind::text ? plain_string(field.value) : field.value;
            }
            text += ";\n";
        }
    }
    return text;
}

inline bool same_content(const eds::Document& one, const eds::Document& other) {
    const auto same_field = [](const eds::Field& a, const eds::Field& b) {
        return a.kind == b.kind && a.value == b.value;
    };
    const auto same_entry = [&](const eds::Entry& a, const eds::Entry& b) {
        return a.keyword == b.keyword && std::ranges::equal(a.fields, b.fields, same_field);
    };
    return std::ranges::equal(one.sections, other.sections, [&](const eds::Section& a, const eds::Section& b) {
        return a.name == b.name && std::ranges::equal(a.entries, b.entries, same_entry);
    });
}

inline void use_everything(const eds::DataSheet& sheet, std::string_view text) {
    for (const auto& parameter : sheet.parameters) {
        (void)parameter.standard_octets();
        (void)parameter.address();
    }
    for (const auto& assembly : sheet.assemblies) {
        const auto octets = sheet.image(assembly).size();
        require_of_sheet(octets <= eds::max_image_octets, "an image has a limit", text);
        require_of_sheet(!assembly.size || octets == *assembly.size, "an image is as long as its size", text);
    }
    for (const auto& connection : sheet.connections) {
        (void)sheet.connection_path(connection, {}, "tag");
        (void)sheet.configuration(connection);
    }
}

inline void read_everything(std::string_view text) {
    const auto document = eds::parse(text);
    if (!document) return;
    const auto again = plain_text(*document);
    const auto second = eds::parse(again);
    require_of_sheet(second && same_content(*document, *second), "a sheet comes out the same", again);
    require_of_sheet(second->warnings.empty(), "the plain form has nothing against it", again);
    use_everything(eds::read(*document), text);
    const auto lines = static_cast<std::size_t>(std::ranges::count(text, '\n') + std::ranges::count(text, '\r')) + 1;
    for (const auto& finding : eds::lint(*document)) {
        require_of_sheet(finding.line <= lines, "a finding is in a line of the text", text);
        require_of_sheet(!finding.words.empty(), "a finding has words", text);
    }
}

}  // namespace servobus::test
