#include "scanner/cli/results.hpp"

#include <algorithm>
#include <array>

namespace servobus::scanner::cli {
namespace {

ExitCode exit_code_of(const Outcome& outcome) {
    if (outcome.has_value() || std::holds_alternative<NotAsked>(outcome.result)) return ExitCode::done;
    if (const auto* error = std::get_if<error_code>(&outcome.result)) return cli::exit_code_of(*error);
    return ExitCode::refused;
}

}  // namespace

ExitCode exit_code_of(const std::vector<Outcome>& outcomes) {
    static constexpr std::array worst_first{ExitCode::no_connection, ExitCode::nonsense, ExitCode::refused,
                                            ExitCode::usage};
    for (const auto code : worst_first) {
        const auto has_code = [code](const Outcome& outcome) { return exit_code_of(outcome) == code; };
        if (std::ranges::any_of(outcomes, has_code)) return code;
    }
    return ExitCode::done;
}

ExitCode dump_exit_code_of(const std::vector<Outcome>& outcomes) {
    const auto code = exit_code_of(outcomes);
    const bool any = std::ranges::any_of(outcomes, &Outcome::has_value);
    return code == ExitCode::refused && any ? ExitCode::done : code;
}

}  // namespace servobus::scanner::cli
