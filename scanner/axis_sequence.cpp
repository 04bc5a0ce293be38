#include "scanner/axis_sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "drive/lookup.hpp"
#include "drive/xenax.hpp"

namespace servobus::scanner {
namespace {

using namespace std::chrono_literals;
using State = drive::Ds402::State;

constexpr Time power_limit = 5s;
/// How long a drive may take to show that a motion has begun. A short motion may be over before anybody looks.
constexpr Time start_limit = 100ms;
constexpr Time margin = 3s;

constexpr std::int64_t shutdown = 0x06;
constexpr std::int64_t switch_on = 0x07;
constexpr std::int64_t enable = 0x0F;
constexpr std::int64_t quick_stop = 0x02;
constexpr std::int64_t fault_reset = 0x80;
constexpr std::int64_t start_bit = 0x10;
constexpr std::int64_t direction_bit = 0x40;  ///< in profile position mode: relative
constexpr std::int64_t halt_bit = 0x100;

AxisCondition status(std::uint32_t mask, std::uint32_t value) { return {AxisValue::status_word, mask, value}; }
AxisCondition process(std::uint32_t mask, std::uint32_t value) { return {AxisValue::process_status, mask, value}; }
AxisCondition standstill() { return process(process_bit::in_motion, 0); }

AxisCondition in(State state) {
    const auto patterns = drive::Ds402::patterns();
    const auto row = std::ranges::find(patterns, state, &drive::Ds402::Pattern::state);
    return status(row->mask, row->value);
}

std::string quoted(State state) { return fmt::format("'{}'", drive::Ds402::name(state)); }

AxisWrite control(std::int64_t word) { return {AxisValue::control_word, word}; }

AxisStep just(std::vector<AxisWrite> writes) {
    AxisStep step;
    step.writes = std::move(writes);
    return step;
}

AxisStep to_state(std::int64_t word, State state) {
    AxisStep step;
    step.goal = quoted(state);
    step.writes = {control(word)};
    step.until = {{in(state)}};
    step.limit = power_limit;
    return step;
}

AxisStep to_mode(int mode) {
    AxisStep step;
    step.goal = fmt::format("mode {}, {}", mode, mode_text(mode));
    step.writes = {{AxisValue::mode_requested, mode}};
    step.until = {{{AxisValue::mode, 0xFF, static_cast<std::uint8_t>(mode)}}};
    return step;
}

/// Waits while the axis moves.
AxisStep motion(std::string goal, std::vector<AxisConditions> until, Time limit) {
    AxisStep step;
    step.goal = std::move(goal);
    step.until = std::move(until);
    step.limit = limit;
    step.keeps = {in(State::operation_enabled)};
    step.in_motion = true;
    return step;
}

/// Gives the drive a moment to take back what it said about the motion before.
AxisStep start(std::vector<AxisWrite> writes, std::vector<AxisConditions> until) {
    auto step = motion({}, std::move(until), start_limit);
    step.writes = std::move(writes);
    step.may_expire = true;
    return step;
}

AxisWrite direct(std::string_view mnemonic) {
    return {AxisValue::direct_command, drive::find_command(drive::direct_commands(), mnemonic)->value};
}

void add(std::vector<AxisWrite>& writes, AxisValue to, const std::optional<std::int64_t>& value) {
    if (value) writes.push_back({to, *value});
}

Time seconds(double count) { return Time(std::llround(std::min(count, 1e9) * 1e6)); }

/// From a speed down to standstill, generously.
Time stop_limit(std::int64_t speed, std::int64_t deceleration) {
    const auto v = static_cast<double>(std::abs(speed));
    return seconds(3 * v / static_cast<double>(std::max<std::int64_t>(deceleration, 1))) + margin;
}

AxisSteps joined(AxisSteps steps, AxisSteps more) {
    for (auto& step : more) steps.push_back(std::move(step));
    return steps;
}

}  // namespace

bool AxisCondition::holds(const AxisState& state) const {
    return state.has(word) && (static_cast<std::uint32_t>(state.number(word)) & mask) == value;
}

AxisSequence::Wants AxisSequence::wants() const {
    if (failed() || step_ == steps_.size()) return Wants::nothing;
    return write_ < step().writes.size() ? Wants::write : Wants::look;
}

void AxisSequence::written(Time now) {
    ++write_;
    began_ = now;
    if (write_ == step().writes.size() && step().until.empty()) advance();
}

void AxisSequence::saw(const AxisState& state, Time now) {
    // A step without writes begins when it is first looked at.
    if (began_ == Time::min()) began_ = now;
    trouble_ = trouble_in(state);
    if (failed()) return;
    const auto all_hold = [&](const AxisConditions& conditions) {
        return std::ranges::all_of(conditions, [&](const AxisCondition& condition) { return condition.holds(state); });
    };
    if (std::ranges::any_of(step().until, all_hold)) {
        advance();
    } else if (now - began_ >= step().limit) {
        if (step().may_expire) {
            advance();
        } else {
            trouble_ = Trouble::time;
        }
    }
}

AxisSequence::Trouble AxisSequence::trouble_in(const AxisState& state) const {
    if (step().faults_end_it && state.has_fault()) return Trouble::fault;
    if (step().fails && step().fails->holds(state)) return Trouble::told;
    const auto holds = [&](const AxisCondition& condition) { return condition.holds(state); };
    return std::ranges::all_of(step().keeps, holds) ? Trouble::none : Trouble::lost;
}

void AxisSequence::advance() {
    ++step_;
    write_ = 0;
    began_ = Time::min();
}

std::string AxisSequence::failure_text(const AxisState& state) const {
    switch (trouble_) {
        case Trouble::none:
            return {};
        case Trouble::time:
            return fmt::format("waited {:g} s for {}; the drive is {}",
                               std::chrono::duration<double>(step().limit).count(), step().goal, situation(state));
        case Trouble::fault:
            return fmt::format("the drive is {}", situation(state));
        case Trouble::lost:
            return fmt::format("the drive has left {} and is {}", quoted(State::operation_enabled), situation(state));
        case Trouble::told:
            return fmt::format("{}; the drive is {}", step().failure, situation(state));
    }
    return {};
}

std::span<const AxisValue> followed_values() {
    static constexpr std::array values{AxisValue::status_word,    AxisValue::mode,    AxisValue::position,
                                       AxisValue::velocity,       AxisValue::current, AxisValue::following_error,
                                       AxisValue::process_status, AxisValue::error};
    return values;
}

std::span<const AxisValue> planning_values() {
    static constexpr std::array values{AxisValue::status_word,
                                       AxisValue::control_word,
                                       AxisValue::mode,
                                       AxisValue::position,
                                       AxisValue::velocity,
                                       AxisValue::process_status,
                                       AxisValue::error,
                                       AxisValue::error_text,
                                       AxisValue::motor_type,
                                       AxisValue::speed,
                                       AxisValue::acceleration,
                                       AxisValue::speed_override,
                                       AxisValue::quick_stop_deceleration,
                                       AxisValue::target_window,
                                       AxisValue::sensor_speed,
                                       AxisValue::z_mark_speed,
                                       AxisValue::encoder_increments};
    return values;
}

AxisSteps enable_steps(const AxisState& state) {
    // Clears what started the motion before.
    if (state.is_enabled()) return {to_state(enable, State::operation_enabled)};
    AxisSteps steps;
    // There is no way back from here but over transition 12 (004 §4.1).
    if (state.ds402() == State::quick_stop_active) steps.push_back(to_state(0, State::switch_on_disabled));
    steps.push_back(to_state(shutdown, State::ready_to_switch_on));
    steps.push_back(to_state(switch_on, State::switched_on));
    steps.push_back(to_state(enable, State::operation_enabled));
    return steps;
}

AxisSteps disable_steps(const AxisState& state) {
    AxisSteps steps;
    if (state.is_enabled()) steps.push_back(to_state(switch_on, State::switched_on));
    if (state.ds402() == State::quick_stop_active) steps.push_back(to_state(0, State::switch_on_disabled));
    steps.push_back(to_state(shutdown, State::ready_to_switch_on));
    return steps;
}

Time reference_limit(const AxisState& state, const AxisReference& reference) {
    constexpr Time linear = 60s;  // along a way that nobody knows
    constexpr double turns_to_sensor = 2.5;
    constexpr double turns_to_z_mark = 1.5;
    const auto increments = static_cast<double>(state.number(AxisValue::encoder_increments));
    const auto time = [&](double turns, std::optional<std::int64_t> given, AxisValue set) {
        const auto speed = static_cast<double>(given.value_or(state.number(set)));
        return speed > 0 ? turns * increments / speed : 0;
    };
    return linear + seconds(time(turns_to_sensor, reference.sensor_speed, AxisValue::sensor_speed) +
                            time(turns_to_z_mark, reference.z_mark_speed, AxisValue::z_mark_speed));
}

AxisSteps reference_steps(const AxisState& state, const AxisReference& reference, Time limit) {
    AxisSteps steps{to_mode(mode::reference), just({{AxisValue::reference_method, reference.method}})};
    add(steps.back().writes, AxisValue::sensor_speed, reference.sensor_speed);
    add(steps.back().writes, AxisValue::z_mark_speed, reference.z_mark_speed);
    steps = joined(std::move(steps), enable_steps(state));
    // Still set from the time before.
    steps.push_back(start({control(enable | start_bit)}, {{status(status_bit::specific, 0)}}));
    auto drive = motion("the reference", {{status(status_bit::specific, status_bit::specific)}}, limit);
    drive.fails = status(status_bit::error, status_bit::error);
    drive.failure = "the drive tells a reference error";
    steps.push_back(std::move(drive));
    steps.push_back(to_mode(mode::profile_position));
    steps.push_back(just({control(enable)}));
    return steps;
}

AxisSteps move_steps(const AxisMove& move, Time limit) {
    AxisSteps steps{to_mode(mode::profile_position), just({control(enable)})};
    auto& writes = steps.back().writes;
    add(writes, AxisValue::s_curve, move.s_curve);
    add(writes, AxisValue::acceleration, move.acceleration);
    add(writes, AxisValue::speed, move.speed);
    add(writes, AxisValue::following_window, move.following_window);
    add(writes, AxisValue::target_window, move.window);
    writes.push_back({AxisValue::target, move.position});
    const auto word = enable | start_bit | (move.relative ? direction_bit : 0);
    steps.push_back(start({control(word)},
                          {{status(status_bit::reached, 0)}, {status(status_bit::specific, status_bit::specific)}}));
    steps.push_back(motion("the target position",
                           {{status(status_bit::reached | status_bit::specific, status_bit::reached)}}, limit));
    return steps;
}

std::int64_t destination(const AxisMove& move, const AxisState& state) {
    return move.relative ? state.number(AxisValue::position) + move.position : move.position;
}

AxisSteps jog_steps(const AxisJog& jog, const AxisState& state) {
    AxisSteps steps{to_mode(mode::jog), just({control(enable)})};
    auto& writes = steps.back().writes;
    add(writes, AxisValue::acceleration, jog.acceleration);
    writes.push_back({AxisValue::speed, jog.speed});
    const auto word = enable | start_bit | (jog.positive ? direction_bit : 0);
    steps.push_back(start({control(word)}, {{status(status_bit::specific, 0)}}));
    const auto ramp = stop_limit(jog.speed, jog.acceleration.value_or(state.number(AxisValue::acceleration)));
    constexpr auto stopped = status_bit::soft_limit | status_bit::specific;
    const auto at_limit = status(stopped, stopped);
    const auto running = status(status_bit::reached | status_bit::specific, status_bit::reached);
    steps.push_back(motion("constant speed", {{running}, {at_limit}}, ramp));
    auto run = motion({}, {{at_limit}}, jog.duration.value_or(Time::max()));
    run.may_expire = true;
    steps.push_back(std::move(run));
    // The manual prints this word for both directions.
    steps.push_back(just({control(enable | start_bit | halt_bit)}));
    constexpr auto both = status_bit::reached | status_bit::specific;
    steps.push_back(motion("standstill", {{status(both, both)}}, ramp));
    return steps;
}

AxisSteps halt_steps(const AxisState& state, std::optional<Time> limit) {
    const auto present = static_cast<std::uint16_t>(state.number(AxisValue::control_word));
    AxisSteps steps;
    std::vector<AxisConditions> until{{standstill()}};
    if (state.mode() == mode::none) {
        steps.push_back(just({direct("SM")}));
    } else if (state.mode() == mode::jog) {
        steps.push_back(just({control((present | halt_bit) & ~direction_bit)}));
        until.front().push_back(status(status_bit::specific, status_bit::specific));
    } else {
        steps.push_back(just({control(present | halt_bit)}));
        if (state.mode() == mode::profile_position) until.front().push_back(status(status_bit::specific, 0));
    }
    const auto enough = stop_limit(state.number(AxisValue::velocity), state.number(AxisValue::acceleration));
    auto stop = motion("standstill", std::move(until), limit.value_or(enough));
    stop.keeps.clear();
    steps.push_back(std::move(stop));
    return steps;
}

AxisSteps quick_stop_steps(const AxisState& state) {
    AxisStep step;
    step.goal = fmt::format("standstill in {}", quoted(State::quick_stop_active));
    step.writes = {control(quick_stop)};
    step.until = {{in(State::quick_stop_active), standstill()}, {in(State::switch_on_disabled), standstill()}};
    step.limit = stop_limit(state.number(AxisValue::velocity), state.number(AxisValue::quick_stop_deceleration));
    step.in_motion = true;
    return {std::move(step)};
}

AxisSteps fault_reset_steps() {
    // It is the rising bit that resets.
    AxisStep reset;
    reset.goal = "the end of the fault (bit 3 = 0)";
    reset.writes = {control(0), control(fault_reset)};
    reset.until = {{status(status_bit::fault, 0)}};
    reset.faults_end_it = false;
    return {std::move(reset), just({control(0)})};
}

AxisSteps force_calibration_steps(const AxisCalibration& calibration, Time limit) {
    AxisSteps steps{to_mode(mode::none)};
    if (calibration.start) {
        steps.push_back(start({{AxisValue::calibration_start, *calibration.start}, direct("GP")},
                              {{process(process_bit::in_motion, process_bit::in_motion)}}));
        constexpr auto nibble = process_bit::reference | process_bit::in_motion | process_bit::in_position;
        steps.push_back(motion("the start position",
                               {{process(nibble, process_bit::reference | process_bit::in_position)}}, limit));
    }
    steps.push_back(just({{AxisValue::calibration_way, calibration.way}, direct("FC")}));
    steps.push_back(
        motion("the force calibration to begin", {{process(process_bit::calibrating, process_bit::calibrating)}}, 2s));
    steps.push_back(motion("the end of the force calibration", {{process(process_bit::calibrating, 0)}}, limit));
    steps.push_back(to_mode(mode::profile_position));
    return steps;
}

Time motion_limit(const AxisMove& move, const AxisState& state) {
    const auto way = static_cast<double>(std::abs(destination(move, state) - state.number(AxisValue::position)));
    const auto at_least_one = [](std::int64_t number) {
        return static_cast<double>(std::max<std::int64_t>(number, 1));
    };
    const auto slower =
        state.has(AxisValue::speed_override) ? at_least_one(state.number(AxisValue::speed_override)) / 100 : 1.0;
    const auto speed = slower * at_least_one(move.speed.value_or(state.number(AxisValue::speed)));
    const auto acceleration = at_least_one(move.acceleration.value_or(state.number(AxisValue::acceleration)));
    // An S-curve at most doubles the ramps, and a short way does not reach the speed.
    const auto ramp = std::min(speed / acceleration, std::sqrt(way / acceleration));
    return seconds(1.5 * (way / speed + 4 * ramp)) + margin;
}

}  // namespace servobus::scanner
