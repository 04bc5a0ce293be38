// What has to be true whatever happens. The watches look at what goes in and comes out, keep books of their own from it, and
// report here what does not fit.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "enip/time.hpp"

namespace servobus::sim {

using enip::Time;

enum class Invariant : std::uint8_t {
    one_owner,
    admitted_by_the_rules,
    target_timeout_early,
    target_timeout_late,
    originator_timeout_early,
    originator_timeout_late,
    in_order,
    from_its_own_connection,
    nothing_good_is_dropped,
    newest_data_is_in_force,
    produced_in_time,
    produced_in_sequence,
    produced_for_somebody,
    request_answered,
    reply_is_asked_for,
    explicit_timeout,
    drive_stands_without_owner,
    drive_stops_like_a_quick_stop,
    within_limits,
    nothing_left_behind,
    time_goes_on,
};

struct Law {
    Invariant invariant;
    std::string_view name;
    std::string_view rules;  ///< where it is written
    std::string_view words;
};
[[nodiscard]] const Law& law(Invariant invariant);
[[nodiscard]] std::optional<Invariant> find_invariant(std::string_view name);

struct Violation {
    Invariant invariant;
    Time at;
    std::string what;
};

class Judge {
public:
    /// The first one counts; what follows may come from it.
    void report(Invariant invariant, Time at, std::string what) {
        if (!violation_) violation_ = Violation{invariant, at, std::move(what)};
    }
    [[nodiscard]] const std::optional<Violation>& violation() const { return violation_; }

private:
    std::optional<Violation> violation_;
};

}  // namespace servobus::sim
