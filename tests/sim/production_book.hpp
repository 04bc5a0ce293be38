// When the datagrams of one direction have to leave, and under which numbers (R-CON-17, R-CON-50 to R-CON-52, R-IO-5).
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "tests/sim/judge.hpp"

namespace servobus::sim {

class ProductionBook {
public:
    struct Terms {
        std::chrono::microseconds interval{};
        std::chrono::microseconds inhibit{};  ///< between two, for all triggers but cyclic
        bool cyclic = true;
    };
    struct Fault {
        Invariant invariant;
        std::string what;
    };

    ProductionBook() = default;
    /// The first one leaves within an interval.
    ProductionBook(const Terms& terms, Time now) : terms_(terms), due_(now + terms.interval) {}

    /// One leaves. `excused`: its program gets a CPU again in this moment, so that it may be late.
    [[nodiscard]] std::optional<Fault> take(std::uint32_t sequence, Time now, bool excused);
    /// One should have left before.
    [[nodiscard]] bool is_overdue(Time now) const { return due_ < now; }
    [[nodiscard]] const Terms& terms() const { return terms_; }

private:
    Terms terms_{};
    Time due_{};                ///< the latest time of the next
    bool phase_known_ = false;  ///< and so no other time is right
    std::optional<Time> last_{};
    std::uint32_t sequence_ = 0;
};

}  // namespace servobus::sim
