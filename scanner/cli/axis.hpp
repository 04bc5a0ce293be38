// The verbs of `axis`: each walks a sequence and ends with one sentence about what happened.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scanner/axis_sequence.hpp"
#include "scanner/cli/axis_runner.hpp"
#include "scanner/cli/console.hpp"
#include "scanner/cli/exit_code.hpp"
#include "scanner/cli/io_options.hpp"
#include "scanner/cli/link.hpp"

namespace servobus::scanner::cli {

/// What goes with every verb of an axis.
struct AxisOptions {
    std::string host{};
    std::optional<Time> wait{};         ///< longest time of a motion, instead of what it should take
    std::vector<std::string> traces{};  ///< files for a recording
    Time interval = std::chrono::milliseconds(2);
    std::optional<Time> duration{};  ///< of a recording, at least
    bool io = false;                 ///< over an I/O connection instead of explicit messages
    ConnectionArguments connection{};
};

struct AxisOutcome {
    std::string sentence{};  ///< when it was done
    std::optional<Failure> failure{};
    bool interrupted = false;  ///< and the axis is still to be halted
};
using AxisVerb = std::function<AxisOutcome(AxisRunner&, const AxisOptions&)>;

[[nodiscard]] AxisOutcome enable_axis(AxisRunner& runner, const AxisOptions& options);
[[nodiscard]] AxisOutcome disable_axis(AxisRunner& runner, const AxisOptions& options);
[[nodiscard]] AxisOutcome halt_axis(AxisRunner& runner, const AxisOptions& options);
[[nodiscard]] AxisOutcome quick_stop_axis(AxisRunner& runner, const AxisOptions& options);
[[nodiscard]] AxisOutcome reset_fault(AxisRunner& runner, const AxisOptions& options);
/// Without a method: the first that the connected motor takes.
/// Without a method the first one for the motor that is connected.
[[nodiscard]] AxisVerb reference_verb(std::optional<int> method, AxisReference reference);
[[nodiscard]] AxisVerb move_verb(AxisMove move);
[[nodiscard]] AxisVerb jog_verb(AxisJog jog);
[[nodiscard]] AxisVerb force_calibration_verb(AxisCalibration calibration);

/// Runs a verb over a connection, halts the axis on Ctrl-C, and writes the recording. Without a verb it only records.
ExitCode run_axis(const Console& console, const Settings& settings, const AxisOptions& options, const std::string& name,
                  const AxisVerb& verb);

ExitCode axis_status(const Console& console, const Settings& settings, const AxisOptions& options);
/// What it prints.
[[nodiscard]] std::string status_text(const AxisState& state);
[[nodiscard]] std::string status_json(const std::string& host, const AxisState& state);

/// What one verb did.
[[nodiscard]] std::string axis_json(const std::string& host, const std::string& verb, const AxisOutcome& outcome,
                                    const AxisRunner& runner, const std::vector<std::string>& traces);

}  // namespace servobus::scanner::cli
