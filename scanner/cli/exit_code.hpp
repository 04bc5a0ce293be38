// The one table of exit codes.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace servobus::scanner::cli {

enum class ExitCode : std::uint8_t {
    done = 0,
    fault = 1,
    usage = 2,
    no_connection = 3,
    refused = 4,
    nonsense = 5,
    axis = 6,
    interrupted = 130,
};

struct ExitCodeRow {
    ExitCode code;
    std::string_view kind;  ///< in JSON
    std::string_view text;
};

inline constexpr std::array<ExitCodeRow, 8> exit_codes{{
    {ExitCode::done, "done", "done"},
    {ExitCode::fault, "fault", "a fault of this program; please report it"},
    {ExitCode::usage, "usage", "wrong usage; nothing was sent"},
    {ExitCode::no_connection, "no_connection", "no connection, or no answer in time"},
    {ExitCode::refused, "refused", "the device refused, and the message says why"},
    {ExitCode::nonsense, "nonsense", "the device's answer makes no sense"},
    {ExitCode::axis, "axis", "the axis did not do it: a fault, a time limit, or not in this state"},
    {ExitCode::interrupted, "interrupted", "Ctrl-C; the axis was halted before"},
}};

[[nodiscard]] constexpr const ExitCodeRow& row_of(ExitCode code) {
    for (const auto& row : exit_codes) {
        if (row.code == code) return row;
    }
    return exit_codes[1];
}

}  // namespace servobus::scanner::cli
