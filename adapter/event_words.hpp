// The words for what happens to a drive from outside, and to its network: names of the events, names of what they carry, and the limits of
// that. Scenario files, control lines and the log all use these.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "adapter/network_fault.hpp"
#include "drive/event.hpp"

namespace servobus::adapter {

/// An event as people name it.
struct EventKind {
    std::string_view name;  ///< `put-obstacle`
    Happening event;        ///< with the defaults of what may be left out
    bool bare = false;      ///< the name says it all: nothing else is given
};

/// All of them, in the order in which they are explained.
[[nodiscard]] std::span<const EventKind> event_kinds();
[[nodiscard]] const EventKind* find_event_kind(std::string_view name);
/// One line: `put-obstacle position=40000 stiffness=50 from_above=false`.
[[nodiscard]] std::string describe(const Happening& event);

/// Whether a field has to be given.
enum class Need : std::uint8_t { required, optional };

inline constexpr std::int64_t max_event_position = 2'147'483'647;  ///< increments, both ways
inline constexpr double max_event_stiffness = 1e6;                 ///< N/mm or Nm/rad
inline constexpr double max_event_mass = 1e4;                      ///< kg or kg m2
inline constexpr double max_event_force = 1e5;                     ///< N or Nm, both ways
inline constexpr double max_event_volts = 100;
inline constexpr double min_event_celsius = -40;
inline constexpr double max_event_celsius = 150;
inline constexpr double max_event_speed = 10'000'000;  ///< increment/s
inline constexpr int max_event_input = 12;
inline constexpr double max_fault_seconds = 86'400;
inline constexpr double max_fault_milliseconds = 60'000;
inline constexpr std::int64_t max_fault_count = 1'000'000;
inline constexpr std::int64_t max_fault_mac = 0xFFFF'FFFF'FFFF;

inline constexpr std::array<std::pair<std::string_view, drive::event::Direction>, 2> event_directions{{
    {"negative", drive::event::Direction::negative},
    {"positive", drive::event::Direction::positive},
}};
inline constexpr std::array<std::pair<std::string_view, drive::event::SafetyFunction>, 4> event_safety_functions{{
    {"sto", drive::event::SafetyFunction::sto},
    {"ss1", drive::event::SafetyFunction::ss1},
    {"ss2", drive::event::SafetyFunction::ss2},
    {"sls", drive::event::SafetyFunction::sls},
}};

inline constexpr std::array<std::pair<std::string_view, fault::Direction>, 3> fault_directions{{
    {"o_to_t", fault::Direction::o_to_t},
    {"t_to_o", fault::Direction::t_to_o},
    {"both", fault::Direction::both},
}};

/// Shows each field of an event to a visitor, which has
///     whole(name, Integer& field, low, high, Need)
///     number(name, double& field, low, high, Need)
///     flag(name, bool& field, Need)
///     word(name, Enumeration& field, pairs of word and meaning, Need)
///     code(name, Integer& field, low, high, Need), for numbers that people know as hexadecimal
template <class Visitor>
void visit_fields(drive::Event& event, Visitor& visitor) {
    namespace event_ns = drive::event;
    std::visit(
        [&](auto& e) {
            using E = std::decay_t<decltype(e)>;
            if constexpr (std::is_same_v<E, event_ns::PutObstacle>) {
                visitor.whole("position", e.position, -max_event_position, max_event_position, Need::required);
                visitor.number("stiffness", e.stiffness, 0, max_event_stiffness, Need::optional);
                visitor.flag("from_above", e.from_above, Need::optional);
            } else if constexpr (std::is_same_v<E, event_ns::SetPayload>) {
                visitor.number("mass", e.mass, 0, max_event_mass, Need::required);
            } else if constexpr (std::is_same_v<E, event_ns::PushAxis>) {
                visitor.number("force", e.force, -max_event_force, max_event_force, Need::required);
            } else if constexpr (std::is_same_v<E, event_ns::SetInput>) {
                visitor.whole("number", e.number, 1, max_event_input, Need::required);
                visitor.flag("high", e.high, Need::optional);
            } else if constexpr (std::is_same_v<E, event_ns::LimitSwitch>) {
                visitor.word("direction", e.direction, event_directions, Need::required);
                visitor.flag("active", e.active, Need::optional);
            } else if constexpr (std::is_same_v<E, event_ns::EmergencyExit>) {
                visitor.flag("active", e.active, Need::optional);
                visitor.flag("keep_power", e.keep_power, Need::optional);
            } else if constexpr (std::is_same_v<E, event_ns::SafetyStop>) {
                visitor.word("function", e.function, event_safety_functions, Need::optional);
                visitor.flag("active", e.active, Need::optional);
            } else if constexpr (std::is_same_v<E, event_ns::SetSupply>) {
                visitor.number("volts", e.volts, 0, max_event_volts, Need::required);
            } else if constexpr (std::is_same_v<E, event_ns::SetTemperature>) {
                visitor.number("celsius", e.celsius, min_event_celsius, max_event_celsius, Need::required);
            } else if constexpr (std::is_same_v<E, event_ns::TurnMaster>) {
                visitor.number("speed", e.speed, -max_event_speed, max_event_speed, Need::required);
            }
        },
        event);
}

template <class Visitor>
void visit_fields(NetworkFault& event, Visitor& visitor) {
    const auto ends = [&](auto& e) {
        visitor.whole("count", e.count, 0, max_fault_count, Need::optional);
        visitor.number("seconds", e.seconds, 0, max_fault_seconds, Need::optional);
    };
    std::visit(
        [&](auto& e) {
            using E = std::decay_t<decltype(e)>;
            if constexpr (std::is_same_v<E, fault::DisturbIo>) {
                visitor.word("direction", e.direction, fault_directions, Need::optional);
                if (e.kind == fault::DisturbIo::Kind::delay) {
                    visitor.number("milliseconds", e.milliseconds, 0, max_fault_milliseconds, Need::required);
                    visitor.number("jitter", e.jitter, 0, max_fault_milliseconds, Need::optional);
                }
                visitor.number("share", e.share, 0, 1, Need::optional);
                ends(e);
            } else if constexpr (std::is_same_v<E, fault::DisturbReplies>) {
                if (e.kind == fault::DisturbReplies::Kind::delay) {
                    visitor.number("milliseconds", e.milliseconds, 0, max_fault_milliseconds, Need::required);
                }
                ends(e);
            } else if constexpr (std::is_same_v<E, fault::CutCable> || std::is_same_v<E, fault::Freeze> ||
                                 std::is_same_v<E, fault::Restart>) {
                visitor.number("seconds", e.seconds, 0, max_fault_seconds, Need::optional);
            } else if constexpr (std::is_same_v<E, fault::RefuseOpen>) {
                visitor.code("general", e.general, 1, 0xFF, Need::optional);
                visitor.code("extended", e.extended, 0, 0xFFFF, Need::required);
                visitor.whole("count", e.count, 1, max_fault_count, Need::optional);
            } else if constexpr (std::is_same_v<E, fault::CloseSessions>) {
                visitor.code("session", e.session, 0, 0xFFFFFFFF, Need::optional);
            } else if constexpr (std::is_same_v<E, fault::ClaimAddress>) {
                visitor.code("mac", e.mac, 1, max_fault_mac, Need::optional);
            }
        },
        event);
}

template <class Visitor>
void visit_fields(Happening& event, Visitor& visitor) {
    std::visit([&](auto& each) { visit_fields(each, visitor); }, event);
}

}  // namespace servobus::adapter
