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
};

struct ExitCodeRow {
    ExitCode code;
    std::string_view kind;  ///< in JSON
    std::string_view text;
};

inline constexpr std::array<ExitCodeRow, 6> exit_codes{{
    {ExitCode::done, "done", "done"},
    {ExitCode::fault, "fault", "a fault of this program; please report it"},
    {ExitCode::usage, "usage", "wrong usage; nothing was sent"},
    {ExitCode::no_connection, "no_connection", "no connection, or no answer in time"},
    {ExitCode::refused, "refused", "the device refused, and the message says why"},
    {ExitCode::nonsense, "nonsense", "the device's answer makes no sense"},
}};

[[nodiscard]] constexpr const ExitCodeRow& row_of(ExitCode code) { return exit_codes[static_cast<std::size_t>(code)]; }

static_assert([] {
    for (std::size_t i = 0; i < exit_codes.size(); ++i) {
        if (static_cast<std::size_t>(exit_codes[i].code) != i) return false;
    }
    return true;
}());

}  // namespace servobus::scanner::cli
