// servobus-scanner
#include <unistd.h>

#include <iostream>
#include <string>
#include <vector>

#include "scanner/cli/run.hpp"

int main(int argc, char** argv) {
    const std::vector<std::string> arguments(argv + (argc > 0 ? 1 : 0), argv + argc);
    const bool terminal = isatty(STDERR_FILENO) == 1;
    const bool answers = terminal && isatty(STDIN_FILENO) == 1;
    const int code = servobus::scanner::cli::run(arguments, std::cout, std::cerr,
                                                 {.terminal = terminal, .person = answers ? &std::cin : nullptr});
    std::cout.flush();
    return code;
}
