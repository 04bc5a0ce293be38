#include "drive/digital_io.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

namespace servobus::drive {
namespace {

InputSettings with_function(int input, InputFunction function, std::int32_t a = 0, std::int32_t b = 0,
                            std::int32_t c = 0) {
    InputSettings settings;
    settings.functions[static_cast<std::size_t>(input - 1)] = {static_cast<std::int64_t>(function), a, b, c};
    return settings;
}

std::vector<InputRequest> requests(std::uint16_t before, std::uint16_t now, const InputSettings& settings) {
    const InputRequests found = input_requests(before, now, settings);
    return {found.begin(), found.end()};
}

TEST(DigitalInputs, LevelsChangeOneByOne) {
    std::uint16_t levels = 0;
    levels = with_input(levels, 1, true);
    levels = with_input(levels, 12, true);
    EXPECT_EQ(levels, 0x801);
    EXPECT_TRUE(is_set(levels, 12));
    EXPECT_FALSE(is_set(levels, 2));
    EXPECT_EQ(with_input(levels, 1, false), 0x800);
    for (const int number : {-1, 0, 13, 100}) {
        EXPECT_EQ(with_input(levels, number, true), levels) << number;
        EXPECT_FALSE(is_set(0xFFFF, number)) << number;
    }
}

TEST(DigitalInputs, ActiveLevelIsThatOfIlaAndIlas) {
    struct Case {
        std::int64_t ila;
        std::uint16_t ilas;
        std::uint16_t levels;
        std::uint16_t active;
    };
    for (const auto& [ila, ilas, levels, active] : {
             Case{0, 0, 0x005, 0x005},
             Case{0, 0xFFF, 0x005, 0x005},  // ILAS counts with ILA 2 only
             Case{1, 0, 0x005, 0xFFA},
             Case{2, 0, 0x005, 0x005},
             Case{2, 0x803, 0x005, 0x806},
             Case{2, 0xFFFF, 0xF000, 0xFFF},  // there are twelve
             Case{7, 0xFFF, 0x005, 0x005},
         }) {
        InputSettings settings;
        settings.low_active = ila;
        settings.low_active_mask = ilas;
        EXPECT_EQ(active_inputs(levels, settings), active) << ila << " " << ilas;
    }
}

TEST(DigitalInputs, WordHasLevelsAndSwitches) {
    EXPECT_EQ(digital_inputs_word(0, {}), 0U);
    EXPECT_EQ(digital_inputs_word(0xFFF, {}), 0x0FFF0000U);
    EXPECT_EQ(digital_inputs_word(0xF001, {}), 0x00010000U);
    EXPECT_EQ(digital_inputs_word(0, {.negative_limit_switch = true}), 1U);
    EXPECT_EQ(digital_inputs_word(0, {.positive_limit_switch = true}), 2U);
    EXPECT_EQ(digital_inputs_word(0, {.emergency_exit_power_on = true}), 8U);
    EXPECT_EQ(digital_inputs_word(0x800, {.emergency_exit = true}), 0x08000008U);
}

struct Edge {
    InputFunction function;
    std::vector<InputAction> on;
    std::vector<InputAction> off;
};

const Edge edges[] = {
    {InputFunction::none, {}, {}},
    {InputFunction::reference, {InputAction::reference}, {}},
    {InputFunction::power_on, {InputAction::power_on}, {}},
    {InputFunction::power_off, {InputAction::power_off}, {}},
    {InputFunction::power, {InputAction::power_on}, {InputAction::power_off}},
    {InputFunction::stop, {InputAction::stop}, {}},
    {InputFunction::go_position, {InputAction::go_position}, {}},
    {InputFunction::go_way, {InputAction::go_way}, {}},
    {InputFunction::index, {InputAction::start_index}, {}},
    {InputFunction::index_both_edges, {InputAction::start_index}, {InputAction::start_index}},
    {InputFunction::program, {InputAction::start_program}, {}},
    {InputFunction::profile, {InputAction::start_profile}, {}},
    {InputFunction::jog_positive, {InputAction::jog_positive}, {InputAction::stop}},
    {InputFunction::jog_negative, {InputAction::jog_negative}, {InputAction::stop}},
    {InputFunction::drive_force, {InputAction::drive_force}, {}},
    {InputFunction::interrupt_program, {InputAction::interrupt_program}, {InputAction::continue_program}},
    {InputFunction::capture_position, {InputAction::capture_position}, {}},
    {InputFunction::sector_offset, {InputAction::take_sector_offset}, {}},
    {InputFunction::negative_limit_switch, {}, {}},
    {InputFunction::positive_limit_switch, {}, {}},
    {InputFunction::emergency_exit, {}, {}},
    {InputFunction::emergency_exit_power_on, {}, {}},
    {InputFunction::fault_reset, {InputAction::fault_reset}, {}},
};

std::vector<InputAction> actions(std::uint16_t before, std::uint16_t now, const InputSettings& settings) {
    std::vector<InputAction> found;
    for (const InputRequest& request : requests(before, now, settings)) found.push_back(request.action);
    return found;
}

TEST(DigitalInputs, EveryFunctionActsOnItsEdges) {
    ASSERT_EQ(std::size(edges), 23U) << "TYIF goes from 0 to 22";
    for (std::size_t i = 0; i < std::size(edges); ++i) {
        EXPECT_EQ(static_cast<std::size_t>(edges[i].function), i);
        for (int input = 1; input <= 8; ++input) {
            const InputSettings settings = with_function(input, edges[i].function);
            const std::uint16_t high = with_input(0, input, true);
            EXPECT_EQ(actions(0, high, settings), edges[i].on) << i;
            EXPECT_EQ(actions(high, 0, settings), edges[i].off) << i;
            EXPECT_TRUE(actions(high, high, settings).empty()) << i;
        }
    }
}

TEST(DigitalInputs, RequestsCarryTheArgumentsOfTheFunction) {
    EXPECT_EQ(requests(0, 4, with_function(3, InputFunction::go_position, -5000, 20'000, 100)),
              (std::vector{InputRequest{InputAction::go_position, 3, -5000, 20'000, 100}}));
    const InputSettings index = with_function(1, InputFunction::index_both_edges, 7, 8);
    EXPECT_EQ(requests(0, 1, index).front().a, 7);
    EXPECT_EQ(requests(1, 0, index).front().a, 8);
    EXPECT_EQ(requests(1, 0, with_function(1, InputFunction::jog_positive, 7)),
              (std::vector{InputRequest{InputAction::stop, 1}}));
}

TEST(DigitalInputs, SeveralEdgesAskInTheOrderOfTheInputs) {
    InputSettings settings;
    for (auto& function : settings.functions) function.type = static_cast<std::int64_t>(InputFunction::power);
    const auto all = requests(0, 0xFFF, settings);
    ASSERT_EQ(all.size(), 8U) << "inputs 9 to 12 have no function";
    for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i].input, static_cast<int>(i) + 1);
}

TEST(DigitalInputs, LowActiveInputsActOnTheFallingLevel) {
    InputSettings settings = with_function(1, InputFunction::power);
    settings.low_active = 1;
    EXPECT_EQ(actions(1, 0, settings), std::vector{InputAction::power_on});
    EXPECT_EQ(actions(0, 1, settings), std::vector{InputAction::power_off});
}

TEST(DigitalInputs, UnknownFunctionsDoNothing) {
    for (const std::int64_t type : {std::int64_t{-1}, std::int64_t{23}, std::int64_t{256 + 1}}) {
        InputSettings settings;
        settings.functions[0].type = type;
        EXPECT_TRUE(requests(0, 1, settings).empty());
        EXPECT_EQ(input_signals(1, settings), InputSignals{});
    }
}

TEST(DigitalInputs, SignalsLastAsLongAsTheirInputIsActive) {
    struct Case {
        InputFunction function;
        InputSignals signals;
    };
    for (const auto& [function, signals] :
         {Case{InputFunction::negative_limit_switch, {.negative_limit_switch = true}},
          Case{InputFunction::positive_limit_switch, {.positive_limit_switch = true}},
          Case{InputFunction::emergency_exit, {.emergency_exit = true}},
          Case{InputFunction::emergency_exit_power_on, {.emergency_exit_power_on = true}}}) {
        InputSettings settings = with_function(8, function);
        EXPECT_EQ(input_signals(0x80, settings), signals);
        EXPECT_EQ(input_signals(0xF7F, settings), InputSignals{});
        settings.low_active = 2;
        settings.low_active_mask = 0x80;
        EXPECT_EQ(input_signals(0x00, settings), signals) << "a broken wire stops the axis";
    }
}

TEST(DigitalInputs, GoingThereAndBackIsOneRequestEachAtMost) {
    std::mt19937 random(1);
    for (int run = 0; run < 10'000; ++run) {
        InputSettings settings;
        settings.low_active = static_cast<std::int64_t>(random() % 3);
        settings.low_active_mask = static_cast<std::uint16_t>(random() & 0xFFF);
        for (auto& function : settings.functions) function.type = static_cast<std::int64_t>(random() % 23);
        const auto before = static_cast<std::uint16_t>(random() & 0xFFF);
        const auto now = static_cast<std::uint16_t>(random() & 0xFFF);
        ASSERT_TRUE(requests(now, now, settings).empty());
        unsigned asked = 0;
        for (const InputRequest& request : requests(before, now, settings)) {
            ASSERT_NE(is_set(before, request.input), is_set(now, request.input));
            ASSERT_EQ(asked >> (request.input - 1), 0U) << "ascending";
            asked |= 1U << (request.input - 1);
        }
    }
}

TEST(InputTracking, ReportsChangesOfTrackedInputsWhileEventsAreOn) {
    InputTracking tracking;
    tracking.enable(3);
    tracking.enable(12);
    tracking.enable(13);
    EXPECT_EQ(tracking.tracked(), 0x804);
    EXPECT_EQ(tracking.reported(0, 0xFFF), 0);
    tracking.set_events(true);
    EXPECT_EQ(tracking.reported(0, 0xFFF), 0x804);
    EXPECT_EQ(tracking.reported(0xFFF, 0x7FF), 0x800);
    EXPECT_EQ(tracking.reported(0xFFF, 0xFFF), 0);
    tracking.disable(12);
    EXPECT_EQ(tracking.tracked(), 0x004);
}

TEST(InputTracking, NumberZeroMeansAll) {
    InputTracking tracking;
    tracking.enable(0);
    EXPECT_EQ(tracking.tracked(), 0xFFF);
    tracking.disable(1);
    EXPECT_EQ(tracking.tracked(), 0xFFE);
    tracking.disable(0);
    EXPECT_EQ(tracking.tracked(), 0);
}

TEST(DigitalOutputs, TheLastWriterWins) {
    DigitalOutputs outputs;
    outputs.set(1);
    outputs.set(8);
    EXPECT_EQ(outputs.states({}, {}), 0x81);
    EXPECT_EQ(outputs.word(), 0x00810000U);
    outputs.clear(1);
    EXPECT_EQ(outputs.states({}, {}), 0x80);
    outputs.set_all(0x0F);
    EXPECT_EQ(outputs.states({}, {}), 0x0F);
    outputs.write_word(0xFFA5FFFFU);
    EXPECT_EQ(outputs.states({}, {}), 0xA5);
    EXPECT_EQ(outputs.word(), 0x00A50000U);
}

TEST(DigitalOutputs, ThereAreEight) {
    DigitalOutputs outputs;
    for (const int number : {-1, 0, 9, 33}) {
        outputs.set(number);
        EXPECT_EQ(outputs.word(), 0U) << number;
        EXPECT_EQ(output_level(0xFF, number, {}), OutputLevel::open) << number;
    }
}

struct FlagCase {
    OutputFunction function;
    bool OutputFlags::*flag;
};

const FlagCase flag_cases[] = {
    {OutputFunction::error, &OutputFlags::error},
    {OutputFunction::reference, &OutputFlags::reference},
    {OutputFunction::in_motion, &OutputFlags::in_motion},
    {OutputFunction::in_position, &OutputFlags::in_position},
    {OutputFunction::end_of_program, &OutputFlags::end_of_program},
    {OutputFunction::in_force, &OutputFlags::in_force},
    {OutputFunction::in_sector, &OutputFlags::in_sector},
    {OutputFunction::force_in_sector, &OutputFlags::force_in_sector},
    {OutputFunction::power_on, &OutputFlags::power_on},
    {OutputFunction::trigger, &OutputFlags::trigger},
    {OutputFunction::brake_released, &OutputFlags::brake_released},
    {OutputFunction::warning, &OutputFlags::warning},
    {OutputFunction::force_limit_reached, &OutputFlags::force_limit_reached},
};

TEST(DigitalOutputs, EveryFunctionFollowsItsFlagAlone) {
    ASSERT_EQ(std::size(flag_cases), 13U) << "TYOF goes from 0 to 13";
    for (std::size_t i = 0; i < std::size(flag_cases); ++i) {
        EXPECT_EQ(static_cast<std::size_t>(flag_cases[i].function), i + 1);
        for (std::size_t output = 0; output < io_functions; ++output) {
            OutputSettings settings;
            settings.functions[output] = static_cast<std::int64_t>(flag_cases[i].function);
            for (std::size_t other = 0; other < std::size(flag_cases); ++other) {
                OutputFlags flags;
                flags.*flag_cases[other].flag = true;
                EXPECT_EQ(DigitalOutputs().states(settings, flags), other == i ? 1U << output : 0U) << i << other;
            }
        }
    }
}

TEST(DigitalOutputs, AnOutputWithAFunctionIsNotWrittenButKeepsWhatIs) {
    DigitalOutputs outputs;
    OutputSettings settings;
    settings.functions[1] = static_cast<std::int64_t>(OutputFunction::error);
    outputs.set_all(0xFF);
    EXPECT_EQ(outputs.states(settings, {}), 0xFD);
    outputs.clear(2);
    EXPECT_EQ(outputs.states(settings, {.error = true}), 0xFF);
    outputs.set(2);
    settings.functions[1] = 0;
    EXPECT_EQ(outputs.states(settings, {}), 0xFF);
}

TEST(DigitalOutputs, UnknownFunctionsShowWhatIsWritten) {
    DigitalOutputs outputs;
    outputs.set(1);
    OutputSettings settings;
    settings.functions[0] = 14;
    settings.functions[1] = -1;
    EXPECT_EQ(outputs.states(settings, {}), 1);
}

TEST(DigitalOutputs, LevelFollowsTypeAndActivity) {
    struct Case {
        std::string name;
        unsigned type;
        bool high_active;
        bool state;
        OutputLevel level;
    };
    for (const Case& c : {
             Case{"sink", 0, true, true, OutputLevel::low},
             Case{"sink", 0, true, false, OutputLevel::open},
             Case{"sink low active", 0, false, true, OutputLevel::open},
             Case{"sink low active", 0, false, false, OutputLevel::low},
             Case{"source", 1, true, true, OutputLevel::high},  // 004 §4.2.27: logic 1 is 24 V, logic 0 is open
             Case{"source", 1, true, false, OutputLevel::open},
             Case{"source low active", 1, false, true, OutputLevel::open},
             Case{"source low active", 1, false, false, OutputLevel::high},
             Case{"both", 2, true, true, OutputLevel::high},
             Case{"both", 2, true, false, OutputLevel::low},
             Case{"both low active", 2, false, true, OutputLevel::low},
             Case{"both low active", 2, false, false, OutputLevel::high},
             Case{"as both", 3, true, false, OutputLevel::low},
         }) {
        for (int number = 1; number <= digital_outputs; ++number) {
            OutputSettings settings;
            const unsigned bit = 1U << (number - 1);
            settings.type = static_cast<std::uint16_t>(c.type << (2 * (number - 1)));
            settings.high_active = static_cast<std::uint8_t>(c.high_active ? 0xFF : ~bit);
            const auto states = static_cast<std::uint8_t>(c.state ? bit : 0U);
            EXPECT_EQ(output_level(states, number, settings), c.level) << c.name << number;
        }
    }
}

TEST(DigitalOutputs, DefaultsAreSourceAndHighActive) {
    EXPECT_EQ(output_level(0x01, 1, {}), OutputLevel::high);
    EXPECT_EQ(output_level(0x01, 2, {}), OutputLevel::open);
}

}  // namespace
}  // namespace servobus::drive
