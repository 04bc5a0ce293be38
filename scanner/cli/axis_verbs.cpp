// What each verb of `axis` needs, does and says.
#include <fmt/format.h>

#include <cstdlib>

#include "scanner/cli/axis.hpp"
#include "scanner/cli/text_output.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace std::chrono_literals;

/// A calibration takes as long as the way that nobody knows.
constexpr Time search_limit = 60s;

enum Needs : unsigned { no_fault = 0, enabled = 1, referenced = 2, standstill = 4 };

/// Why a verb cannot begin, and which one would have to be called first.
std::optional<Failure> missing(const AxisState& state, unsigned needs) {
    const auto failure = [](const std::string& text) { return Failure{ExitCode::axis, text}; };
    if (state.has_fault()) {
        return failure(printable(fmt::format("the drive is {}; call 'fault-reset' first", situation(state))));
    }
    if ((needs & enabled) != 0 && !state.is_enabled()) {
        // Referencing switches the power on by itself.
        const bool needs_reference = (needs & referenced) != 0 && !state.is_rotative() && !state.is_referenced();
        return failure(fmt::format("the axis is not enabled: the drive is {}; call '{}' first", situation(state),
                                   needs_reference ? "reference" : "enable"));
    }
    if ((needs & referenced) != 0 && !state.is_rotative() && !state.is_referenced()) {
        return failure("the axis is not referenced; call 'reference' first");
    }
    if ((needs & standstill) != 0 && (state.process_status() & process_bit::in_motion) != 0) {
        return failure("the axis is in motion; call 'halt' first");
    }
    return std::nullopt;
}

AxisOutcome failed(Failure failure) { return {{}, std::move(failure), false}; }

/// Over an I/O connection the power is on only as long as that is open, so a motion switches it on by itself.
std::optional<AxisOutcome> not_ready(AxisRunner& runner, const AxisOptions& options) {
    const bool switch_on = options.io && !runner.state().is_enabled();
    if (auto failure = missing(runner.state(), (switch_on ? no_fault : enabled) | referenced | standstill)) {
        return failed(std::move(*failure));
    }
    if (!switch_on) return std::nullopt;
    const auto end = runner.run(enable_steps(runner.state()));
    if (end == AxisRunner::End::interrupted) return AxisOutcome{{}, {}, true};
    if (end == AxisRunner::End::failed) return failed(runner.failure());
    return std::nullopt;
}

std::int64_t position(const AxisRunner& runner) { return runner.state().number(AxisValue::position); }

/// The sentence when the run is done, otherwise what became of it.
AxisOutcome outcome(const AxisRunner& runner, AxisRunner::End end, const std::function<std::string()>& sentence) {
    if (end == AxisRunner::End::interrupted) return {{}, {}, true};
    if (end == AxisRunner::End::failed) return failed(runner.failure());
    return {sentence(), {}, false};
}

std::string tracking(const AxisRunner& runner) {
    return fmt::format("following error at most {}", runner.largest_following_error());
}

/// Why the axis is not where it was to go: a drive goes as far as it may, and says no more than this.
std::optional<Failure> missed(const AxisRunner& runner, const AxisMove& move, std::int64_t target) {
    const auto& state = runner.state();
    const auto window = move.window.value_or(state.number(AxisValue::target_window));
    if (std::abs(position(runner) - target) <= window) return std::nullopt;
    auto text = fmt::format("the axis stands at {} increments and not at {}", position(runner), target);
    if ((state.status_word() & status_bit::soft_limit) != 0) text += "; a soft limit is reached";
    if (const auto error = printable(error_text(state)); !error.empty()) text += "; the drive tells " + error;
    return Failure{ExitCode::axis, std::move(text)};
}

bool method_was_refused(const AxisRunner& runner) {
    return runner.failure().code == ExitCode::refused && runner.refused() &&
           runner.refused()->to == AxisValue::reference_method;
}

}  // namespace

AxisOutcome enable_axis(AxisRunner& runner, const AxisOptions&) {
    if (auto failure = missing(runner.state(), no_fault)) return failed(std::move(*failure));
    const bool already = runner.state().is_enabled() && runner.state().number(AxisValue::control_word) == 0x0F;
    const auto end = already ? AxisRunner::End::done : runner.run(enable_steps(runner.state()));
    return outcome(runner, end, [&] {
        return fmt::format("{}; the axis holds {} increments", already ? "Was enabled already" : "Enabled",
                           position(runner));
    });
}

AxisOutcome disable_axis(AxisRunner& runner, const AxisOptions&) {
    if (auto failure = missing(runner.state(), standstill)) return failed(std::move(*failure));
    if (runner.state().ds402() == drive::Ds402::State::switch_on_disabled) return {"Was disabled already"};
    const auto end = runner.run(disable_steps(runner.state()));
    return outcome(runner, end, [&] { return fmt::format("Disabled; the drive is {}", situation(runner.state())); });
}

