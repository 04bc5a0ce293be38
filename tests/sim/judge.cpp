#include "tests/sim/judge.hpp"

#include <algorithm>
#include <array>

namespace servobus::sim {
namespace {

using enum Invariant;

// clang-format off
constexpr std::array<Law, 21> laws{{
    {one_owner, "one_owner", "R-CON-30",
     "a device has one exclusive owner at most"},
    {admitted_by_the_rules, "admitted_by_the_rules", "R-CON-15, R-CON-26, R-CON-30, R-CON-32, R-CON-33, R-CON-48",
     "a Forward_Open is granted or refused as who is there already makes it"},
    {target_timeout_early, "target_timeout_early", "R-CON-18, R-CON-19, R-CON-20",
     "a connection of the device does not end before its time, unless it is closed"},
    {target_timeout_late, "target_timeout_late", "R-CON-18, R-CON-19, R-CON-21",
     "a connection of the device ends when its time is over"},
    {originator_timeout_early, "originator_timeout_early", "R-CON-18, R-CON-19, R-CON-20",
     "an originator does not give a connection up before its time"},
    {originator_timeout_late, "originator_timeout_late", "R-CON-18, R-CON-19, R-CON-21",
     "an originator gives a connection up when its time is over"},
    {in_order, "in_order", "R-IO-5",
     "data reaches the application in the order in which it was sent, and once"},
    {from_its_own_connection, "from_its_own_connection", "R-IO-7, R-CON-16, R-CON-37",
     "data reaches the application of the connection for which it was sent, as it was sent"},
    {nothing_good_is_dropped, "nothing_good_is_dropped", "R-IO-5, R-IO-7, R-IO-8",
     "a datagram that fits its connection and is newer is taken"},
    {newest_data_is_in_force, "newest_data_is_in_force", "R-IO-5, R-IO-6",
     "the drive holds what the newest datagram of its running owner has said, and nothing else"},
    {produced_in_time, "produced_in_time", "R-CON-17, R-CON-50, R-CON-51",
     "datagrams leave at the granted interval, and on a change not before the inhibit time is over"},
    {produced_in_sequence, "produced_in_sequence", "R-IO-5",
     "the encapsulation sequence number grows by one with each datagram"},
    {produced_for_somebody, "produced_for_somebody", "R-CON-21, R-CON-37",
     "datagrams leave for open connections only"},
    {request_answered, "request_answered", "R-ENC-22, R-SCN-5",
     "every request is answered, or its time is over, or its TCP connection has ended"},
    {reply_is_asked_for, "reply_is_asked_for", "R-ENC-9, R-ENC-22, R-CON-45",
     "a reply belongs to a request, carries its context and service, and comes once"},
    {explicit_timeout, "explicit_timeout", "R-ENC-24, R-ENC-25, R-CON-47",
     "class 3 connections and TCP connections end when their time is over, or what they stand on has ended, and not before"},
    {drive_stands_without_owner, "drive_stands_without_owner", "R-CON-21, R-IO-6, motion.md",
     "the drive never moves without an owner that runs, once it has had the time to stop"},
    {drive_stops_like_a_quick_stop, "drive_stops_like_a_quick_stop", "R-CON-21, motion.md",
     "a drive in Operation enabled that loses its owner is in Quick stop active"},
    {within_limits, "within_limits", "R-CON-48, R-ENC-26",
     "what a device holds stays below its limits"},
    {nothing_left_behind, "nothing_left_behind", "R-CON-21, R-CON-37, R-ENC-24, R-ENC-25",
     "when everybody has gone and all times are over, nothing is left"},
    {time_goes_on, "time_goes_on", "decision 3",
     "a deadline that has been served is over"},
}};
// clang-format on

}  // namespace

const Law& law(Invariant invariant) { return *std::ranges::find(laws, invariant, &Law::invariant); }

std::optional<Invariant> find_invariant(std::string_view name) {
    const auto found = std::ranges::find(laws, name, &Law::name);
    if (found == laws.end()) return std::nullopt;
    return found->invariant;
}

}  // namespace servobus::sim
