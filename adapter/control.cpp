#include "adapter/control.hpp"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>

#include "adapter/event_json.hpp"
#include "drive/ds402.hpp"

namespace servobus::adapter {
namespace {

// The order in which the members are written is the one in which people read them.
using Answer = nlohmann::ordered_json;
using nlohmann::json;

enum class Query : std::uint8_t { state, axis };
constexpr std::array<std::pair<std::string_view, Query>, 2> queries{{{"state", Query::state}, {"axis", Query::axis}}};

// Where the table has what {"query": "state"} tells.
constexpr drive::Key status_word{0x66, 0x01};
constexpr drive::Key error_number{0x64, 0x04};
struct Told {
    const char* name;
    drive::Key key;
};
constexpr auto told = std::to_array<Told>({
    {"mode", {0x66, 0x21}},        // ModesOfOperationDisplayed
    {"position", {0x66, 0x24}},    // TP, increments
    {"velocity", {0x65, 0x1D}},    // TV, increments/s
    {"current", {0x66, 0x38}},     // TMC, mA
    {"error", error_number},       // TE
    {"error_text", {0x69, 0x01}},  // TES
    {"inputs", {0x65, 0x07}},      // TIX
    {"outputs", {0x65, 0x06}},     // TOX
});

std::string_view word(drive::OutputLevel level) {
    switch (level) {
        case drive::OutputLevel::open:
            return "open";
        case drive::OutputLevel::low:
            return "low";
        case drive::OutputLevel::high:
            return "high";
    }
    return "open";
}

// Output 1 first.
Answer output_wires(const drive::Device& device) {
    auto wires = Answer::array();
    for (int number = 1; number <= drive::digital_outputs; ++number) wires.push_back(word(device.output_wire(number)));
    return wires;
}

std::string text_of(const Answer& answer) { return answer.dump(-1, ' ', false, Answer::error_handler_t::replace); }

std::string refusal(const FileError& error) {
    return control_error(error.column == 0 ? error.reason : fmt::format("column {}: {}", error.column, error.reason));
}

Answer value_of(const drive::Device& device, drive::Key key) {
    const auto* row = device.find(key);
    if (row == nullptr) return nullptr;
    const auto& value = device.store().value(*row);
    if (const auto* number = std::get_if<std::int64_t>(&value)) return *number;
    return std::get<std::string>(value);
}

// The power stage is on in these (004 §4.1); in a fault reaction it still brakes.
bool is_powered(drive::Ds402::State state) {
    using State = drive::Ds402::State;
    return state == State::switched_on || state == State::operation_enabled || state == State::quick_stop_active ||
           state == State::fault_reaction_active;
}

Answer state_of(const Adapter& adapter, enip::Time now) {
    const auto& device = adapter.device();
    Answer answer{{"ok", true}, {"time", std::chrono::duration<double>(adapter.elapsed(now)).count()}};
    if (const auto word = value_of(device, status_word); word.is_number()) {
        const auto bits = static_cast<std::uint16_t>(word.get<std::int64_t>());
        const auto state = drive::Ds402::state_of(bits);
        answer["statusword"] = bits;
        answer["state"] = state ? Answer(drive::Ds402::name(*state)) : Answer(nullptr);
        answer["power"] = state && is_powered(*state);
    }
    for (const auto& [name, key] : told) answer[name] = value_of(device, key);
    answer["output_wires"] = output_wires(device);
    return answer;
}

Answer describe_axis(const drive::AxisKind& axis) {
    Answer answer{{"ok", true},
                  {"key", axis.key},
                  {"name", axis.name},
                  {"motion", axis.motion == drive::AxisKind::Motion::linear ? "linear" : "rotative"},
                  {"increments_per_unit", axis.increments_per_unit},
                  {"travel", axis.travel}};
    if (axis.has_stops) {
        answer["stop_negative"] = axis.stop_negative;
        answer["stop_positive"] = axis.stop_positive;
    }
    return answer;
}

}  // namespace

std::string control_error(std::string_view reason) { return text_of({{"ok", false}, {"error", reason}}); }

std::string Control::answer(std::string_view line, enip::Time now) {
    auto parsed = parse_settings(std::string(line), "line");
    if (const auto* error = std::get_if<FileError>(&parsed)) return refusal(*error);
    const auto& document = std::get<JsonDocument>(parsed);
    if (document.root.contains("query")) {
        auto query = Query::state;
        if (const auto error = Walk(document).object(document.root, "", {{"query", one_of(query, queries)}})) {
            return refusal(*error);
        }
        adapter_.advance(now);
        return text_of(query == Query::state ? state_of(adapter_, now) : describe_axis(axis_));
    }
    const auto event = read_event(document, "", document.root);
    if (const auto* error = std::get_if<FileError>(&event)) return refusal(*error);
    if (!adapter_.device().has_machine())
        return control_error("this drive has no machine that anything could happen to");
    adapter_.inject(std::get<drive::Event>(event), now);
    return text_of({{"ok", true}});
}

}  // namespace servobus::adapter
