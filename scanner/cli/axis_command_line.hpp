// The arguments of `axis HOST VERB`.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "scanner/cli/axis.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace servobus::scanner::cli {

class AxisCommandLine {
public:
    using Action = std::function<ExitCode(const Console&, const Settings&)>;

    /// Adds the verb to a program. `decorate` adds what all verbs have; `choose` is told what is to be done.
    void add_to(CLI::App& app, const std::function<void(CLI::App&)>& decorate, std::function<void(Action)> choose);

private:
    CLI::App& add_verb(CLI::App& parent, const std::string& name, const std::string& description,
                       const std::string& examples, std::function<AxisVerb()> make);
    void add_status(CLI::App& axis);
    void add_power(CLI::App& axis);
    void add_stops(CLI::App& axis);
    void add_motions(CLI::App& parent, bool traced);
    void add_reference(CLI::App& parent, bool traced);
    void add_move(CLI::App& parent, bool traced);
    void add_jog(CLI::App& parent, bool traced);
    void add_calibration(CLI::App& parent, bool traced);
    void add_trace(CLI::App& axis);
    void add_trace_files(CLI::App& verb, const std::string& option);
    void add_wait(CLI::App& verb);
    void add_connection(CLI::App& verb);

    std::function<void(CLI::App&)> decorate_;
    AxisOptions options_;
    AxisMove move_;
    AxisJog jog_;
    AxisCalibration calibration_;
    std::optional<int> method_;
    AxisReference reference_;
    std::string verb_name_;
    std::function<AxisVerb()> make_verb_;  ///< empty for a trace without a verb
    bool status_ = false;
};

}  // namespace servobus::scanner::cli
