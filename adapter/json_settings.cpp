#include "adapter/json_settings.hpp"

#include <utility>

namespace servobus::adapter {

using nlohmann::json;

std::variant<JsonDocument, FileError> parse_settings(const std::string& text, std::string_view what) {
    auto parsed = parse_json(text);
    if (const auto* error = std::get_if<JsonError>(&parsed)) {
        return FileError{error->position.line, error->position.column, error->reason};
    }
    auto& document = std::get<JsonDocument>(parsed);
    if (!document.root.is_object()) return FileError{1, 1, fmt::format("the {} must hold one object in braces", what)};
    return std::move(document);
}

std::optional<FileError> Walk::object(const json& members, const std::string& pointer, const Setters& setters) const {
    for (const auto& [key, value] : members.items()) {
        const auto setter = setters.find(key);
        if (setter == setters.end()) {
            std::string known;
            for (const auto& [name, each] : setters) known += fmt::format("{}{}", known.empty() ? "" : ", ", name);
            return error(pointer, key, fmt::format("is not a setting; here may stand: {}", known));
        }
        const auto reason = setter->second(value);
        if (!reason.empty()) return error(pointer, key, reason);
    }
    return std::nullopt;
}

std::optional<FileError> Walk::object(const json& members, const std::string& pointer, const Setters& setters,
                                      const std::vector<std::string>& required) const {
    if (auto wrong = object(members, pointer, setters)) return wrong;
    for (const auto& key : required) {
        if (!members.contains(key)) return error(pointer, fmt::format("'{}' is missing", key));
    }
    return std::nullopt;
}

FileError Walk::error(const std::string& pointer, const std::string& key, const Reason& reason) const {
    const auto [line, column] = position((json::json_pointer(pointer) / key).to_string());
    return {line, column, fmt::format("'{}' {}", key, reason)};
}

FileError Walk::error(const std::string& pointer, const Reason& reason) const {
    const auto [line, column] = position(pointer);
    return {line, column, reason};
}

Position Walk::position(const std::string& pointer) const {
    const auto found = document_.positions.find(pointer);
    return found != document_.positions.end() ? found->second : Position{};
}

Setter number(double& target, Range range) {
    return [&target, range](const json& value) -> Reason {
        const double found = value.is_number() ? value.get<double>() : 0;
        const bool fits =
            value.is_number() && found <= range.high && found >= range.low && !(range.above && found == range.low);
        if (!fits) {
            return range.above ? fmt::format("must be a number above {}, {} at most", range.low, range.high)
                               : fmt::format("must be a number from {} to {}", range.low, range.high);
        }
        target = found;
        return {};
    };
}

Setter flag(bool& target) {
    return [&target](const json& value) -> Reason {
        if (!value.is_boolean()) return "must be true or false";
        target = value.get<bool>();
        return {};
    };
}

Setter text(std::string& target) {
    return [&target](const json& value) -> Reason {
        if (!value.is_string() || value.get_ref<const std::string&>().empty()) return "must be a text";
        target = value.get<std::string>();
        return {};
    };
}

Setter text(std::optional<std::string>& target) {
    return [&target](const json& value) -> Reason {
        std::string found;
        auto reason = text(found)(value);
        if (reason.empty()) target = std::move(found);
        return reason;
    };
}

}  // namespace servobus::adapter
