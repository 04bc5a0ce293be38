// list: the parameters and commands that exist, offline.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "drive/lookup.hpp"
#include "drive/xenax.hpp"
#include "scanner/cli/json_output.hpp"
#include "scanner/cli/pattern.hpp"
#include "scanner/cli/text_output.hpp"
#include "scanner/cli/verbs.hpp"

namespace servobus::scanner::cli {
namespace {

bool is_meant(const drive::Parameter& row, std::string_view pattern) {
    if (pattern.empty()) return true;
    const std::string words[]{std::string(row.name), std::string(row.mnemonic),
                              drive::qualified_name(drive::parameter_classes(), row), cip_address(row),
                              canopen_address(row)};
    return std::ranges::any_of(words, [&](const std::string& word) { return matches(pattern, lower_case(word)); });
}

bool is_meant(const drive::DirectCommand& command, std::string_view pattern) {
    return pattern.empty() || matches(pattern, lower_case(command.name)) ||
           matches(pattern, lower_case(command.mnemonic));
}

/// What completion offers: every name and mnemonic that means one parameter, and every name with its class.
std::string names_of(std::span<const drive::Parameter* const> rows) {
    std::set<std::string> names;
    for (const auto* row : rows) {
        names.insert(display_name(*row));
        names.insert(drive::qualified_name(drive::parameter_classes(), *row));
        const auto same = drive::find_by_name(drive::parameters(), drive::parameter_classes(), row->mnemonic);
        if (same.size() == 1) names.insert(std::string(row->mnemonic));
    }
    return fmt::format("{}\n", fmt::join(names, "\n"));
}

std::string names_of(std::span<const drive::DirectCommand* const> commands) {
    std::string text;
    for (const auto* command : commands) {
        text += fmt::format("{}\n", command->mnemonic.empty() ? command->name : command->mnemonic);
    }
    return text;
}

ExitCode nothing(const Console& console, const std::string& pattern, const std::vector<std::string>& near) {
    const auto hint = near.empty() ? "'servobus-scanner list' shows all" : suggestion(near);
    return fail(console, Mistake{fmt::format("nothing is called '{}'; {}", pattern, hint)});
}

ExitCode list_commands(const Console& console, const ListArguments& arguments) {
    const auto pattern = lower_case(arguments.pattern);
    std::vector<const drive::DirectCommand*> commands;
    for (const auto& command : drive::direct_commands()) {
        if (is_meant(command, pattern)) commands.push_back(&command);
    }
    if (commands.empty()) {
        return nothing(console, arguments.pattern,
                       drive::nearest_commands(drive::direct_commands(), arguments.pattern));
    }
    console.show(arguments.names ? names_of(commands) : commands_text(commands), commands_json(commands));
    return ExitCode::done;
}

}  // namespace

ExitCode list(const Console& console, const ListArguments& arguments) {
    if (arguments.commands) return list_commands(console, arguments);
    const auto pattern = lower_case(arguments.pattern);
    std::vector<const drive::Parameter*> rows;
    for (const auto& row : drive::parameters()) {
        if (is_meant(row, pattern)) rows.push_back(&row);
    }
    if (rows.empty()) {
        return nothing(console, arguments.pattern,
                       drive::nearest_names(drive::parameters(), drive::parameter_classes(), arguments.pattern));
    }
    console.show(arguments.names ? names_of(rows) : list_text(rows), console.json ? list_json(rows) : std::string());
    return ExitCode::done;
}

}  // namespace servobus::scanner::cli
