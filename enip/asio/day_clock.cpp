#include "enip/asio/day_clock.hpp"

namespace servobus::enip::asio {
namespace {

using std::chrono::nanoseconds;

/// Whoever is interrupted between two readings tries again, so often at most.
constexpr int tries = 4;
/// Readings that are no farther apart are good enough.
constexpr nanoseconds close_enough{2000};

}  // namespace

DayClock::DayClock()
    : DayClock({.steady = [] { return Time(std::chrono::steady_clock::now()); },
                .day = [] { return nanoseconds(std::chrono::system_clock::now().time_since_epoch()); }}) {}

nanoseconds DayClock::ahead(Time now) {
    if (!next_ || now >= *next_) {
        ahead_ = compare();
        next_ = now + day_clock_interval;
    }
    return ahead_;
}

// The clock of the day is read between two readings of the other one: the narrower they are, the truer is their middle.
nanoseconds DayClock::compare() const {
    nanoseconds ahead{0};
    auto narrowest = nanoseconds::max();
    for (int i = 0; i < tries && narrowest > close_enough; ++i) {
        const auto before = clocks_.steady();
        const auto day = clocks_.day();
        const auto width = clocks_.steady() - before;
        if (width >= narrowest) continue;
        narrowest = width;
        ahead = day - (before.time_since_epoch() + width / 2);
    }
    return ahead;
}

}  // namespace servobus::enip::asio
