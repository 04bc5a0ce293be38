// The arguments of `io` and `open`, and those of a connection for other verbs.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scanner/cli/io.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace servobus::scanner::cli {

/// `--connection` alone, for who knows the device.
void add_connection_option(CLI::App& app, ConnectionArguments& arguments);
/// `--o2t` and what goes with it: the numbers of a connection of any device.
void add_number_options(CLI::App& app, ConnectionArguments& arguments);
/// `--rpi`.
void add_interval_option(CLI::App& app, ConnectionArguments& arguments, const std::string& usual);

class IoCommandLine {
public:
    using Action = std::function<ExitCode(const Console&, const Settings&)>;

    /// Adds both verbs to a program. `decorate` adds what all verbs have; `choose` is told what is to be done.
    void add_to(CLI::App& app, const std::function<void(CLI::App&)>& decorate,
                const std::function<void(Action)>& choose);

private:
    void take_positional();
    CLI::App& add_verb(CLI::App& app, const std::string& name, const std::string& description);
    void add_manners(CLI::App& verb);
    void add_files(CLI::App& verb);
    void add_scheduling(CLI::App& verb);

    std::function<void(CLI::App&)> decorate_;
    IoArguments arguments_;
    std::string positional_;
};

}  // namespace servobus::scanner::cli
