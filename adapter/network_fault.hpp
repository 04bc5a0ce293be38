// What goes wrong between a drive and its peers, for people who test their own scanner. Beside drive::Event this is what
// scenarios and control lines are made of.
#pragma once

#include <cstdint>
#include <variant>

#include "drive/event.hpp"

namespace servobus::adapter::fault {

/// As the drive sees it: what it receives, what it sends.
enum class Direction : std::uint8_t { o_to_t, t_to_o, both };

/// I/O datagrams are lost, late, doubled, or overtaken by the next one of their connection.
struct DisturbIo {
    enum class Kind : std::uint8_t { drop, delay, duplicate, reorder };
    Kind kind = Kind::drop;
    Direction direction = Direction::both;
    double share = 1;         ///< of the datagrams, by chance
    double milliseconds = 0;  ///< of delay
    double jitter = 0;        ///< up to so many milliseconds more, by chance
    std::int64_t count = 0;   ///< over after so many datagrams that it has met; 0: not by count
    double seconds = 0;       ///< over after this time; 0: not by time
};
/// Replies to explicit requests, SendRRData and SendUnitData; the request is carried out all the same.
struct DisturbReplies {
    enum class Kind : std::uint8_t { delay, withhold };
    Kind kind = Kind::delay;
    double milliseconds = 0;
    std::int64_t count = 0;
    double seconds = 0;
};
/// Nothing goes in or out. The drive lives on: its connections time out. 0 seconds: until it is restored.
struct CutCable {
    double seconds = 0;
};
/// The next Forward_Opens are refused, whatever they ask for.
struct RefuseOpen {
    std::int64_t count = 1;
    std::uint16_t general = 1;
    std::uint16_t extended = 0;  ///< 0: none
};
/// TCP connections with a session end at once: that of this handle, or all with 0.
struct CloseSessions {
    std::uint32_t session = 0;
};
/// The bus side of the drive stands still: nothing is answered or sent, and its timeouts do not run. The axis goes on.
struct Freeze {
    double seconds = 0;
};
/// Power off and on, with a pause during which nobody is there.
struct Restart {
    double seconds = 1;
};
/// Another node says that it has the drive's address. Twice within ten seconds, and the drive gives it up for as long.
struct ClaimAddress {
    std::uint64_t mac = 0x02'00'00'00'00'01;  ///< of the other node
};
/// All of the above is over, but for a claim.
struct RestoreNetwork {};

}  // namespace servobus::adapter::fault

namespace servobus::adapter {

using NetworkFault =
    std::variant<fault::DisturbIo, fault::DisturbReplies, fault::CutCable, fault::RefuseOpen, fault::CloseSessions,
                 fault::Freeze, fault::Restart, fault::ClaimAddress, fault::RestoreNetwork>;

/// What happens to a drive: to its machine, or to its network.
using Happening = std::variant<drive::Event, NetworkFault>;

}  // namespace servobus::adapter
