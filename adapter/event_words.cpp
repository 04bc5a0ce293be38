#include "adapter/event_words.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace servobus::adapter {
namespace {

namespace event = drive::event;

using IoKind = fault::DisturbIo::Kind;
using ReplyKind = fault::DisturbReplies::Kind;

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
    {"drop-io", NetworkFault(fault::DisturbIo{.kind = IoKind::drop})},
    {"delay-io", NetworkFault(fault::DisturbIo{.kind = IoKind::delay})},
    {"duplicate-io", NetworkFault(fault::DisturbIo{.kind = IoKind::duplicate})},
    {"reorder-io", NetworkFault(fault::DisturbIo{.kind = IoKind::reorder})},
    {"cut-cable", NetworkFault(fault::CutCable{})},
    {"delay-replies", NetworkFault(fault::DisturbReplies{.kind = ReplyKind::delay})},
    {"withhold-replies", NetworkFault(fault::DisturbReplies{.kind = ReplyKind::withhold})},
    {"refuse-open", NetworkFault(fault::RefuseOpen{})},
    {"close-sessions", NetworkFault(fault::CloseSessions{})},
    {"freeze", NetworkFault(fault::Freeze{})},
    {"restart", NetworkFault(fault::Restart{})},
    {"claim-address", NetworkFault(fault::ClaimAddress{})},
    {"restore-network", NetworkFault(fault::RestoreNetwork{}), bare},
});

// What two names share is told apart by what the event holds.
bool is_of(const EventKind& kind, const drive::Event& known, const drive::Event& candidate) {
    if (known.index() != candidate.index()) return false;
    if (const auto* block = std::get_if<event::BlockAxis>(&candidate)) {
        return std::get<event::BlockAxis>(known).blocked == block->blocked;
    }
    if (const auto* encoder = std::get_if<event::LoseEncoder>(&candidate)) {
        return std::get<event::LoseEncoder>(known).lost == encoder->lost;
    }
    if (const auto* supply = std::get_if<event::SetSupply>(&candidate)) return kind.bare == (supply->volts == 0);
    return true;
}

bool is_of(const EventKind&, const NetworkFault& known, const NetworkFault& candidate) {
    if (known.index() != candidate.index()) return false;
    if (const auto* io = std::get_if<fault::DisturbIo>(&candidate)) {
        return std::get<fault::DisturbIo>(known).kind == io->kind;
    }
    if (const auto* replies = std::get_if<fault::DisturbReplies>(&candidate)) {
        return std::get<fault::DisturbReplies>(known).kind == replies->kind;
    }
    return true;
}

bool is_of(const EventKind& kind, const Happening& candidate) {
    return std::visit(
        [&](const auto& each) {
            const auto* known = std::get_if<std::decay_t<decltype(each)>>(&kind.event);
            return known != nullptr && is_of(kind, *known, each);
        },
        candidate);
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
    template <class Integer>
    void code(std::string_view name, Integer field, std::int64_t, std::int64_t, Need) {
        line += fmt::format(" {}=0x{:02X}", name, field);
    }

    std::string line;
};

}  // namespace

std::span<const EventKind> event_kinds() { return kinds; }

const EventKind* find_event_kind(std::string_view name) {
    const auto found = std::ranges::find(kinds, name, &EventKind::name);
    return found != kinds.end() ? &*found : nullptr;
}

std::string describe(const Happening& event) {
    const auto kind = std::ranges::find_if(kinds, [&](const EventKind& each) { return is_of(each, event); });
    if (kind == kinds.end()) return "an event without a name";
    Describe line{std::string(kind->name)};
    auto copy = event;
    if (!kind->bare) visit_fields(copy, line);
    return std::move(line.line);
}

}  // namespace servobus::adapter
