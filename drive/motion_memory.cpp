#include "drive/motion_memory.hpp"

#include <algorithm>

#include "drive/device.hpp"
#include "drive/store.hpp"
#include "drive/text.hpp"

namespace servobus::drive {

namespace {

constexpr std::int64_t longest_wait_ms = 3'600'000;
constexpr std::int64_t inputs = 12;

std::string quoted(std::string_view word) { return "'" + std::string(word) + "'"; }

/// The settable row of a mnemonic. Of two addresses of one variable the first will do.
const Parameter* settable(std::span<const Parameter> table, std::string_view mnemonic) {
    const auto found = std::ranges::find_if(
        table, [&](const Parameter& row) { return row.mnemonic == mnemonic && may_set(row.access) && !row.is_text(); });
    return found == table.end() ? nullptr : &*found;
}

std::variant<ProgramStep, std::string> wait(ProgramStep::Kind kind, std::int64_t value, std::int64_t high) {
    const std::int64_t low = kind == ProgramStep::Kind::wait_time ? 0 : 1;
    if (value < low || value > high) return "must be " + std::to_string(low) + " to " + std::to_string(high);
    return ProgramStep{kind, {}, value};
}

}  // namespace

std::variant<ProgramStep, std::string> parse_step(std::span<const Parameter> table,
                                                  std::span<const DirectCommand> commands, Key direct_command_row,
                                                  std::string_view line) {
    const auto blank = line.find(' ');
    const auto word = line.substr(0, blank);
    if (blank == std::string_view::npos) {
        const auto command = std::ranges::find(commands, word, &DirectCommand::mnemonic);
        if (word.empty() || command == commands.end()) return quoted(word) + " is no direct command";
        return ProgramStep{ProgramStep::Kind::write, direct_command_row, command->value};
    }
    const auto number = parse_number(line.substr(blank + 1));
    if (!number) return quoted(line.substr(blank + 1)) + " is no number";
    if (word == "WT") return wait(ProgramStep::Kind::wait_time, *number, longest_wait_ms);
    if (word == "WI") return wait(ProgramStep::Kind::wait_input, *number, inputs);
    const Parameter* row = settable(table, word);
    if (row == nullptr) return quoted(word) + " is no command with a number";
    if (const auto refusal = check_value(*row, Value(*number))) return std::string(describe(*refusal));
    return ProgramStep{ProgramStep::Kind::write, row->key(), *number};
}

}  // namespace servobus::drive
