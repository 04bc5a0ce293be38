// Scripts that make a shell complete verbs, options, parameters and commands.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace servobus::scanner::cli {

/// What a shell needs to know about a verb.
struct VerbInfo {
    std::string name;
    std::string description;
    std::vector<std::string> options;  ///< `--json`
    std::vector<VerbInfo> verbs{};     ///< of its own
};

/// The script for bash, zsh or fish; nullopt for another shell.
[[nodiscard]] std::optional<std::string> completion_script(std::string_view shell, const std::vector<VerbInfo>& verbs);

}  // namespace servobus::scanner::cli
