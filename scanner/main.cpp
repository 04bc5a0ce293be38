// servobus-scanner
#include <unistd.h>

#include <iostream>
#include <string>
#include <vector>

#include "scanner/cli/run.hpp"

int main(int argc, char** argv) {
    const std::vector<std::string> arguments(argv + (argc > 0 ? 1 : 0), argv + argc);
    const int code = servobus::scanner::cli::run(arguments, std::cout, std::cerr, {isatty(STDERR_FILENO) == 1});
    std::cout.flush();
    return code;
}
