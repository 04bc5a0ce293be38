// `conformance`: whether a device keeps the rules of CIP and EtherNet/IP.
#pragma once

#include <string>
#include <vector>

#include "scanner/cli/console.hpp"
#include "scanner/cli/exit_code.hpp"
#include "scanner/cli/io_options.hpp"
#include "scanner/cli/link.hpp"

namespace servobus::scanner::cli {

struct ConformanceArguments {
    std::string host{};                ///< empty only with `list`
    ConnectionArguments connection{};  ///< which I/O connections the device has
    bool writes = false;
    std::vector<std::string> groups{};
    std::vector<std::string> cases{};  ///< ids; beside those of `groups`. Neither: all
    bool list = false;
    bool verbose = false;
    std::string junit{};  ///< a file, `-` for standard output, empty: none
    std::string json{};   ///< the same
};

ExitCode conformance(const Console& console, const Settings& settings, const ConformanceArguments& arguments);

}  // namespace servobus::scanner::cli
