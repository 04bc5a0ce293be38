// What a controller does to make an axis move, as tables: write, then wait for a condition with a time limit (000 §3.2,
// 004 §5 and §6). No I/O, and time is an argument; whoever runs a sequence writes and reads for it, over any connection.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drive/time.hpp"
#include "scanner/axis_state.hpp"

namespace servobus::scanner {

using drive::Time;

/// `word & mask == value`.
struct AxisCondition {
    AxisValue word;
    std::uint32_t mask;
    std::uint32_t value;

    [[nodiscard]] bool holds(const AxisState& state) const;
};
using AxisConditions = std::vector<AxisCondition>;  ///< all of them

struct AxisWrite {
    AxisValue to;
    std::int64_t value;

    friend bool operator==(const AxisWrite&, const AxisWrite&) = default;
};

struct AxisStep {
    std::string goal{};  ///< what is waited for: "'Operation enabled'"
    std::vector<AxisWrite> writes{};
    std::vector<AxisConditions> until{};  ///< any of these; without any, the step ends with its last write
    Time limit = std::chrono::seconds(2);
    /// When the limit is over: the sequence has failed, or goes on. Going on is for signs that may be missed, and for
    /// what is to last.
    bool may_expire = false;
    AxisConditions keeps{};  ///< what must not end while it waits
    std::optional<AxisCondition> fails{};
    std::string failure{};      ///< what `fails` means
    bool faults_end_it = true;  ///< the fault bit ends the sequence
    bool in_motion = false;
};
using AxisSteps = std::vector<AxisStep>;

class AxisSequence {
public:
    enum class Wants : std::uint8_t { write, look, nothing };

    explicit AxisSequence(AxisSteps steps) : steps_(std::move(steps)) {}

    /// What is to be done next: write next_write() and tell written(), or read the axis and tell saw(). `nothing` when
    /// it has come to its end, or failed.
    [[nodiscard]] Wants wants() const;
    [[nodiscard]] const AxisWrite& next_write() const { return step().writes[write_]; }
    void written(Time now);
    void saw(const AxisState& state, Time now);

    [[nodiscard]] bool failed() const { return trouble_ != Trouble::none; }
    /// Why it failed, with what the axis says now.
    [[nodiscard]] std::string failure_text(const AxisState& state) const;
    /// The present step; the last one when it is at its end.
    [[nodiscard]] const AxisStep& step() const { return steps_[std::min(step_, steps_.size() - 1)]; }
    [[nodiscard]] std::size_t step_number() const { return step_; }

private:
    enum class Trouble : std::uint8_t { none, time, fault, lost, told };

    void advance();
    [[nodiscard]] Trouble trouble_in(const AxisState& state) const;

    AxisSteps steps_;
    std::size_t step_ = 0;
    std::size_t write_ = 0;
    Time began_ = Time::min();  ///< of the present step; min: not yet
    Trouble trouble_ = Trouble::none;
};

/// What has to be read before each saw().
[[nodiscard]] std::span<const AxisValue> followed_values();
/// What the functions below look at in a state.
[[nodiscard]] std::span<const AxisValue> planning_values();

/// Control words 0x06, 0x07, 0x0F. An axis that is enabled stays so.
[[nodiscard]] AxisSteps enable_steps(const AxisState& state);
[[nodiscard]] AxisSteps disable_steps(const AxisState& state);
struct AxisReference {
    int method = 1;
    std::optional<std::int64_t> sensor_speed{};  ///< of rotative motors; 0: there is no sensor
    std::optional<std::int64_t> z_mark_speed{};  ///< of rotative motors; 0: there is no Z-mark
};
/// 000 §3.2.1.1 and §3.2.2; leaves in profile position mode.
[[nodiscard]] AxisSteps reference_steps(const AxisState& state, const AxisReference& reference, Time limit);
/// What it may take: a rotative motor turns up to two times to its sensor and once to its Z-mark.
[[nodiscard]] Time reference_limit(const AxisState& state, const AxisReference& reference);

struct AxisMove {
    std::int64_t position = 0;  ///< or distance
    bool relative = false;
    std::optional<std::int64_t> speed{};
    std::optional<std::int64_t> acceleration{};
    std::optional<std::int64_t> s_curve{};
    std::optional<std::int64_t> window{};            ///< around the target
    std::optional<std::int64_t> following_window{};  ///< around the trajectory
};
/// 000 §3.2.3.1.
[[nodiscard]] AxisSteps move_steps(const AxisMove& move, Time limit);
[[nodiscard]] std::int64_t destination(const AxisMove& move, const AxisState& state);

struct AxisJog {
    bool positive = true;
    std::int64_t speed = 0;
    std::optional<std::int64_t> acceleration{};
    std::optional<Time> duration{};  ///< without one it runs on
};
/// 000 §3.2.5.1.
[[nodiscard]] AxisSteps jog_steps(const AxisJog& jog, const AxisState& state);

/// 000 §3.2.3.3. Without a mode, and with it without control word, a motion is stopped by the direct command SM.
[[nodiscard]] AxisSteps halt_steps(const AxisState& state, std::optional<Time> limit = {});
[[nodiscard]] AxisSteps quick_stop_steps(const AxisState& state);
/// 000 §3.2.3.2, up to the reset itself.
[[nodiscard]] AxisSteps fault_reset_steps();

struct AxisCalibration {
    std::optional<std::int64_t> start{};  ///< where it stands, when left out
    std::int64_t way = 0;
};
/// 004 §6.1.1; leaves in profile position mode.
[[nodiscard]] AxisSteps force_calibration_steps(const AxisCalibration& calibration, Time limit);

/// How long a motion may take: half as long again as it should, and some seconds.
[[nodiscard]] Time motion_limit(const AxisMove& move, const AxisState& state);

}  // namespace servobus::scanner
