// The rules of the lint, by the sections that they look at. For the lint alone.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "eds/data_sheet.hpp"
#include "eds/document.hpp"

namespace servobus::eds {

/// Where rules write down what they find.
class Notes {
public:
    explicit Notes(std::vector<Finding>& findings) : findings_(findings) {}

    void error(std::size_t line, std::string words) { add(line, Severity::error, std::move(words)); }
    void warning(std::size_t line, std::string words) { add(line, Severity::warning, std::move(words)); }

private:
    void add(std::size_t line, Severity severity, std::string words) {
        if (findings_.size() < 4 * max_findings) findings_.push_back({line, severity, std::move(words)});
    }

    std::vector<Finding>& findings_;
};

/// What a rule looks at: the text as it stands, and what was read from it.
struct Sheet {
    const Document& document;
    const DataSheet& read;
};

void lint_sections(const Sheet& sheet, Notes& notes);     ///< which there are, in which order, with which keywords
void lint_identity(const Sheet& sheet, Notes& notes);     ///< [File], [Device], [Device Classification]
void lint_parameters(const Sheet& sheet, Notes& notes);   ///< [ParamClass], [Params], [Groups]
void lint_assemblies(const Sheet& sheet, Notes& notes);   ///< [Assembly]
void lint_connections(const Sheet& sheet, Notes& notes);  ///< [Connection Manager]
void lint_network(const Sheet& sheet, Notes& notes);      ///< [Port], [Capacity] and the classes

/// Notes what is wrong with a path: `owner` is whose it is, as the words begin.
void check_path(const DataSheet& sheet, const PathPattern& path, std::size_t line, std::string_view owner,
                Notes& notes);

/// The entries of a section whose keyword is the prefix and a number, in their order.
[[nodiscard]] std::vector<const Entry*> numbered(const Document& document, std::string_view section,
                                                 std::string_view prefix);

/// `65535_Keyword`: names that begin with the number of a vendor are the vendor's own.
[[nodiscard]] bool is_of_a_vendor(std::string_view keyword);

}  // namespace servobus::eds
