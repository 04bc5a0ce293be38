// The state machine against what the manual prints (tests/reference/xenax_ds402_transitions.csv, from 004 §4.1-4.2.3).
// The figure that says which states a transition joins is not in there; it stands here as a table.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "drive/ds402.hpp"
#include "tests/support/csv.hpp"
#include "tests/support/places.hpp"

namespace servobus::drive {
namespace {

using Event = Ds402::Event;
using State = Ds402::State;
using Transition = Ds402::Transition;

constexpr auto all_states = std::to_array<State>({
    State::not_ready_to_switch_on,
    State::switch_on_disabled,
    State::ready_to_switch_on,
    State::switched_on,
    State::operation_enabled,
    State::quick_stop_active,
    State::fault_reaction_active,
    State::fault,
});

/// An arrow of the figure.
struct Arrow {
    int number;
    std::string_view from;
    std::string_view to;
};

/// What a control word can do: 13 and 14 come from within the drive, 0 and 1 from power-on.
constexpr auto figure = std::to_array<Arrow>({
    {2, "Switch on disabled", "Ready to switch on"},
    {3, "Ready to switch on", "Switched on"},
    {4, "Switched on", "Operation enabled"},
    {5, "Operation enabled", "Switched on"},
    {6, "Switched on", "Ready to switch on"},
    {7, "Ready to switch on", "Switch on disabled"},
    {8, "Operation enabled", "Ready to switch on"},
    {9, "Operation enabled", "Switch on disabled"},
    {10, "Switched on", "Switch on disabled"},
    {11, "Operation enabled", "Quick stop active"},
    {12, "Quick stop active", "Switch on disabled"},
    {15, "Fault", "Switch on disabled"},
    {16, "Quick stop active", "Operation enabled"},
});

using test::Record;

std::vector<Record> printed_rows(const std::string& kind) {
    auto records = test::read_csv(test::data_path("reference/xenax_ds402_transitions.csv"));
    std::erase_if(records, [&](const Record& record) { return record.at("kind") != kind; });
    return records;
}

/// "2,6,8" or "3 + 4".
std::vector<int> numbers_in(const std::string& text) {
    std::vector<int> numbers;
    bool inside = false;
    for (const char c : text) {
        if (c < '0' || c > '9') {
            inside = false;
        } else if (inside) {
            numbers.back() = 10 * numbers.back() + (c - '0');
        } else {
            numbers.push_back(c - '0');
            inside = true;
        }
    }
    return numbers;
}

/// Whether a word has the printed bits: '0' and '1' as they are, 'x' any, the highest bit first.
bool looks_like(std::uint16_t word, std::string pattern) {
    std::erase(pattern, ' ');
    for (std::size_t i = 0; i < pattern.size(); ++i) {
        const bool bit = (word >> (pattern.size() - 1 - i) & 1) != 0;
        if (pattern[i] != 'x' && (pattern[i] == '1') != bit) {
            return false;
        }
    }
    return true;
}

/// Hears of everything, and does what a test wants.
struct Recorder : Ds402::Listener {
    bool allows(const Transition& transition) override {
        asked.push_back(transition.number);
        if (on_ask) {
            on_ask(transition);
        }
        return !forbidden.contains(transition.number);
    }
    void happened(const Transition& transition) override {
        numbers.push_back(transition.number);
        if (on_happened) {
            on_happened(transition);
        }
    }

