// The verbs `io` and `open`.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "enip/asio/scheduling.hpp"
#include "scanner/cli/console.hpp"
#include "scanner/cli/exit_code.hpp"
#include "scanner/cli/io_options.hpp"
#include "scanner/cli/io_runner.hpp"
#include "scanner/cli/link.hpp"

namespace servobus::scanner::cli {

struct IoArguments {
    std::string host{};
    ConnectionArguments connection{};
    std::optional<std::chrono::microseconds> duration{};  ///< without it until Ctrl-C
    std::string csv{};                                    ///< a file, `-` for standard output
    std::string pcapng{};
    bool no_reopen = false;
    enip::asio::Scheduling scheduling{};
};

/// Runs a connection and shows what comes.
ExitCode io(const Console& console, const Settings& settings, const IoArguments& arguments);
/// Opens a connection, waits for its first datagram, closes it, and says whether all is well.
ExitCode open(const Console& console, const Settings& settings, const IoArguments& arguments);

/// Why the connection did not open, in words and with the command line that would; as a JSON document with `json`.
/// `opened` and `report` are for one that opened and stayed silent. Empty when nobody can tell more than the failure.
[[nodiscard]] std::string diagnosis_of(const IoClosed& closed, const ConnectionTask& task, const std::string& host,
                                       bool json, const IoOpened* opened = nullptr, const IoReport* report = nullptr);

}  // namespace servobus::scanner::cli
