// Settings out of JSON: every member of an object has a setter or is an error, and every error has its place.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "adapter/json_document.hpp"
#include "adapter/text_file.hpp"

namespace servobus::adapter {

/// Why one value is not taken; the walk adds where it stands. Empty: taken.
using Reason = std::string;
using Setter = std::function<Reason(const nlohmann::json&)>;
using Setters = std::map<std::string, Setter>;

/// The document of a text that must be one object; `what` the text is, a file or a line, for the error.
[[nodiscard]] std::variant<JsonDocument, FileError> parse_settings(const std::string& text,
                                                                   std::string_view what = "file");

/// One object of the document after the other; `pointer` is the JSON pointer to it, empty for the root.
class Walk {
public:
    explicit Walk(const JsonDocument& document) : document_(document) {}

    /// Gives each member to its setter.
    [[nodiscard]] std::optional<FileError> object(const nlohmann::json& members, const std::string& pointer,
                                                  const Setters& setters) const;
    /// The same, when these members must be there.
    [[nodiscard]] std::optional<FileError> object(const nlohmann::json& members, const std::string& pointer,
                                                  const Setters& setters,
                                                  const std::vector<std::string>& required) const;
    /// About one member of the object.
    [[nodiscard]] FileError error(const std::string& pointer, const std::string& key, const Reason& reason) const;
    /// About the object itself.
    [[nodiscard]] FileError error(const std::string& pointer, const Reason& reason) const;

private:
    [[nodiscard]] Position position(const std::string& pointer) const;

    const JsonDocument& document_;
};

/// What a number may be: from `low` to `high`, or above `low` when that itself is not meant.
struct Range {
    double low;
    double high;
    bool above = false;
};
[[nodiscard]] constexpr Range from_to(double low, double high) { return {low, high, false}; }
[[nodiscard]] constexpr Range above_to(double low, double high) { return {low, high, true}; }

[[nodiscard]] Setter number(double& target, Range range);
[[nodiscard]] Setter flag(bool& target);
[[nodiscard]] Setter text(std::string& target);
[[nodiscard]] Setter text(std::optional<std::string>& target);

template <class Number>
[[nodiscard]] Setter whole_number(Number& target, std::int64_t low, std::int64_t high) {
    return [&target, low, high](const nlohmann::json& value) -> Reason {
        // Beyond the signed numbers there is none that a setting could take.
        const bool fits = value.is_number_integer() &&
                          !(value.is_number_unsigned() && value.get<std::uint64_t>() > std::uint64_t{INT64_MAX}) &&
                          value.get<std::int64_t>() >= low && value.get<std::int64_t>() <= high;
        if (!fits) return fmt::format("must be a whole number from {} to {}", low, high);
        target = static_cast<Number>(value.get<std::int64_t>());
        return {};
    };
}

template <class Number>
[[nodiscard]] Setter whole_number(std::optional<Number>& target, std::int64_t low, std::int64_t high) {
    return [&target, low, high](const nlohmann::json& value) -> Reason {
        Number found{};
        auto reason = whole_number(found, low, high)(value);
        if (reason.empty()) target = found;
        return reason;
    };
}

/// `words` are pairs of a word and its meaning; they outlive the setter.
template <class Meaning, class Words>
[[nodiscard]] Setter one_of(Meaning& target, const Words& words) {
    return [&target, &words](const nlohmann::json& value) -> Reason {
        std::string all;
        for (const auto& [word, meaning] : words) {
            if (value.is_string() && value.get_ref<const std::string&>() == word) {
                target = meaning;
                return {};
            }
            all += fmt::format("{}\"{}\"", all.empty() ? "" : ", ", word);
        }
        return fmt::format("must be one of {}", all);
    };
}

}  // namespace servobus::adapter
