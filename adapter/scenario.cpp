#include "adapter/scenario.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "adapter/event_json.hpp"

namespace servobus::adapter {
namespace {

using nlohmann::json;

drive::Time from_seconds(double seconds) { return drive::Time(std::llround(seconds * 1e6)); }

std::optional<FileError> read_entry(const JsonDocument& document, std::size_t index, const json& members,
                                    Timetable& timetable) {
    const auto pointer = fmt::format("/events/{}", index);
    double at = 0;
    auto event = read_event(document, pointer, members,
                            {.setters = {{"at", number(at, from_to(0, max_scenario_seconds))}}, .required = {"at"}});
    if (auto* error = std::get_if<FileError>(&event)) return *error;
    timetable.entries.push_back({from_seconds(at), std::get<Happening>(event)});
    return std::nullopt;
}

std::optional<FileError> read_entries(const JsonDocument& document, const json& events, Timetable& timetable) {
    const Walk walk(document);
    if (events.size() > max_scenario_events) {
        return walk.error("", "events", fmt::format("holds at most {} events", max_scenario_events));
    }
    for (std::size_t i = 0; i < events.size(); ++i) {
        if (!events[i].is_object()) return walk.error("", "events", fmt::format("holds no event at place {}", i + 1));
        if (auto error = read_entry(document, i, events[i], timetable)) return error;
    }
    std::ranges::stable_sort(timetable.entries, {}, &Timetable::Entry::at);
    return std::nullopt;
}

Setter events_setter(const json*& events) {
    return [&events](const json& value) -> Reason {
        if (!value.is_array()) return "must be a list of events in square brackets";
        events = &value;
        return {};
    };
}

}  // namespace

std::variant<Timetable, FileError> parse_scenario(const std::string& text) {
    auto parsed = parse_settings(text);
    if (auto* error = std::get_if<FileError>(&parsed)) return *error;
    const auto& document = std::get<JsonDocument>(parsed);
    const Walk walk(document);
    Timetable timetable;
    const json* events = nullptr;
    double period = 0;
    const Setters setters{
        {"events", events_setter(events)},
        {"repeat_every", number(period, from_to(min_scenario_period_seconds, max_scenario_seconds))},
    };
    if (auto error = walk.object(document.root, "", setters, {"events"})) return *error;
    if (auto error = read_entries(document, *events, timetable)) return *error;
    if (!document.root.contains("repeat_every")) return timetable;
    timetable.repeat_every = from_seconds(period);
    if (!timetable.entries.empty() && timetable.entries.back().at > *timetable.repeat_every) {
        return walk.error("", "repeat_every", "must not be less than the time of the last event");
    }
    return timetable;
}

std::variant<Timetable, FileError> load_scenario(const std::filesystem::path& file) {
    const auto content = read_file(file);
    if (const auto* error = std::get_if<FileError>(&content)) return *error;
    return parse_scenario(std::get<std::string>(content));
}

}  // namespace servobus::adapter
