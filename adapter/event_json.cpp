#include "adapter/event_json.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <string_view>
#include <system_error>
#include <utility>

#include "adapter/event_words.hpp"

namespace servobus::adapter {
namespace {

using nlohmann::json;

// A number, or a text such as "0x0113".
template <class Integer>
Setter code_number(Integer& field, std::int64_t low, std::int64_t high) {
    return [&field, low, high](const json& value) -> Reason {
        if (!value.is_string()) return whole_number(field, low, high)(value);
        const auto& text = value.get_ref<const std::string&>();
        std::int64_t number = 0;
        const bool hexadecimal = text.starts_with("0x") || text.starts_with("0X");
        const auto digits = std::string_view(text).substr(hexadecimal ? 2 : 0);
        const auto [end, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), number, hexadecimal ? 16 : 10);
        const bool whole = error == std::errc() && end == digits.data() + digits.size();
        if (!whole || number < low || number > high) {
            return fmt::format("must be a whole number from {} to {}, or a text such as \"0x0113\"", low, high);
        }
        field = static_cast<Integer>(number);
        return {};
    };
}

// Collects a setter for each field that an event has.
struct Collect {
    template <class Integer>
    void whole(const std::string& name, Integer& field, std::int64_t low, std::int64_t high, Need need) {
        add(name, whole_number(field, low, high), need);
    }
    void number(const std::string& name, double& field, double low, double high, Need need) {
        add(name, adapter::number(field, from_to(low, high)), need);
    }
    void flag(const std::string& name, bool& field, Need need) { add(name, adapter::flag(field), need); }
    template <class Word, class Words>
    void word(const std::string& name, Word& field, const Words& words, Need need) {
        add(name, one_of(field, words), need);
    }
    template <class Integer>
    void code(const std::string& name, Integer& field, std::int64_t low, std::int64_t high, Need need) {
        add(name, code_number(field, low, high), need);
    }

    void add(const std::string& name, Setter setter, Need need) {
        into.setters.emplace(name, std::move(setter));
        if (need == Need::required) into.required.push_back(name);
    }

    BesideEvent& into;
};

const EventKind* kind_of(const json& members) {
    const auto name = members.find("event");
    return name != members.end() && name->is_string() ? find_event_kind(name->get_ref<const std::string&>()) : nullptr;
}

FileError no_event(const Walk& walk, const std::string& pointer, const json& members) {
    if (!members.contains("event")) return walk.error(pointer, "'event' is missing");
    std::string names;
    for (const auto& kind : event_kinds()) names += fmt::format("{}{}", names.empty() ? "" : ", ", kind.name);
    return walk.error(pointer, "event", fmt::format("must be one of {}", names));
}

}  // namespace

std::variant<Happening, FileError> read_event(const JsonDocument& document, const std::string& pointer,
                                              const json& members, BesideEvent beside) {
    const Walk walk(document);
    const auto* kind = kind_of(members);
    if (kind == nullptr) return no_event(walk, pointer, members);
    auto event = kind->event;
    Collect collect{beside};
    if (!kind->bare) visit_fields(event, collect);
    beside.setters.emplace("event", [](const json&) { return Reason(); });
    if (auto error = walk.object(members, pointer, beside.setters, beside.required)) return *error;
    return event;
}

}  // namespace servobus::adapter
