#include "drive/ds402.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace servobus::drive {

namespace {

using Command = Ds402::Command;
using Event = Ds402::Event;
using Pattern = Ds402::Pattern;
using State = Ds402::State;
using Transition = Ds402::Transition;

constexpr std::uint16_t fault_reset_bit = 0x0080;

// 004 §4.2.2, row by row. "Switch on + enable operation" is a second word that switches on; what follows is the row of
// Enable operation, which has the same word. The cell of Fault reset is empty in print: it is the rising bit (errata
// C-9).
constexpr auto command_table = std::to_array<Command>({
    {Event::shutdown, 0x0087, 0x0006},
    {Event::switch_on, 0x008F, 0x0007},
    {Event::switch_on, 0x008F, 0x000F},
    {Event::disable_voltage, 0x0082, 0x0000},
    {Event::quick_stop, 0x0086, 0x0002},
    {Event::disable_operation, 0x008F, 0x0007},
    {Event::enable_operation, 0x008F, 0x000F},
    {Event::fault_reset, fault_reset_bit, fault_reset_bit},
});

// 004 §4.1; which states a row joins stands in its figure, and in CiA 402.
//  0  CiA 402 has a start before Not ready to switch on; here the reset has led there already.
// 12  is not printed; 004 §4.2.2 lists it under Disable voltage (errata C-8).
// 13  leaves every state but the two of a fault, Not ready to switch on too: a self-test that fails has to show.
// 16  needs a quick stop option code of 5 to 8. Object 605Ah is not in the manuals (errata C-10); the drive acts as
//     with 6: it ramps down and stays in Quick stop active. So 12 is a command, and 16 is there.
constexpr auto transition_table = std::to_array<Transition>({
    {0, State::not_ready_to_switch_on, Event::powered_on, State::not_ready_to_switch_on},
    {1, State::not_ready_to_switch_on, Event::initialised, State::switch_on_disabled},
    {2, State::switch_on_disabled, Event::shutdown, State::ready_to_switch_on},
    {3, State::ready_to_switch_on, Event::switch_on, State::switched_on},
    {4, State::switched_on, Event::enable_operation, State::operation_enabled},
    {5, State::operation_enabled, Event::disable_operation, State::switched_on},
    {6, State::switched_on, Event::shutdown, State::ready_to_switch_on},
    {7, State::ready_to_switch_on, Event::quick_stop, State::switch_on_disabled},
    {7, State::ready_to_switch_on, Event::disable_voltage, State::switch_on_disabled},
    {8, State::operation_enabled, Event::shutdown, State::ready_to_switch_on},
    {9, State::operation_enabled, Event::disable_voltage, State::switch_on_disabled},
    {10, State::switched_on, Event::disable_voltage, State::switch_on_disabled},
    {10, State::switched_on, Event::quick_stop, State::switch_on_disabled},
    {11, State::operation_enabled, Event::quick_stop, State::quick_stop_active},
    {12, State::quick_stop_active, Event::disable_voltage, State::switch_on_disabled},
    {13, State::not_ready_to_switch_on, Event::fault_detected, State::fault_reaction_active},
    {13, State::switch_on_disabled, Event::fault_detected, State::fault_reaction_active},
    {13, State::ready_to_switch_on, Event::fault_detected, State::fault_reaction_active},
    {13, State::switched_on, Event::fault_detected, State::fault_reaction_active},
    {13, State::operation_enabled, Event::fault_detected, State::fault_reaction_active},
    {13, State::quick_stop_active, Event::fault_detected, State::fault_reaction_active},
    {14, State::fault_reaction_active, Event::reaction_done, State::fault},
    {15, State::fault, Event::fault_reset, State::switch_on_disabled},
    {16, State::quick_stop_active, Event::enable_operation, State::operation_enabled},
});

constexpr int switching_on = 3;  // the row that another one may follow

// 004 §4.2.3, in the order of State.
constexpr auto pattern_table = std::to_array<Pattern>({
    {State::not_ready_to_switch_on, 0x004F, 0x0000, "Not ready to switch on"},
    {State::switch_on_disabled, 0x004F, 0x0040, "Switch on disabled"},
    {State::ready_to_switch_on, 0x006F, 0x0021, "Ready to switch on"},
    {State::switched_on, 0x006F, 0x0023, "Switched on"},
    {State::operation_enabled, 0x006F, 0x0027, "Operation enabled"},
    {State::quick_stop_active, 0x006F, 0x0007, "Quick stop active"},
    {State::fault_reaction_active, 0x004F, 0x000F, "Fault reaction active"},
    {State::fault, 0x004F, 0x0008, "Fault"},
});

constexpr const Pattern& pattern_of(State state) { return pattern_table[static_cast<std::size_t>(state)]; }

/// Where the pattern leaves quick stop (bit 5) open, it is 0: Switch on disabled is 0x40.
constexpr std::uint16_t status_word_of(State state) { return pattern_of(state).value; }

constexpr bool matches(const Command& command, std::uint16_t word, bool reset_bit_rises) {
    return (word & command.mask) == command.value && (command.event != Event::fault_reset || reset_bit_rises);
}

constexpr const Transition* row_of(State from, Event event) {
    for (const Transition& row : transition_table) {
        if (row.from == from && row.event == event) {
            return &row;
        }
    }
    return nullptr;
}

// What the rest of the program relies on, proved while compiling.

/// The bits that choose a command; the other eleven need not be tried.
constexpr std::uint16_t command_bits = 0x008F;

constexpr bool commands_look_at_few_bits() {
    return std::ranges::all_of(command_table, [](const Command& command) {
        return (command.mask & ~command_bits) == 0 && (command.value & ~command.mask) == 0;
    });
}

constexpr bool rows_differ_in_state_or_event() {
    for (std::size_t i = 0; i < transition_table.size(); ++i) {
        for (std::size_t k = i + 1; k < transition_table.size(); ++k) {
            if (transition_table[i].from == transition_table[k].from &&
                transition_table[i].event == transition_table[k].event) {
                return false;
            }
        }
    }
    return true;
}

/// In no state does a word mean two rows, not even with a rising reset bit.
constexpr bool words_are_unambiguous() {
    for (const Pattern& pattern : pattern_table) {
        for (std::uint16_t word = 0; word <= command_bits; ++word) {
            if ((word & ~command_bits) != 0) {
                continue;
            }
            const auto rows = std::ranges::count_if(command_table, [&](const Command& command) {
                return matches(command, word, true) && row_of(pattern.state, command.event) != nullptr;
            });
            if (rows > 1) {
                return false;
            }
        }
    }
    return true;
}

constexpr bool all_numbers_appear_in_order() {
    const bool ordered = std::ranges::is_sorted(transition_table, {}, &Transition::number);
    for (int number = 0; number <= 16; ++number) {
        if (std::ranges::find(transition_table, number, &Transition::number) == transition_table.end()) {
            return false;
        }
    }
    return ordered && transition_table.front().number == 0 && transition_table.back().number == 16;
}

constexpr bool patterns_do_not_overlap() {
    for (std::size_t i = 0; i < pattern_table.size(); ++i) {
        for (std::size_t k = i + 1; k < pattern_table.size(); ++k) {
            const int seen_by_both = pattern_table[i].mask & pattern_table[k].mask;
            if (((pattern_table[i].value ^ pattern_table[k].value) & seen_by_both) == 0) {
                return false;
            }
        }
    }
    return true;
}

constexpr bool status_words_fit_their_patterns() {
    for (std::size_t i = 0; i < pattern_table.size(); ++i) {
        const Pattern& pattern = pattern_table[i];
        const std::uint16_t word = status_word_of(pattern.state);
        if (pattern.state != static_cast<State>(i) || (word & pattern.mask) != pattern.value ||
            (word & ~Ds402::state_bits) != 0 || (pattern.mask & ~Ds402::state_bits) != 0) {
            return false;
        }
    }
    return true;
}

static_assert(pattern_table.size() == static_cast<std::size_t>(State::fault) + 1);
static_assert(commands_look_at_few_bits());
static_assert(rows_differ_in_state_or_event());
static_assert(words_are_unambiguous());
static_assert(all_numbers_appear_in_order());
static_assert(patterns_do_not_overlap());
static_assert(status_words_fit_their_patterns());
static_assert(status_word_of(State::switch_on_disabled) == 0x0040);
static_assert(status_word_of(State::operation_enabled) == 0x0027);

}  // namespace