AxisOutcome halt_axis(AxisRunner& runner, const AxisOptions& options) {
    if ((runner.state().process_status() & process_bit::in_motion) == 0) {
        return {fmt::format("The axis stood still already, at {} increments", position(runner))};
    }
    const auto end = runner.run(halt_steps(runner.state(), options.wait));
    return outcome(runner, end, [&] { return fmt::format("Halted at {} increments", position(runner)); });
}

AxisOutcome quick_stop_axis(AxisRunner& runner, const AxisOptions&) {
    if (auto failure = missing(runner.state(), no_fault)) return failed(std::move(*failure));
    const auto end = runner.run(quick_stop_steps(runner.state()));
    return outcome(runner, end, [&] {
        return fmt::format("Stopped at {} increments; the drive is {}, and 'enable' leaves that", position(runner),
                           situation(runner.state()));
    });
}

AxisOutcome reset_fault(AxisRunner& runner, const AxisOptions&) {
    if (!runner.state().has_fault()) {
        return {fmt::format("There was no fault; the drive is {}", situation(runner.state()))};
    }
    const auto fault = printable(error_text(runner.state()));
    const auto end = runner.run(fault_reset_steps());
    return outcome(runner, end, [&] {
        // Without its logic power the drive forgets the reference, by a fault it does not (004 §5.1.1).
        const bool referenced_still = runner.state().is_referenced() || runner.state().is_rotative();
        return fmt::format("The fault is reset; it was error {}. Next: '{}'", fault.empty() ? "0" : fault,
                           referenced_still ? "enable" : "reference");
    });
}

AxisVerb reference_verb(std::optional<int> method, AxisReference reference) {
    return [method, reference](AxisRunner& runner, const AxisOptions& options) mutable {
        if (auto failure = missing(runner.state(), standstill)) return failed(std::move(*failure));
        const auto limit = options.wait.value_or(reference_limit(runner.state(), reference));
        // The first methods for linear and for rotative motors (004 §4.2.19).
        constexpr int linear = 1;
        constexpr int rotative = 10;
        int& used = reference.method;
        used = method.value_or(runner.state().is_rotative() ? rotative : linear);
        auto end = runner.run(reference_steps(runner.state(), reference, limit));
        // A motor of another make does not say what it is, but its drive knows.
        if (end == AxisRunner::End::failed && !method && method_was_refused(runner)) {
            used = used == linear ? rotative : linear;
            end = runner.run(reference_steps(runner.state(), reference, limit));
        }
        return outcome(runner, end, [&] {
            return fmt::format("Referenced in {:.3f} s by method {} ({}); the axis stands at {} increments",
                               runner.seconds(), used, reference_method_text(used), position(runner));
        });
    };
}

AxisVerb move_verb(AxisMove move) {
    return [move](AxisRunner& runner, const AxisOptions& options) {
        if (auto outcome = not_ready(runner, options)) return std::move(*outcome);
        const auto& state = runner.state();
        const auto from = position(runner);
        const auto target = destination(move, state);
        const auto limit = options.wait.value_or(motion_limit(move, state));
        const auto end = runner.run(move_steps(move, limit), Way{from, target});
        if (end == AxisRunner::End::done) {
            if (auto failure = missed(runner, move, target)) return failed(std::move(*failure));
        }
        return outcome(runner, end, [&] {
            const auto by = move.relative ? fmt::format("by {} ", move.position) : std::string();
            return fmt::format("Moved {}to {} increments in {:.3f} s; {}", by, target, runner.seconds(),
                               tracking(runner));
        });
    };
}

AxisVerb jog_verb(AxisJog jog) {
    return [jog](AxisRunner& runner, const AxisOptions& options) {
        if (auto outcome = not_ready(runner, options)) return std::move(*outcome);
        const auto from = position(runner);
        auto end = runner.run(jog_steps(jog, runner.state()));
        // Without a duration this is how it ends.
        if (end == AxisRunner::End::interrupted && !jog.duration) {
            const auto halt = runner.halt();
            if (!halt.stands) return failed({ExitCode::axis, halt.text});
            end = AxisRunner::End::done;
        }
        return outcome(runner, end, [&] {
            const bool at_limit = (runner.state().status_word() & status_bit::soft_limit) != 0;
            return fmt::format("Jogged {} from {} to {} increments{}; {}", jog.positive ? "positive" : "negative", from,
                               position(runner), at_limit ? ", where a soft limit is" : "", tracking(runner));
        });
    };
}

AxisVerb force_calibration_verb(AxisCalibration calibration) {
    return [calibration](AxisRunner& runner, const AxisOptions& options) {
        if (auto outcome = not_ready(runner, options)) return std::move(*outcome);
        const auto from = calibration.start.value_or(position(runner));
        const auto end = runner.run(force_calibration_steps(calibration, options.wait.value_or(search_limit)));
        return outcome(runner, end, [&] {
            return fmt::format("Force calibrated from {} to {} increments in {:.3f} s; the axis stands at {}", from,
                               from + calibration.way, runner.seconds(), position(runner));
        });
    };
}

}  // namespace servobus::scanner::cli
