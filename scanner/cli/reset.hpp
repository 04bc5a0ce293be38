// `reset HOST`: restarts a device, or brings its factory defaults back, and looks whether it is there again (R-ID-8).
#pragma once

#include <chrono>
#include <string>

#include "scanner/cli/console.hpp"
#include "scanner/cli/exit_code.hpp"
#include "scanner/cli/link.hpp"
#include "scanner/cli/results.hpp"

namespace servobus::scanner::cli {

struct ResetArguments {
    ResetKind kind = ResetKind::restart;
    bool yes = false;  ///< nobody is asked
    bool wait = true;  ///< until the device answers again
    std::chrono::milliseconds patience{30'000};
};

ExitCode reset(const Console& console, const Settings& settings, const std::string& host,
               const ResetArguments& arguments);

}  // namespace servobus::scanner::cli
