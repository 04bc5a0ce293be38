#include "tests/sim/production_book.hpp"

#include <fmt/format.h>

namespace servobus::sim {
namespace {

/// What is sent afterwards when a program was held up (docs/adapter.md).
constexpr int most_intervals_late = 16;

std::int64_t in_microseconds(Time::duration time) {
    return std::chrono::duration_cast<std::chrono::microseconds>(time).count();
}

}  // namespace

std::optional<ProductionBook::Fault> ProductionBook::take(std::uint32_t sequence, Time now, bool excused) {
    std::optional<Fault> fault;
    if (last_ && sequence != sequence_ + 1) {
        fault = {Invariant::produced_in_sequence, fmt::format("number {} follows {}", sequence, sequence_)};
    }
    sequence_ = sequence;
    const bool early = last_ && phase_known_ && now < due_;
    if (now > due_ && !excused) {
        fault = {Invariant::produced_in_time, fmt::format("a datagram is {} us late", in_microseconds(now - due_))};
    }
    if (early && !excused && (terms_.cyclic || now - *last_ < terms_.inhibit)) {
        fault = {Invariant::produced_in_time, fmt::format("a datagram is {} us early, {} us after the one before",
                                                          in_microseconds(due_ - now), in_microseconds(now - *last_))};
    }
    // Within its interval the first one may leave at any time, and tells when the others are due; not one that was held up.
    // What a change has sent starts a new interval.
    if (early || !phase_known_) {
        due_ = now + terms_.interval;
        phase_known_ = !excused;
    } else {
        due_ += terms_.interval;
        if (now - due_ >= most_intervals_late * terms_.interval) {
            due_ += ((now - due_) / terms_.interval + 1) * terms_.interval;
        }
    }
    last_ = now;
    return fault;
}

}  // namespace servobus::sim
