// Makes a scenario that fails as small as it gets while it fails for the same reason.
#pragma once

#include <cstddef>
#include <functional>

#include "tests/sim/judge.hpp"
#include "tests/sim/scenario.hpp"

namespace servobus::sim {

/// Plays a scenario; the invariant that it breaks, if any, and when.
struct Failure {
    Invariant invariant;
    microseconds at;
};
using Play = std::function<std::optional<Failure>(const Scenario&)>;

struct Shrunk {
    Scenario scenario;
    Failure failure;
    std::size_t plays = 0;
};

/// `scenario` fails with `failure`. At most `most_plays` are tried.
[[nodiscard]] Shrunk shrink(Scenario scenario, Failure failure, const Play& play, std::size_t most_plays = 600);

}  // namespace servobus::sim