std::span<const Command> Ds402::commands() { return command_table; }

std::span<const Transition> Ds402::transitions() { return transition_table; }

std::span<const Pattern> Ds402::patterns() { return pattern_table; }

std::string_view Ds402::name(State state) { return pattern_of(state).name; }

std::optional<State> Ds402::state_of(std::uint16_t status_word) {
    const auto found = std::ranges::find_if(
        pattern_table, [status_word](const Pattern& pattern) { return (status_word & pattern.mask) == pattern.value; });
    return found == pattern_table.end() ? std::nullopt : std::optional(found->state);
}

std::uint16_t Ds402::status_word() const { return status_word_of(state_); }

void Ds402::on_control_word(std::uint16_t word, Listener& listener) {
    const std::uint16_t before = std::exchange(control_word_, word);
    const bool reset_bit_rises = (word & fault_reset_bit) != 0 && (before & fault_reset_bit) == 0;
    for (const Command& command : command_table) {
        if (!matches(command, word, reset_bit_rises) || row_of(state_, command.event) == nullptr) {
            continue;
        }
        const Transition* done = take(command.event, listener);
        // Only row 3 may be followed by another, row 4; and not when the listener has met a fault in the meantime, or
        // written another word.
        if (done == nullptr || done->number != switching_on || state_ != done->to || control_word_ != word) {
            return;
        }
    }
}

void Ds402::on_event(Event event, Listener& listener) { take(event, listener); }

void Ds402::reset() {
    state_ = State::not_ready_to_switch_on;
    control_word_ = 0;
}

/// The row that happened, or nullptr. The state changes before the listener hears of it, so that whatever the listener
/// does to the machine starts from a state of the table.
const Transition* Ds402::take(Event event, Listener& listener) {
    const Transition* row = row_of(state_, event);
    if (row == nullptr || !listener.allows(*row) || state_ != row->from) {
        return nullptr;
    }
    state_ = row->to;
    listener.happened(*row);
    return row;
}

}  // namespace servobus::drive
