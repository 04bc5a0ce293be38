// What a program that starts servobus-adapter reads before it goes on: one line of JSON, when everything listens.
//
//     {"ready":true,"pid":4711,"drives":[{"address":"127.0.0.1","port":44818,"io_port":2222,...}],"control":["/tmp/c"]}
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drive/device.hpp"

namespace servobus::adapter {

struct ReadyDrive {
    std::optional<std::string> address;  ///< none yet: it comes to it by itself, on the interface
    std::uint16_t port = 0;              ///< TCP and UDP
    std::uint16_t io_port = 0;           ///< UDP of class 0 and 1
    drive::Identity identity;
    std::optional<std::string> interface {};  ///< whose address the drive decides
};

/// Without its line end. `control` are the paths at which control lines are taken.
[[nodiscard]] std::string ready_line(const std::vector<ReadyDrive>& drives, std::int64_t pid,
                                     const std::vector<std::string>& control);

}  // namespace servobus::adapter
