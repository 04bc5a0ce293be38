#include "scanner/cli/axis_runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "scanner/cli/text_output.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace std::chrono_literals;

constexpr int bar_width = 30;
constexpr auto bar_interval = 50ms;

std::string bar(double share) {
    const int full = static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * bar_width));
    return fmt::format("[{:#<{}}{:.<{}}]", "", full, "", bar_width - full);
}

/// Whoever reads it may stand beside the machine.
std::string with_warning(std::string text) {
    constexpr std::string_view warning = "; the axis may still move";
    return text.ends_with(warning) ? text : text.append(warning);
}

/// What a step waits for, and what ends it.
std::vector<AxisValue> values_of(const AxisStep& step) {
    std::vector<AxisValue> values{AxisValue::status_word};
    const auto add = [&](const AxisCondition& condition) {
        if (std::ranges::find(values, condition.word) == values.end()) values.push_back(condition.word);
    };
    for (const auto& conditions : step.until) std::ranges::for_each(conditions, add);
    std::ranges::for_each(step.keeps, add);
    if (step.fails) add(*step.fails);
    return values;
}

}  // namespace

void Progress::step(const std::string& goal) {
    if (!goal.empty() && !console_.terminal) console_.say("waiting for " + goal);
}

void Progress::moved(const AxisState& state, const std::string& goal) {
    const auto now = std::chrono::steady_clock::now();
    if (!console_.terminal || now < next_) return;
    next_ = now + bar_interval;
    shown_ = true;
    const auto position = state.number(AxisValue::position);
    std::string line;
    if (way_ && way_->first != way_->second) {
        const double share =
            static_cast<double>(position - way_->first) / static_cast<double>(way_->second - way_->first);
        line = bar(share) + "  ";
    }
    line += fmt::format("{} increments", position);
    if (!goal.empty()) line += "  waiting for " + goal;
    console_.err << '\r' << line << "\x1B[K" << std::flush;
}

void Progress::clear() {
    if (shown_) console_.err << "\r\x1B[K" << std::flush;
    shown_ = false;
}

AxisRunner::AxisRunner(const Console& console, AxisLink& link, const Interruption& interruption, Time interval,
                       bool recording)
    : console_(console), link_(link), interruption_(interruption), interval_(interval), recording_(recording) {
    const auto keep = [this](const AxisState& state, Clock::time_point time) {
        const auto seconds = std::chrono::duration<double>(time - start_).count();
        if (seconds >= 0) samples_.push_back(sample_of(state, seconds));
    };
    if (recording_ && link_.record(keep)) recording_ = false;
}

Time AxisRunner::now() const { return std::chrono::duration_cast<Time>(Clock::now() - start_); }

bool AxisRunner::look(std::span<const AxisValue> needed, bool in_motion) {
    link_.wait_until(next_look_);
    // From the time that was meant, so that the rate is kept; from now when it cannot be kept.
    next_look_ = std::max(next_look_ + interval_, Clock::now());
    const auto asked = now();
    if (auto failure = link_.look(needed, state_)) {
        failure_ = std::move(*failure);
        if (in_motion) failure_.text = with_warning(failure_.text);
        return false;
    }
    const auto error = std::abs(state_.number(AxisValue::following_error));
    largest_following_error_ = in_motion ? std::max(largest_following_error_, error) : largest_following_error_;
    // The values are from about the middle between question and answer.
    const auto time = std::chrono::duration<double>(asked + now()).count() / 2;
    if (recording_) samples_.push_back(sample_of(state_, time));
    return true;
}

bool AxisRunner::act(AxisSequence& sequence) {
    if (sequence.wants() == AxisSequence::Wants::look) {
        if (!look(values_of(sequence.step()), sequence.step().in_motion)) return false;
        sequence.saw(state_, now());
        return true;
    }
    if (sequence.step().in_motion && !motion_began_) motion_began_ = now();
    if (auto failure = link_.write(sequence.next_write())) {
        failure_ = std::move(*failure);
        if (motion_began_ && failure_.code == ExitCode::no_connection) failure_.text = with_warning(failure_.text);
        return false;
    }
    sequence.written(now());
    return true;
}

void AxisRunner::note_motion(const AxisSequence& sequence, bool was_in_motion) {
    const bool is_over = sequence.wants() == AxisSequence::Wants::nothing || !sequence.step().in_motion;
    if (was_in_motion && is_over && motion_began_) {
        seconds_ = std::chrono::duration<double>(now() - *motion_began_).count();
    }
}

AxisRunner::End AxisRunner::run(AxisSteps steps, std::optional<Way> way) {
    AxisSequence sequence(std::move(steps));
    Progress progress(console_, std::move(way));
    motion_began_.reset();
    seconds_ = 0;
    largest_following_error_ = 0;
    std::size_t announced = SIZE_MAX;
    while (sequence.wants() != AxisSequence::Wants::nothing) {
        if (interruption_.count() > 0) return End::interrupted;
        if (std::exchange(announced, sequence.step_number()) != sequence.step_number()) {
            progress.step(sequence.step().goal);
        }
        const bool in_motion = sequence.step().in_motion;
        if (!act(sequence)) return End::failed;
        note_motion(sequence, in_motion);
        if (in_motion) progress.moved(state_, sequence.step().goal);
    }
    return sequence.failed() ? fail(sequence) : End::done;
}

AxisRunner::End AxisRunner::fail(const AxisSequence& sequence) {
    // The number alone says little.
    static constexpr std::array values{AxisValue::status_word, AxisValue::error, AxisValue::error_text,
                                       AxisValue::process_status};
    (void)link_.read(values, state_);
    auto text = printable(sequence.failure_text(state_));
    if (state_.has_fault()) text += "; 'fault-reset' ends the fault";
    if ((state_.process_status() & process_bit::in_motion) != 0) text += "; the axis still moves, 'halt' stops it";
    failure_ = {ExitCode::axis, std::move(text)};
    return End::failed;
}

std::optional<Failure> AxisRunner::refresh() {
    static constexpr std::array values{AxisValue::status_word, AxisValue::error, AxisValue::error_text,
                                       AxisValue::position};
    return link_.ask(values, state_);
}

AxisRunner::End AxisRunner::watch(Time duration) {
    const auto end = now() + duration;
    Progress progress(console_, {});
    while (now() < end) {
        if (interruption_.count() > 0) return End::interrupted;
        if (!look({}, false)) return End::failed;
        progress.moved(state_, {});
    }
    return End::done;
}

AxisRunner::Halt AxisRunner::halt() {
    const auto stands = [this] { return fmt::format("stands at {} increments", state_.number(AxisValue::position)); };
    if (auto failure = link_.read(planning_values(), state_)) return {false, with_warning(failure->text)};
    const bool moves = (state_.process_status() & process_bit::in_motion) != 0;
    // What was started a moment ago may not show yet.
    if (!moves && !motion_began_) return {true, "the axis " + stands()};
    AxisSequence sequence(halt_steps(state_));
    // A second Ctrl-C leaves without waiting.
    while (sequence.wants() != AxisSequence::Wants::nothing) {
        if (interruption_.count() > 1) return {false, with_warning("the axis was told to halt")};
        if (!act(sequence)) return {false, with_warning(failure_.text)};
    }
    if (sequence.failed()) return {false, with_warning(sequence.failure_text(state_))};
    return {true, "the axis was halted and " + stands()};
}

}  // namespace servobus::scanner::cli
