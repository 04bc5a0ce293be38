// get, set and list for the parameters that a data sheet describes, of any device.
#pragma once

#include <string>
#include <vector>

#include "scanner/cli/console.hpp"
#include "scanner/cli/exit_code.hpp"
#include "scanner/cli/link.hpp"

namespace servobus::scanner::cli {

struct SheetArguments {
    std::string file{};
    bool force = false;  ///< also what the sheet does not allow
};

ExitCode sheet_get(const Console& console, const Settings& settings, const SheetArguments& arguments,
                   const std::string& host, const std::vector<std::string>& words);
/// `NAME=VALUE…`, or one NAME and its VALUE.
ExitCode sheet_set(const Console& console, const Settings& settings, const SheetArguments& arguments,
                   const std::string& host, const std::vector<std::string>& words);
/// With `names` bare names, for completion.
ExitCode sheet_list(const Console& console, const SheetArguments& arguments, const std::string& pattern, bool names);

}  // namespace servobus::scanner::cli
