// What each verb does with its arguments, which are still as they were typed.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scanner/cli/console.hpp"
#include "scanner/cli/exit_code.hpp"
#include "scanner/cli/link.hpp"

namespace servobus::scanner::cli {

struct DiscoverArguments {
    std::optional<std::string> host;
    std::uint16_t port = enip::tcp_port;
    std::chrono::milliseconds wait{1000};
};

struct ListArguments {
    std::string pattern{};
    bool names = false;     ///< bare names, for completion
    bool commands = false;  ///< direct commands instead of parameters
};

ExitCode discover(const Console& console, const Settings& settings, const DiscoverArguments& arguments);
ExitCode identity(const Console& console, const Settings& settings, const std::string& host);
ExitCode get(const Console& console, const Settings& settings, const std::string& host,
             const std::vector<std::string>& whats);
ExitCode set(const Console& console, const Settings& settings, const std::string& host,
             const std::vector<std::string>& assignments);
ExitCode dump(const Console& console, const Settings& settings, const std::string& host);
ExitCode command(const Console& console, const Settings& settings, const std::string& host,
                 const std::string& mnemonic);
ExitCode call(const Console& console, const Settings& settings, const std::string& host, const std::string& service,
              const std::string& path, const std::vector<std::string>& data);
ExitCode list(const Console& console, const ListArguments& arguments);
ExitCode doctor(const Console& console, const std::string& file);

}  // namespace servobus::scanner::cli