    std::vector<int> asked;
    std::vector<int> numbers;
    std::set<int> forbidden;
    std::function<void(const Transition&)> on_ask;
    std::function<void(const Transition&)> on_happened;
};

/// A machine that local signals have led to a state; no control word has been written.
Ds402 machine_in(State state) {
    Ds402 machine;
    Recorder recorder;
    const auto signals = [&](std::initializer_list<Event> events) {
        for (const Event event : events) {
            machine.on_event(event, recorder);
        }
    };
    switch (state) {
        case State::not_ready_to_switch_on:
            break;
        case State::switch_on_disabled:
            signals({Event::initialised});
            break;
        case State::ready_to_switch_on:
            signals({Event::initialised, Event::shutdown});
            break;
        case State::switched_on:
            signals({Event::initialised, Event::shutdown, Event::switch_on});
            break;
        case State::operation_enabled:
            signals({Event::initialised, Event::shutdown, Event::switch_on, Event::enable_operation});
            break;
        case State::quick_stop_active:
            signals(
                {Event::initialised, Event::shutdown, Event::switch_on, Event::enable_operation, Event::quick_stop});
            break;
        case State::fault_reaction_active:
            signals({Event::initialised, Event::fault_detected});
            break;
        case State::fault:
            signals({Event::initialised, Event::fault_detected, Event::reaction_done});
            break;
    }
    return machine;
}

/// What manual and figure say of a word in a state: the transitions, and the state after them.
struct Expectation {
    std::vector<int> numbers;
    std::string state;
};

Expectation expected(const std::vector<Record>& commands, std::string_view state, std::uint16_t word,
                     bool bit_7_before) {
    Expectation result{{}, std::string(state)};
    for (const Record& command : commands) {
        std::string pattern = command.at("pattern");
        if (command.at("event").empty() && command.at("id") == "Fault reset") {
            if (bit_7_before) {
                continue;
            }
            pattern.front() = '1';  // the cell that print has lost (errata C-9)
        }
        if (!looks_like(static_cast<std::uint16_t>(word & 0xFF), pattern)) {
            continue;
        }
        // "3 + 4" is a chain; "2,6,8" are alternatives. No two leave the same state, so one loop does for both.
        for (const int number : numbers_in(command.at("transitions"))) {
            for (const Arrow& arrow : figure) {
                const bool already = std::ranges::find(result.numbers, number) != result.numbers.end();
                if (arrow.number == number && arrow.from == result.state && !already) {
                    result.numbers.push_back(number);
                    result.state = arrow.to;
                }
            }
        }
    }
    return result;
}

TEST(Ds402, StartsNotReadyAndKnowsNoWord) {
    const Ds402 machine;
    EXPECT_EQ(machine.state(), State::not_ready_to_switch_on);
    EXPECT_EQ(machine.status_word(), 0);
    EXPECT_EQ(machine.control_word(), 0);
}

TEST(Ds402, PowerOnGoesThroughRows0And1) {
    Ds402 machine;
    Recorder recorder;
    machine.on_event(Event::powered_on, recorder);
    EXPECT_EQ(machine.state(), State::not_ready_to_switch_on);
    machine.on_event(Event::initialised, recorder);
    EXPECT_EQ(machine.state(), State::switch_on_disabled);
    EXPECT_EQ(recorder.numbers, (std::vector{0, 1}));
}

TEST(Ds402, StatusWordsAreThePrintedPatterns) {
    const auto rows = printed_rows("state");
    ASSERT_EQ(rows.size(), all_states.size());
    for (const State state : all_states) {
        const Ds402 machine = machine_in(state);
        ASSERT_EQ(machine.state(), state);
        std::vector<std::string> shown;
        for (const Record& row : rows) {
            if (looks_like(machine.status_word(), row.at("pattern"))) {
                shown.push_back(row.at("id"));
            }
        }
        EXPECT_EQ(shown, std::vector{std::string(Ds402::name(state))});
        EXPECT_EQ(machine.status_word() & ~Ds402::state_bits, 0);
        EXPECT_EQ(Ds402::state_of(machine.status_word()), state);
    }
    EXPECT_EQ(machine_in(State::switch_on_disabled).status_word(), 0x0040);
    EXPECT_EQ(machine_in(State::ready_to_switch_on).status_word(), 0x0021);
    EXPECT_EQ(machine_in(State::switched_on).status_word(), 0x0023);
    EXPECT_EQ(machine_in(State::operation_enabled).status_word(), 0x0027);
    EXPECT_EQ(machine_in(State::quick_stop_active).status_word(), 0x0007);
}

TEST(Ds402, EveryStatusWordShowsThePrintedStateOrNone) {
    const auto rows = printed_rows("state");
    for (unsigned word = 0; word <= 0xFFFF; word += word < 0x200 ? 1 : 0x1F) {
        const auto bits = static_cast<std::uint16_t>(word);
        std::string printed;
        for (const Record& row : rows) {
            if (looks_like(bits, row.at("pattern"))) {
                printed += row.at("id");
            }
        }
        const auto state = Ds402::state_of(bits);
        ASSERT_EQ(state ? std::string(Ds402::name(*state)) : "", printed) << "word " << word;
    }
    EXPECT_EQ(Ds402::state_of(0x0031), State::ready_to_switch_on) << "bit 4 is no part of the state";
    EXPECT_EQ(Ds402::state_of(0x0001), std::nullopt);
}

TEST(Ds402, TablesAreThePrintedOnes) {
    const auto commands = printed_rows("command");
    ASSERT_EQ(Ds402::commands().size(), commands.size());
    for (std::size_t i = 0; i < commands.size(); ++i) {
        const auto& ours = Ds402::commands()[i];
        if (ours.event == Event::fault_reset) {
            EXPECT_EQ(commands[i].at("id"), "Fault reset");
            continue;
        }
        EXPECT_EQ(ours.mask, std::stoul(commands[i].at("mask"), nullptr, 16)) << commands[i].at("id");
        EXPECT_EQ(ours.value, std::stoul(commands[i].at("value"), nullptr, 16)) << commands[i].at("id");
    }
    const auto states = printed_rows("state");
    ASSERT_EQ(Ds402::patterns().size(), states.size());
    for (std::size_t i = 0; i < states.size(); ++i) {
        EXPECT_EQ(Ds402::patterns()[i].name, states[i].at("id"));
        EXPECT_EQ(Ds402::patterns()[i].mask, std::stoul(states[i].at("mask"), nullptr, 16));
        EXPECT_EQ(Ds402::patterns()[i].value, std::stoul(states[i].at("value"), nullptr, 16));
    }
    std::set<std::string> printed;
    for (const Record& row : printed_rows("transition")) {
        printed.insert(row.at("id"));
    }
    std::set<std::string> ours;
    for (const Transition& row : Ds402::transitions()) {
        ours.insert(std::to_string(row.number));
    }
    EXPECT_EQ(ours, printed);
}

TEST(Ds402, EveryRowHappensOnItsEvent) {
    for (const Transition& row : Ds402::transitions()) {
        Ds402 machine = machine_in(row.from);
        Recorder recorder;
        machine.on_event(row.event, recorder);
        EXPECT_EQ(machine.state(), row.to) << row.number;
        EXPECT_EQ(recorder.numbers, std::vector{row.number});
    }
}

TEST(Ds402, EveryArrowOfTheFigureIsReachedByAWord) {
    for (const Arrow& arrow : figure) {
        int words = 0;
        for (const State state : all_states) {
            for (std::uint16_t word = 0; word < 0x100; ++word) {
                Ds402 machine = machine_in(state);
                Recorder recorder;
                machine.on_control_word(word, recorder);
                words += std::ranges::find(recorder.numbers, arrow.number) != recorder.numbers.end() ? 1 : 0;
            }
        }
        EXPECT_GT(words, 0) << arrow.number;
    }
}

TEST(Ds402, EveryWordInEveryStateDoesWhatIsPrinted) {
    const auto commands = printed_rows("command");
    ASSERT_EQ(commands.size(), 8U);
    for (const State state : all_states) {
        const Ds402 start = machine_in(state);
        for (const bool bit_7_before : {false, true}) {
            std::array<Expectation, 0x100> expectations;
            for (std::uint16_t low = 0; low < 0x100; ++low) {
                expectations[low] = expected(commands, Ds402::name(state), low, bit_7_before);
            }
            Ds402 before = start;
            if (bit_7_before) {
                Recorder deaf;
                deaf.forbidden = {15};
                before.on_control_word(0x0080, deaf);  // no command but Fault reset, which is refused
                ASSERT_EQ(before.state(), state);
            }
            for (unsigned word = 0; word <= 0xFFFF; word += word < 0x400 ? 1 : 0x11) {
                const auto bits = static_cast<std::uint16_t>(word);
                Ds402 machine = before;
                Recorder recorder;
                machine.on_control_word(bits, recorder);
                const Expectation& expectation = expectations[bits & 0xFF];
                ASSERT_EQ(Ds402::name(machine.state()), expectation.state)
                    << "word " << word << " in " << Ds402::name(state);
                ASSERT_EQ(recorder.numbers, expectation.numbers) << "word " << word << " in " << Ds402::name(state);
                ASSERT_EQ(machine.control_word(), bits);
            }
        }
    }
}

TEST(Ds402, SwitchOnAndEnableInOneWord) {
    Ds402 machine = machine_in(State::ready_to_switch_on);
    Recorder recorder;
    machine.on_control_word(0x000F, recorder);
    EXPECT_EQ(machine.state(), State::operation_enabled);
    EXPECT_EQ(recorder.numbers, (std::vector{3, 4}));
    machine.on_control_word(0x0007, recorder);
    EXPECT_EQ(machine.state(), State::switched_on);
    machine.on_control_word(0x0007, recorder);
    EXPECT_EQ(machine.state(), State::switched_on);
    EXPECT_EQ(recorder.numbers, (std::vector{3, 4, 5}));
}

TEST(Ds402, ExampleOfCyclicPositionMode) {  // 004 §5.3.1, errata X-S1
    Ds402 machine = machine_in(State::switch_on_disabled);
    Recorder recorder;
    for (const std::uint16_t word : std::to_array<std::uint16_t>({0x06, 0x07, 0x0F, 0x06, 0x1F})) {
        machine.on_control_word(word, recorder);
    }
    EXPECT_EQ(machine.state(), State::operation_enabled);
    EXPECT_EQ(recorder.numbers, (std::vector{2, 3, 4, 8, 3, 4}));
}

TEST(Ds402, AWordThatIsWrittenAgainIsLookedAtAgain) {
    Ds402 machine = machine_in(State::ready_to_switch_on);
    Recorder recorder;
    recorder.forbidden = {3};
    machine.on_control_word(0x000F, recorder);
    EXPECT_EQ(machine.state(), State::ready_to_switch_on);
    recorder.forbidden = {4};
    machine.on_control_word(0x000F, recorder);
    EXPECT_EQ(machine.state(), State::switched_on);
    recorder.forbidden.clear();
    machine.on_control_word(0x000F, recorder);
    EXPECT_EQ(machine.state(), State::operation_enabled);
    EXPECT_EQ(recorder.asked, (std::vector{3, 3, 4, 4}));
    EXPECT_EQ(recorder.numbers, (std::vector{3, 4}));
}

TEST(Ds402, OnlyARisingBitResetsAFault) {
    Ds402 machine = machine_in(State::operation_enabled);
    Recorder recorder;
    machine.on_control_word(0x008F, recorder);  // rises where there is nothing to reset
    EXPECT_EQ(machine.state(), State::operation_enabled);
    machine.on_event(Event::fault_detected, recorder);
    EXPECT_EQ(machine.state(), State::fault_reaction_active);
    machine.on_control_word(0x0000, recorder);
    machine.on_control_word(0x0080, recorder);  // too early
    EXPECT_EQ(machine.state(), State::fault_reaction_active);
    machine.on_event(Event::reaction_done, recorder);
    EXPECT_EQ(machine.state(), State::fault);
    machine.on_control_word(0x0080, recorder);
    EXPECT_EQ(machine.state(), State::fault) << "it was high already";
    machine.on_control_word(0x0006, recorder);
    machine.on_control_word(0x0000, recorder);
    EXPECT_EQ(machine.state(), State::fault) << "falling, and other commands";
    machine.on_control_word(0x0086, recorder);
    EXPECT_EQ(machine.state(), State::switch_on_disabled);
    EXPECT_EQ(recorder.numbers, (std::vector{13, 14, 15}));
    machine.on_control_word(0x0086, recorder);
    EXPECT_EQ(machine.state(), State::switch_on_disabled) << "no command while bit 7 is set";
    machine.on_control_word(0x0006, recorder);
    EXPECT_EQ(machine.state(), State::ready_to_switch_on);
}

TEST(Ds402, AFaultThatIsStillThereIsNotReset) {
    Ds402 machine = machine_in(State::fault);
    Recorder recorder;
    recorder.forbidden = {15};
    machine.on_control_word(0x0080, recorder);
    EXPECT_EQ(machine.state(), State::fault);
    recorder.forbidden.clear();
    machine.on_control_word(0x0080, recorder);
    EXPECT_EQ(machine.state(), State::fault) << "the edge is over";
    machine.on_control_word(0x0000, recorder);
    machine.on_control_word(0x0080, recorder);
    EXPECT_EQ(machine.state(), State::switch_on_disabled);
    EXPECT_EQ(recorder.asked, (std::vector{15, 15}));
}

TEST(Ds402, ARefusedRowChangesNothing) {
    for (const Transition& row : Ds402::transitions()) {
        Ds402 machine = machine_in(row.from);
        Recorder recorder;
        recorder.forbidden = {row.number};
        machine.on_event(row.event, recorder);
        EXPECT_EQ(machine.state(), row.from) << row.number;
        EXPECT_TRUE(recorder.numbers.empty());
    }
}

TEST(Ds402, AFaultLeavesEveryStateButThoseOfAFault) {
    for (const State state : all_states) {
        Ds402 machine = machine_in(state);
        Recorder recorder;
        machine.on_event(Event::fault_detected, recorder);
        EXPECT_EQ(machine.state(), state == State::fault ? State::fault : State::fault_reaction_active);
        EXPECT_EQ(recorder.numbers.size(), state == State::fault || state == State::fault_reaction_active ? 0U : 1U);
    }
}

TEST(Ds402, ResetForgetsStateAndWord) {
    Ds402 machine = machine_in(State::operation_enabled);
    Recorder recorder;
    machine.on_control_word(0x00FF, recorder);
    machine.reset();
    EXPECT_EQ(machine.state(), State::not_ready_to_switch_on);
    EXPECT_EQ(machine.control_word(), 0);
    machine.on_control_word(0x0006, recorder);
    EXPECT_EQ(machine.state(), State::not_ready_to_switch_on);
    for (const Event event : {Event::fault_detected, Event::reaction_done}) {
        machine.on_event(event, recorder);
    }
    machine.on_control_word(0x0080, recorder);
    EXPECT_EQ(machine.state(), State::switch_on_disabled) << "the bit rises once more";
}

TEST(Ds402, AFaultWithinATransitionEndsTheWord) {
    Ds402 machine = machine_in(State::ready_to_switch_on);
    Recorder recorder;
    recorder.on_happened = [&](const Transition& transition) {
        if (transition.number == 3) {
            machine.on_event(Event::fault_detected, recorder);
        }
    };
    machine.on_control_word(0x000F, recorder);
    EXPECT_EQ(machine.state(), State::fault_reaction_active);
    EXPECT_EQ(recorder.numbers, (std::vector{3, 13}));
}

TEST(Ds402, AFaultReactionMayEndWithinItsTransition) {
    Ds402 machine = machine_in(State::operation_enabled);
    Recorder recorder;
    recorder.on_happened = [&](const Transition& transition) {
        if (transition.number == 13) {
            machine.on_event(Event::reaction_done, recorder);
        }
    };
    machine.on_event(Event::fault_detected, recorder);
    EXPECT_EQ(machine.state(), State::fault);
    EXPECT_EQ(recorder.numbers, (std::vector{13, 14}));
}

TEST(Ds402, AFaultWithinTheQuestionTakesTheRowAway) {
    Ds402 machine = machine_in(State::ready_to_switch_on);
    Recorder recorder;
    recorder.on_ask = [&](const Transition& transition) {
        if (transition.number == 3) {
            machine.on_event(Event::fault_detected, recorder);
        }
    };
    machine.on_control_word(0x0007, recorder);
    EXPECT_EQ(machine.state(), State::fault_reaction_active);
    EXPECT_EQ(recorder.numbers, std::vector{13});
}

TEST(Ds402, AnotherWordWithinATransitionReplacesTheFirst) {
    for (const auto& [word, state] : std::map<std::uint16_t, State>{{0x0007, State::switched_on},
                                                                    {0x0006, State::ready_to_switch_on},
                                                                    {0x000F, State::operation_enabled},
                                                                    {0x0000, State::switch_on_disabled}}) {
        Ds402 machine = machine_in(State::ready_to_switch_on);
        Recorder recorder;
        recorder.on_happened = [&machine, &recorder, inner = word](const Transition& transition) {
            if (transition.number == 3) {
                machine.on_control_word(inner, recorder);
            }
        };
        machine.on_control_word(0x000F, recorder);
        EXPECT_EQ(machine.state(), state) << "word " << word;
        EXPECT_EQ(machine.control_word(), word);
    }
}

TEST(Ds402, LocalSignalsWithinATransitionEndTheWord) {
    Ds402 machine = machine_in(State::ready_to_switch_on);
    Recorder recorder;
    recorder.on_happened = [&](const Transition& transition) {
        if (transition.number == 3) {
            machine.on_event(Event::enable_operation, recorder);
            machine.on_event(Event::quick_stop, recorder);
        }
    };
    machine.on_control_word(0x000F, recorder);
    EXPECT_EQ(machine.state(), State::quick_stop_active) << "row 16 takes a word of its own";
    EXPECT_EQ(recorder.numbers, (std::vector{3, 4, 11}));
}

TEST(Ds402, ARandomWalkKeepsToTheFigure) {
    constexpr std::uint64_t seed = 402;
    std::mt19937_64 random(seed);
    const auto rows = printed_rows("state");
    Ds402 machine;
    Recorder recorder;
    std::vector<Transition> trail;
    recorder.on_happened = [&](const Transition& transition) {
        EXPECT_EQ(machine.state(), transition.to);
        trail.push_back(transition);
    };
    std::set<State> visited;
    std::set<int> numbers;
    constexpr auto usual = std::to_array<std::uint16_t>({0x00, 0x02, 0x06, 0x07, 0x0F, 0x1F, 0x80});
    constexpr auto local = std::to_array<Event>(
        {Event::powered_on, Event::initialised, Event::fault_detected, Event::reaction_done, Event::shutdown});
    for (int step = 0; step < 20'000; ++step) {
        const State before = machine.state();
        trail.clear();
        const auto choice = random() % 10;
        if (choice < 6) {
            machine.on_control_word(usual[random() % usual.size()], recorder);
        } else if (choice < 8) {
            machine.on_control_word(static_cast<std::uint16_t>(random()), recorder);
        } else if (choice == 8) {
            machine.on_event(local[random() % local.size()], recorder);
        } else if (random() % 20 == 0) {
            machine.reset();
        }
        visited.insert(machine.state());
        State at = before;
        for (const Transition& transition : trail) {
            ASSERT_EQ(transition.from, at) << "seed " << seed << ", step " << step;
            at = transition.to;
            numbers.insert(transition.number);
        }
        ASSERT_LE(trail.size(), 2U) << "seed " << seed << ", step " << step;
        if (trail.size() == 2) {
            ASSERT_EQ(trail[0].number, 3);
            ASSERT_EQ(trail[1].number, 4);
        }
        ASSERT_EQ(Ds402::state_of(machine.status_word()), machine.state()) << "seed " << seed << ", step " << step;
        ASSERT_EQ(std::ranges::count_if(
                      rows, [&](const Record& row) { return looks_like(machine.status_word(), row.at("pattern")); }),
                  1)
            << "seed " << seed << ", step " << step;
    }
    EXPECT_EQ(visited.size(), all_states.size());
    EXPECT_EQ(numbers.size(), 17U) << "every transition from 0 to 16 is on the way";
}

}  // namespace
}  // namespace servobus::drive
