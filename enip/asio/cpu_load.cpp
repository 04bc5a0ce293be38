#include "enip/asio/cpu_load.hpp"

#include <algorithm>
#include <ctime>

namespace servobus::enip::asio {
namespace {

using std::chrono::nanoseconds;

nanoseconds used_by_now() {
    timespec used{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
    return std::chrono::seconds(used.tv_sec) + nanoseconds(used.tv_nsec);
}

}  // namespace

CpuLoad::CpuLoad() : since_(std::chrono::steady_clock::now()), used_(used_by_now()) {}

std::uint16_t CpuLoad::read() {
    const auto now = std::chrono::steady_clock::now();
    if (now - since_ < cpu_load_interval) return load_;
    const auto used = used_by_now();
    constexpr std::int64_t whole = 1000;
    load_ = static_cast<std::uint16_t>(std::min(whole, (used - used_) * whole / nanoseconds(now - since_)));
    since_ = now;
    used_ = used;
    return load_;
}

}  // namespace servobus::enip::asio
