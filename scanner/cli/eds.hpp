// The verbs of `eds`: data sheets of devices.
#pragma once

#include <string>

#include "scanner/cli/console.hpp"
#include "scanner/cli/exit_code.hpp"
#include "scanner/cli/link.hpp"
#include "scanner/file_upload.hpp"
#include "scanner/host.hpp"

namespace servobus::scanner::cli {

struct EdsUploadArguments {
    std::string host{};
    std::string output{};  ///< a file, `-` for standard output, empty: as the device calls it
    bool icon = false;
    bool force = false;
    bool raw = false;  ///< as it is transferred, though it may be compressed
};

struct EdsCheckArguments {
    std::string host{};
    std::string file{};
    bool open = false;  ///< also opens each connection, one after the other
};

/// Why a device gave no file, with the exit code for it.
[[nodiscard]] Failure failure_of(const UploadFailure& failure, const Host& host);

/// Reads the data sheet that a device keeps about itself, and stores it.
ExitCode eds_upload(const Console& console, const Settings& settings, const EdsUploadArguments& arguments);
/// Says what is wrong with a file.
ExitCode eds_lint(const Console& console, const std::string& file);
/// Prints what is in a file.
ExitCode eds_show(const Console& console, const std::string& file);
/// Compares a device with its file.
ExitCode eds_check(const Console& console, const Settings& settings, const EdsCheckArguments& arguments);

}  // namespace servobus::scanner::cli
