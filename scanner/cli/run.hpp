// The whole command line, so that a test can run it without a process.
#pragma once

#include <ostream>
#include <string>
#include <vector>

namespace servobus::scanner::cli {

/// `arguments` without the program's name. Returns the exit code (exit_code.hpp); never throws.
int run(std::vector<std::string> arguments, std::ostream& out, std::ostream& err);

}  // namespace servobus::scanner::cli
