// How the operating system treats a thread that keeps times: by options, since most machines are not made for it.
#pragma once

#include <optional>
#include <string>

namespace servobus::enip::asio {

struct Scheduling {
    std::optional<int> realtime_priority;  ///< 1 to 99: before every ordinary thread (SCHED_FIFO)
    bool lock_memory = false;              ///< nothing is paged out
    std::optional<int> cpu;                ///< the only one that the thread runs on
};

/// For the calling thread, and the memory of its process. What was not permitted, in a sentence that names what is
/// missing; nothing more is tried then.
[[nodiscard]] std::optional<std::string> apply(const Scheduling& scheduling);

}  // namespace servobus::enip::asio
