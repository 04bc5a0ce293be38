#include "drive/digital_io.hpp"

#include <optional>

namespace servobus::drive {
namespace {

constexpr std::uint16_t all_inputs = (1U << digital_inputs) - 1;

constexpr bool is_input(int number) { return number >= 1 && number <= digital_inputs; }
constexpr bool is_output(int number) { return number >= 1 && number <= digital_outputs; }
constexpr unsigned bit(int number) { return 1U << static_cast<unsigned>(number - 1); }

InputFunction input_function(std::int64_t type) {
    const bool known = type >= 0 && type <= static_cast<std::int64_t>(InputFunction::fault_reset);
    return known ? static_cast<InputFunction>(type) : InputFunction::none;
}

OutputFunction output_function(std::int64_t type) {
    const bool known = type >= 0 && type <= static_cast<std::int64_t>(OutputFunction::force_limit_reached);
    return known ? static_cast<OutputFunction>(type) : OutputFunction::none;
}

std::optional<InputAction> action_when_on(InputFunction function) {
    switch (function) {
        case InputFunction::reference:
            return InputAction::reference;
        case InputFunction::power_on:
        case InputFunction::power:
            return InputAction::power_on;
        case InputFunction::power_off:
            return InputAction::power_off;
        case InputFunction::stop:
            return InputAction::stop;
        case InputFunction::go_position:
            return InputAction::go_position;
        case InputFunction::go_way:
            return InputAction::go_way;
        case InputFunction::index:
        case InputFunction::index_both_edges:
            return InputAction::start_index;
        case InputFunction::program:
            return InputAction::start_program;
        case InputFunction::profile:
            return InputAction::start_profile;
        case InputFunction::jog_positive:
            return InputAction::jog_positive;
        case InputFunction::jog_negative:
            return InputAction::jog_negative;
        case InputFunction::drive_force:
            return InputAction::drive_force;
        case InputFunction::interrupt_program:
            return InputAction::interrupt_program;
        case InputFunction::capture_position:
            return InputAction::capture_position;
        case InputFunction::sector_offset:
            return InputAction::take_sector_offset;
        case InputFunction::fault_reset:
            return InputAction::fault_reset;
        case InputFunction::none:
        case InputFunction::negative_limit_switch:
        case InputFunction::positive_limit_switch:
        case InputFunction::emergency_exit:
        case InputFunction::emergency_exit_power_on:
            return std::nullopt;
    }
    return std::nullopt;
}

std::optional<InputAction> action_when_off(InputFunction function) {
    switch (function) {
        case InputFunction::power:
            return InputAction::power_off;
        case InputFunction::index_both_edges:
            return InputAction::start_index;
        case InputFunction::jog_positive:
        case InputFunction::jog_negative:
            return InputAction::stop;
        case InputFunction::interrupt_program:
            return InputAction::continue_program;
        default:
            return std::nullopt;
    }
}

InputRequest request_when_off(InputAction action, int input, const InputFunctionSettings& settings) {
    if (action == InputAction::start_index) return {.action = action, .input = input, .a = settings.b};
    return {.action = action, .input = input};
}

bool flag_of(OutputFunction function, const OutputFlags& flags, bool written) {
    switch (function) {
        case OutputFunction::none:
            return written;
        case OutputFunction::error:
            return flags.error;
        case OutputFunction::reference:
            return flags.reference;
        case OutputFunction::in_motion:
            return flags.in_motion;
        case OutputFunction::in_position:
            return flags.in_position;
        case OutputFunction::end_of_program:
            return flags.end_of_program;
        case OutputFunction::in_force:
            return flags.in_force;
        case OutputFunction::in_sector:
            return flags.in_sector;
        case OutputFunction::force_in_sector:
            return flags.force_in_sector;
        case OutputFunction::power_on:
            return flags.power_on;
        case OutputFunction::trigger:
            return flags.trigger;
        case OutputFunction::brake_released:
            return flags.brake_released;
        case OutputFunction::warning:
            return flags.warning;
        case OutputFunction::force_limit_reached:
            return flags.force_limit_reached;
    }
    return written;
}

}  // namespace

std::uint16_t with_input(std::uint16_t levels, int number, bool high) {
    if (!is_input(number)) return levels;
    return static_cast<std::uint16_t>(high ? levels | bit(number) : levels & ~bit(number));
}

bool is_set(std::uint16_t pattern, int number) { return is_input(number) && (pattern & bit(number)) != 0; }

std::uint16_t active_inputs(std::uint16_t levels, const InputSettings& settings) {
    unsigned inverted = 0;
    if (settings.low_active == 1) inverted = all_inputs;
    if (settings.low_active == 2) inverted = settings.low_active_mask;
    return static_cast<std::uint16_t>((levels ^ inverted) & all_inputs);
}

InputSignals input_signals(std::uint16_t levels, const InputSettings& settings) {
    const unsigned active = active_inputs(levels, settings);
    InputSignals signals;
    for (std::size_t i = 0; i < io_functions; ++i) {
        if ((active >> i & 1U) == 0) continue;
        const InputFunction function = input_function(settings.functions[i].type);
        signals.negative_limit_switch |= function == InputFunction::negative_limit_switch;
        signals.positive_limit_switch |= function == InputFunction::positive_limit_switch;
        signals.emergency_exit |= function == InputFunction::emergency_exit;
        signals.emergency_exit_power_on |= function == InputFunction::emergency_exit_power_on;
    }
    return signals;
}

InputRequests input_requests(std::uint16_t before, std::uint16_t now, const InputSettings& settings) {
    InputRequests requests;
    const unsigned changed = before ^ now;
    if (changed == 0) return requests;
    const unsigned active = active_inputs(now, settings);
    for (std::size_t i = 0; i < io_functions; ++i) {
        if ((changed >> i & 1U) == 0) continue;
        const InputFunctionSettings& set = settings.functions[i];
        const InputFunction function = input_function(set.type);
        const int input = static_cast<int>(i) + 1;
        const bool on = (active >> i & 1U) != 0;
        if (const auto action = on ? action_when_on(function) : action_when_off(function)) {
            requests.push(on ? InputRequest{*action, input, set.a, set.b, set.c}
                             : request_when_off(*action, input, set));
        }
    }
    return requests;
}

std::uint32_t digital_inputs_word(std::uint16_t levels, const InputSignals& signals) {
    std::uint32_t word = static_cast<std::uint32_t>(levels & all_inputs) << 16U;
    if (signals.negative_limit_switch) word |= 1U << 0U;
    if (signals.positive_limit_switch) word |= 1U << 1U;
    if (signals.emergency_exit || signals.emergency_exit_power_on) word |= 1U << 3U;
    return word;
}

void InputTracking::enable(int number) {
    if (number == 0) tracked_ = all_inputs;
    tracked_ = with_input(tracked_, number, true);
}

void InputTracking::disable(int number) {
    if (number == 0) tracked_ = 0;
    tracked_ = with_input(tracked_, number, false);
}

std::uint16_t InputTracking::reported(std::uint16_t before, std::uint16_t now) const {
    return events_ ? static_cast<std::uint16_t>((before ^ now) & tracked_) : std::uint16_t{0};
}

void DigitalOutputs::write(int number, bool on) {
    if (!is_output(number)) return;
    written_ = static_cast<std::uint8_t>(on ? written_ | bit(number) : written_ & ~bit(number));
}

std::uint8_t DigitalOutputs::states(const OutputSettings& settings, const OutputFlags& flags) const {
    unsigned states = 0;
    for (std::size_t i = 0; i < io_functions; ++i) {
        const bool written = (static_cast<unsigned>(written_) >> i & 1U) != 0;
        if (flag_of(output_function(settings.functions[i]), flags, written)) states |= 1U << i;
    }
    return static_cast<std::uint8_t>(states);
}

OutputLevel output_level(std::uint8_t states, int number, const OutputSettings& settings) {
    if (!is_output(number)) return OutputLevel::open;
    const bool driven = ((states ^ static_cast<unsigned>(~settings.high_active)) & bit(number)) != 0;
    switch (settings.type >> (2 * (number - 1)) & 3) {
        case 0:
            return driven ? OutputLevel::low : OutputLevel::open;
        case 1:
            return driven ? OutputLevel::high : OutputLevel::open;
        default:  // 3 is not a type; it is taken as 2
            return driven ? OutputLevel::high : OutputLevel::low;
    }
}

}  // namespace servobus::drive
