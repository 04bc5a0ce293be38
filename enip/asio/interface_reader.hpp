// Speed, duplex, link and counters of an interface of this machine.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "enip/interface_facts.hpp"
#include "enip/time.hpp"

struct ethtool_cmd;
struct rtnl_link_stats;

namespace servobus::enip::asio {

/// Between two looks at an interface; who asks more often hears the same again.
inline constexpr std::chrono::milliseconds interface_look_interval{100};

/// Asks the system when it is asked itself, which takes some 10 us. Not for the path of I/O data.
class InterfaceReader {
public:
    explicit InterfaceReader(std::string name) : name_(std::move(name)) {}

    /// An interface that is not there has no link, and has counted nothing.
    [[nodiscard]] const InterfaceFacts& read();

private:
    std::string name_;
    InterfaceFacts facts_;
    std::optional<Time> read_at_;
};

/// What the kernel has counted, by the names of R-ETH-4 and R-ETH-5. It counts all collisions together; they are told as
/// single ones.
[[nodiscard]] InterfaceCounters interface_counters(const rtnl_link_stats& stats);
[[nodiscard]] MediaCounters media_counters(const rtnl_link_stats& stats);

/// What a driver says of speed, duplex and negotiation. Without a link a speed means nothing.
void tell_link(const ethtool_cmd& settings, InterfaceFacts& facts);

}  // namespace servobus::enip::asio
