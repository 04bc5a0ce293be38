// Reads the fields of one entry, and writes down what is wrong with them. For the readers of this folder.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "eds/document.hpp"
#include "eds/field_values.hpp"
#include "eds/path_pattern.hpp"

namespace servobus::eds {

class EntryReader {
public:
    EntryReader(const Entry& entry, std::vector<Finding>& findings) : entry_(entry), findings_(findings) {}

    [[nodiscard]] const Entry& entry() const { return entry_; }
    [[nodiscard]] const Field& field(std::size_t number) const { return entry_.field(number); }

    /// A whole number of 0 to the highest of `T`; nullopt for an empty field, and with a finding for anything else.
    template <class T>
    std::optional<T> number(std::size_t at, std::string_view what) {
        const auto value = integer_as<T>(field(at));
        if (!value && !field(at).is_empty()) {
            object(at, fmt::format("no {} of 0 to {}", what, std::numeric_limits<T>::max()));
        }
        return value;
    }

    /// A string; a word is taken for one, with a finding.
    std::string text(std::size_t at) {
        if (field(at).kind == Field::Kind::word) {
            note(Severity::warning, field(at).line, fmt::format("'{}' should be in quotes", shown(field(at).value)));
        }
        return field(at).value;
    }

    std::string word(std::size_t at) {
        if (field(at).kind == Field::Kind::text) {
            note(Severity::warning, field(at).line,
                 fmt::format("'{}' should not be in quotes", shown(field(at).value)));
        }
        return field(at).value;
    }

    PathPattern path(std::size_t at) {
        auto pattern = path_pattern(field(at));
        if (!pattern) object(at, "no path");
        return pattern ? std::move(*pattern) : PathPattern{};
    }

    /// Anything that a function of field_values.hpp reads.
    template <class T>
    std::optional<T> value(std::size_t at, std::optional<T> (*read)(const Field&), std::string_view what) {
        auto result = read(field(at));
        if (!result && !field(at).is_empty()) object(at, fmt::format("no {}", what));
        return result;
    }

    /// `ParamX: field 5 is 'abc', no data type ...`.
    void object(std::size_t at, std::string_view why) {
        note(Severity::error, field(at).line, fmt::format("field {} is '{}', {}", at, shown(field(at).value), why));
    }
    void note(Severity severity, std::string_view words) { note(severity, entry_.line, words); }

private:
    void note(Severity severity, std::size_t line, std::string_view words) {
        if (findings_.size() >= 2 * max_findings) return;
        findings_.push_back({line, severity, fmt::format("{}: {}", shown(entry_.keyword), words)});
    }

    const Entry& entry_;
    std::vector<Finding>& findings_;
};

}  // namespace servobus::eds
