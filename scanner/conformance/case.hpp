// What the conformance suite is made of: cases, each from one rule, in groups.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace servobus::scanner::conformance {

class Bench;

enum class Group : std::uint8_t {
    encapsulation,
    sessions,
    packet,
    ucmm,
    class3,
    objects,
    keys,
    forward_open,
    null_open,
    forward_close,
    ownership,
    multicast,
    production,
    timeouts,
    inactivity,
    malformed,
};

struct GroupRow {
    Group group;
    std::string_view name;   ///< for --group
    std::string_view title;  ///< what it checks, for people
};

/// In the order in which they run.
inline constexpr std::array<GroupRow, 16> groups{{
    {Group::encapsulation, "encapsulation", "encapsulation header and commands, over TCP and UDP"},
    {Group::sessions, "sessions", "registering and leaving sessions"},
    {Group::packet, "packet", "common packet format"},
    {Group::ucmm, "ucmm", "unconnected messages: services, paths, errors"},
    {Group::class3, "class3", "explicit connections"},
    {Group::objects, "objects", "the standard objects"},
    {Group::keys, "keys", "electronic keys"},
    {Group::forward_open, "forward-open", "legal and illegal Forward_Opens"},
    {Group::null_open, "null-open", "Forward_Opens that open nothing"},
    {Group::forward_close, "forward-close", "Forward_Close"},
    {Group::ownership, "ownership", "who owns, who looks on, who only listens"},
    {Group::multicast, "multicast", "inputs that go to a group"},
    {Group::production, "production", "I/O datagrams and their intervals"},
    {Group::timeouts, "timeouts", "connections that nobody keeps alive"},
    {Group::inactivity, "inactivity", "TCP connections that are silent"},
    {Group::malformed, "malformed", "what is no message, and the device afterwards"},
}};

[[nodiscard]] constexpr const GroupRow& row_of(Group group) { return groups[static_cast<std::size_t>(group)]; }

/// `writes`: the device is written to, reset or owned, which needs the user's leave.
enum class Manner : std::uint8_t { reads, writes };

struct Case {
    std::string_view id;  ///< `ENC-07`; stays the same for good
    Group group;
    std::string_view title;  ///< what must be so, without a full stop
    std::string_view rule;   ///< `R-ENC-9`
    std::string_view words;  ///< the rule in one sentence
    Manner manner;
    void (*run)(Bench&);
};

/// In the order of `groups`.
[[nodiscard]] std::span<const Case> all_cases();

enum class Outcome : std::uint8_t {
    pass,
    advisory,  ///< allowed, but unusual; or against a rule that not everybody reads like this
    fail,
    skipped,
};
[[nodiscard]] std::string_view name(Outcome outcome);

}  // namespace servobus::scanner::conformance
