// Runs a sequence over a link: writes, polls, shows how far it is, records, and minds Ctrl-C.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "scanner/axis_sequence.hpp"
#include "scanner/cli/axis_link.hpp"
#include "scanner/cli/console.hpp"
#include "scanner/cli/interruption.hpp"
#include "scanner/cli/recording.hpp"

namespace servobus::scanner::cli {

/// Where a motion leads, for the bar.
using Way = std::pair<std::int64_t, std::int64_t>;

/// How far a motion is: on a terminal one line that is written over, otherwise a line for each step.
class Progress {
public:
    Progress(const Console& console, std::optional<Way> way) : console_(console), way_(std::move(way)) {}
    ~Progress() { clear(); }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void step(const std::string& goal);
    void moved(const AxisState& state, const std::string& goal);
    void clear();

private:
    const Console& console_;
    std::optional<Way> way_;
    std::chrono::steady_clock::time_point next_{};
    bool shown_ = false;
};

class AxisRunner {
public:
    /// All of them outlive it. `interval` is the time between two looks; with `recording` each look is kept, or each
    /// sample of a link that has its own.
    AxisRunner(const Console& console, AxisLink& link, const Interruption& interruption, Time interval, bool recording);

    enum class End : std::uint8_t { done, failed, interrupted };

    End run(AxisSteps steps, std::optional<Way> way = {});
    /// Looks at the axis for that long.
    End watch(Time duration);
    struct Halt {
        bool stands = false;
        std::string text;  ///< what became of it
    };
    /// After Ctrl-C: down to standstill, unless the axis stands.
    [[nodiscard]] Halt halt();

    /// Reads further values into state().
    [[nodiscard]] std::optional<Failure> read(std::span<const AxisValue> values) { return link_.read(values, state_); }

    /// Reads what can be read when the axis is not moved over this link any more.
    [[nodiscard]] std::optional<Failure> refresh();

    [[nodiscard]] const AxisState& state() const { return state_; }
    /// Why the last run failed.
    [[nodiscard]] const Failure& failure() const { return failure_; }
    [[nodiscard]] const std::optional<AxisWrite>& refused() const { return link_.refused(); }
    /// From the first word of the last run's motion to its end, in seconds.
    [[nodiscard]] double seconds() const { return seconds_; }
    [[nodiscard]] std::int64_t largest_following_error() const { return largest_following_error_; }
    [[nodiscard]] const Samples& samples() const { return samples_; }

private:
    using Clock = std::chrono::steady_clock;

    [[nodiscard]] Time now() const;
    /// Waits until it is time to look again, and looks.
    [[nodiscard]] bool look(std::span<const AxisValue> needed, bool in_motion);
    [[nodiscard]] bool act(AxisSequence& sequence);
    End fail(const AxisSequence& sequence);
    void note_motion(const AxisSequence& sequence, bool was_in_motion);

    const Console& console_;
    AxisLink& link_;
    const Interruption& interruption_;
    Clock::duration interval_;
    bool recording_;
    Clock::time_point start_ = Clock::now();
    Clock::time_point next_look_ = start_;
    AxisState state_;
    Failure failure_;
    std::optional<Time> motion_began_;
    double seconds_ = 0;
    std::int64_t largest_following_error_ = 0;
    Samples samples_;
};

}  // namespace servobus::scanner::cli
