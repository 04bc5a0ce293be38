#include "adapter/event_words.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace servobus::adapter {
namespace {

namespace event = drive::event;

constexpr bool bare = true;

constexpr auto kinds = std::to_array<EventKind>({
    {"put-obstacle", event::PutObstacle{}},
    {"remove-obstacle", event::RemoveObstacle{}, bare},
    {"block-axis", event::BlockAxis{true}, bare},
    {"release-axis", event::BlockAxis{false}, bare},
    {"set-payload", event::SetPayload{}},
    {"push-axis", event::PushAxis{}},
    {"set-input", event::SetInput{}},
    {"limit-switch", event::LimitSwitch{}},
    {"emergency-exit", event::EmergencyExit{}},
    {"safety-stop", event::SafetyStop{}},
    {"lose-encoder", event::LoseEncoder{true}, bare},
    {"restore-encoder", event::LoseEncoder{false}, bare},
    {"set-supply", event::SetSupply{}},
    {"cut-supply", event::SetSupply{0}, bare},
    {"set-temperature", event::SetTemperature{}},
    {"turn-master", event::TurnMaster{}},
    {"cut-power-stage", event::CutPowerStage{}, bare},
    {"lose-controller", event::LoseController{}, bare},
    {"power-cycle", event::PowerCycle{}, bare},
});

// What two names share is told apart by what the event holds.
bool is_of(const EventKind& kind, const drive::Event& candidate) {
    if (kind.event.index() != candidate.index()) return false;
    if (const auto* block = std::get_if<event::BlockAxis>(&candidate)) {
        return std::get<event::BlockAxis>(kind.event).blocked == block->blocked;
    }
    if (const auto* encoder = std::get_if<event::LoseEncoder>(&candidate)) {
        return std::get<event::LoseEncoder>(kind.event).lost == encoder->lost;
    }
    if (const auto* supply = std::get_if<event::SetSupply>(&candidate)) return kind.bare == (supply->volts == 0);
    return true;
}

struct Describe {
    template <class Integer>
    void whole(std::string_view name, const Integer& field, std::int64_t, std::int64_t, Need) {
        line += fmt::format(" {}={}", name, field);
    }
    void number(std::string_view name, double field, double, double, Need) {
        line += fmt::format(" {}={}", name, field);
    }
    void flag(std::string_view name, bool field, Need) { line += fmt::format(" {}={}", name, field); }
    template <class Word, class Words>
    void word(std::string_view name, Word field, const Words& words, Need) {
        for (const auto& [text, meaning] : words) {
            if (meaning == field) line += fmt::format(" {}={}", name, text);
        }
    }

    std::string line;
};

}  // namespace

std::span<const EventKind> event_kinds() { return kinds; }

const EventKind* find_event_kind(std::string_view name) {
    const auto found = std::ranges::find(kinds, name, &EventKind::name);
    return found != kinds.end() ? &*found : nullptr;
}

std::string describe(const drive::Event& event) {
    const auto kind = std::ranges::find_if(kinds, [&](const EventKind& each) { return is_of(each, event); });
    if (kind == kinds.end()) return "an event without a name";
    Describe line{std::string(kind->name)};
    auto copy = event;
    if (!kind->bare) visit_fields(copy, line);
    return std::move(line.line);
}

}  // namespace servobus::adapter
