#include "enip/asio/scheduling.hpp"

#include <fmt/format.h>
#include <sched.h>
#include <sys/mman.h>

#include <cerrno>
#include <system_error>

namespace servobus::enip::asio {
namespace {

std::string reason(int error) { return std::generic_category().message(error); }

std::optional<std::string> use_cpu(int cpu) {
    cpu_set_t set;
    CPU_ZERO(&set);
    if (cpu >= 0 && cpu < CPU_SETSIZE) {
        CPU_SET(static_cast<std::size_t>(cpu), &set);
        if (sched_setaffinity(0, sizeof set, &set) == 0) return std::nullopt;
    } else {
        errno = EINVAL;
    }
    if (errno == EINVAL) return fmt::format("CPU {} is not there, or not for this process", cpu);
    return fmt::format("it may not run on CPU {} only: {}", cpu, reason(errno));
}

std::optional<std::string> lock_memory() {
    if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return std::nullopt;
    return fmt::format("memory cannot be locked: {}; it takes the capability CAP_IPC_LOCK or a larger 'ulimit -l'",
                       reason(errno));
}

std::optional<std::string> use_priority(int priority) {
    const sched_param parameters{.sched_priority = priority};
    // Threads that come later are for what may take long, and run as usual.
    if (sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters) == 0) return std::nullopt;
    if (errno == EINVAL) {
        return fmt::format("real-time priority {} is not there: it is {} to {}", priority,
                           sched_get_priority_min(SCHED_FIFO), sched_get_priority_max(SCHED_FIFO));
    }
    return fmt::format("no real-time priority {}: {}; it takes the capability CAP_SYS_NICE or a larger 'ulimit -r'",
                       priority, reason(errno));
}

}  // namespace

std::optional<std::string> apply(const Scheduling& scheduling) {
    if (scheduling.cpu) {
        if (auto refused = use_cpu(*scheduling.cpu)) return refused;
    }
    if (scheduling.lock_memory) {
        if (auto refused = lock_memory()) return refused;
    }
    return scheduling.realtime_priority ? use_priority(*scheduling.realtime_priority) : std::nullopt;
}

}  // namespace servobus::enip::asio
