// The whole command line, so that a test can run it without a process.
#pragma once

#include <atomic>
#include <istream>
#include <ostream>
#include <string>
#include <vector>

namespace servobus::scanner::cli {

/// What the command line runs in.
struct Surroundings {
    bool terminal = false;                            ///< `err` is one
    const std::atomic<int>* interruptions = nullptr;  ///< counts in place of Ctrl-C, for tests
    std::istream* person = nullptr;                   ///< who answers questions; nullptr: nobody is there
};

/// `arguments` without the program's name. Returns the exit code (exit_code.hpp); never throws.
int run(std::vector<std::string> arguments, std::ostream& out, std::ostream& err, const Surroundings& around = {});

}  // namespace servobus::scanner::cli
