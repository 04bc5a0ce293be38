// The command line inside the test: arguments in; exit code, data and messages out.
#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "scanner/cli/run.hpp"

namespace servobus::scanner::test {

struct Run {
    int code = 0;
    std::string out;
    std::string err;
};

inline Run run_scanner(const std::vector<std::string>& arguments, const cli::Surroundings& around = {}) {
    std::ostringstream out;
    std::ostringstream err;
    Run result;
    result.code = cli::run(arguments, out, err, around);
    result.out = out.str();
    result.err = err.str();
    return result;
}

}  // namespace servobus::scanner::test
