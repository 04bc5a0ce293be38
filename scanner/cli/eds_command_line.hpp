// The arguments of `eds VERB`.
#pragma once

#include <functional>
#include <string>

#include "scanner/cli/eds.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace servobus::scanner::cli {

class EdsCommandLine {
public:
    using Action = std::function<ExitCode(const Console&, const Settings&)>;

    /// Adds the verb to a program. `decorate` adds what all verbs have that talk to a device; `choose` is told what is to
    /// be done.
    void add_to(CLI::App& app, const std::function<void(CLI::App&)>& decorate, std::function<void(Action)> choose);

private:
    CLI::App& add_verb(CLI::App& eds, const std::string& name, const std::string& description,
                       const std::string& examples, Action action);
    void add_upload(CLI::App& eds);
    void add_check(CLI::App& eds);
    void add_reading(CLI::App& eds);

    std::function<void(CLI::App&)> decorate_;
    std::function<void(Action)> choose_;
    EdsUploadArguments upload_;
    EdsCheckArguments check_;
    std::string file_;
};

}  // namespace servobus::scanner::cli
