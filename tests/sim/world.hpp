// A simulation: a scenario, played against the real adapter and the real originator, and what came of it.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/sim/drive_site.hpp"
#include "tests/sim/node_site.hpp"
#include "tests/sim/scenario.hpp"

namespace servobus::sim {

struct Statistics {
    std::uint64_t events = 0;
    WireCounters wire;
    TargetWatch::Counters targets;
    NodeSite::Counters originators;
    std::chrono::duration<double> simulated{};
};

struct Outcome {
    std::optional<Violation> violation;
    std::chrono::microseconds failed_at{};  ///< since the beginning
    std::vector<std::string> last;          ///< what the scenario did before it
    std::vector<std::string> arrived;       ///< and what came out of the lines
    Statistics statistics;
};

class World {
public:
    explicit World(const Scenario& scenario);

    /// To the end, or to the first violation. `trace`: who wants to hear of each action.
    [[nodiscard]] Outcome run(const std::function<void(const std::string&)>& trace = {});

    // For tests that break something on purpose.
    [[nodiscard]] EventQueue& queue() { return queue_; }
    [[nodiscard]] DriveSite& drive(unsigned number) { return *drives_[number]; }

private:
    void perform(const Action& action);
    void forge(unsigned node, unsigned drive);
    void leave();
    void look_around();
    [[nodiscard]] bool run_until(Time end);
    [[nodiscard]] Statistics statistics() const;

    Scenario scenario_;
    EventQueue queue_;
    Time began_;
    Judge judge_;
    Wire wire_;
    Neighbourhood neighbourhood_;
    std::vector<std::unique_ptr<DriveSite>> drives_;
    std::vector<std::unique_ptr<NodeSite>> nodes_;
    std::deque<std::string> last_;
    std::function<void(const std::string&)> trace_;
};

}  // namespace servobus::sim
