// The arguments of `conformance`.
#pragma once

#include <functional>

#include "scanner/cli/conformance.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace servobus::scanner::cli {

class ConformanceCommandLine {
public:
    using Action = std::function<ExitCode(const Console&, const Settings&)>;

    /// Adds the verb to a program. `decorate` adds what it has in common with others; `choose` is told what is to be done.
    void add_to(CLI::App& app, const std::function<void(CLI::App&)>& decorate,
                const std::function<void(Action)>& choose);

private:
    ConformanceArguments arguments_;
};

}  // namespace servobus::scanner::cli
