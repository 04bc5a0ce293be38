// The state of an axis on one screen.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "scanner/cli/axis.hpp"
#include "scanner/cli/explicit_axis_link.hpp"
#include "scanner/cli/text_output.hpp"

namespace servobus::scanner::cli {
namespace {

using Json = nlohmann::ordered_json;

/// Everything that a status has.
constexpr std::array shown{
    AxisValue::status_word,     AxisValue::control_word,  AxisValue::mode_requested,  AxisValue::mode,
    AxisValue::position,        AxisValue::target,        AxisValue::following_error, AxisValue::velocity,
    AxisValue::current,         AxisValue::force_current, AxisValue::error,           AxisValue::process_status,
    AxisValue::reference_state, AxisValue::inputs,        AxisValue::outputs,         AxisValue::temperature,
    AxisValue::supply,          AxisValue::error_text,    AxisValue::motor_type};

std::string line(std::string_view name, const std::string& value) { return fmt::format("{:<17}{}\n", name, value); }

/// "100000 increments"; "not told" when the device does not have it.
std::string number(const AxisState& state, AxisValue which, std::string_view unit) {
    if (!state.has(which)) return "not told";
    return unit.empty() ? fmt::format("{}", state.number(which)) : fmt::format("{} {}", state.number(which), unit);
}

std::string mode_line(const AxisState& state) {
    const auto requested = static_cast<int>(state.number(AxisValue::mode_requested));
    auto text = fmt::format("{} {}", state.mode(), mode_text(state.mode()));
    if (requested != state.mode()) text += fmt::format("; requested is {} {}", requested, mode_text(requested));
    return text;
}

std::string word(std::span<const BitText> bits, std::uint32_t value, int mode, int digits) {
    const auto texts = set_bits(bits, value, mode);
    const auto hex = fmt::format("0x{:0{}X}", value, digits);
    return texts.empty() ? hex : fmt::format("{}  {}", hex, fmt::join(texts, ", "));
}

std::string supply(const AxisState& state) {
    if (!state.has(AxisValue::supply)) return "not told";
    return fmt::format("{:.1f} V", static_cast<double>(state.number(AxisValue::supply)) / 1000);
}

std::string error_line(const AxisState& state) {
    const auto error = printable(error_text(state));
    return error.empty() ? "none" : error;
}

std::string reference_line(const AxisState& state) {
    return fmt::format("{} (TH {})", state.is_referenced() ? "referenced" : "not referenced",
                       number(state, AxisValue::reference_state, ""));
}

std::uint32_t control_word(const AxisState& state) {
    return static_cast<std::uint16_t>(state.number(AxisValue::control_word));
}

Json number_or_null(const AxisState& state, AxisValue which) {
    return state.has(which) ? Json(state.number(which)) : Json();
}

Json word_json(std::span<const BitText> bits, std::uint32_t value, int mode) {
    return {{"value", value}, {"bits", set_bits(bits, value, mode)}};
}

Json mode_json(std::int64_t mode) {
    return {{"value", mode}, {"text", std::string(mode_text(static_cast<int>(mode)))}};
}

}  // namespace

std::string status_text(const AxisState& state) {
    constexpr std::string_view increments = "increments";
    return line("state", std::string(state_text(state))) + line("mode", mode_line(state)) +
           line("error", error_line(state)) + line("reference", reference_line(state)) +
           line("motor", state.has(AxisValue::motor_type) ? printable(state.text(AxisValue::motor_type)) : "not told") +
           line("position", number(state, AxisValue::position, increments)) +
           line("target", number(state, AxisValue::target, increments)) +
           line("following error", number(state, AxisValue::following_error, increments)) +
           line("velocity", number(state, AxisValue::velocity, "increments/s")) +
           line("current", number(state, AxisValue::current, "mA")) +
           line("force current", number(state, AxisValue::force_current, "mA")) +
           line("temperature", number(state, AxisValue::temperature, "°C")) + line("motor supply", supply(state)) +
           line("control word", word(control_bits(), control_word(state), state.mode(), 4)) +
           line("status word", word(status_bits(), state.status_word(), state.mode(), 4)) +
           line("process status", word(process_bits(), state.process_status(), state.mode(), 8)) +
           line("inputs", word(input_bits(), state.inputs(), state.mode(), 8)) +
           line("outputs", word(output_bits(), state.outputs(), state.mode(), 8));
}

std::string status_json(const std::string& host, const AxisState& state) {
    const auto value = [&](AxisValue which) { return number_or_null(state, which); };
    Json axis{{"state", std::string(state_text(state))},
              {"mode", mode_json(state.mode())},
              {"mode_requested", mode_json(state.number(AxisValue::mode_requested))},
              {"error", value(AxisValue::error)},
              {"error_text", printable(state.text(AxisValue::error_text))},
              {"referenced", state.is_referenced()},
              {"reference_state", value(AxisValue::reference_state)},
              {"motor_type", printable(state.text(AxisValue::motor_type))},
              {"position", value(AxisValue::position)},
              {"target", value(AxisValue::target)},
              {"following_error", value(AxisValue::following_error)},
              {"velocity", value(AxisValue::velocity)},
              {"current_mA", value(AxisValue::current)},
              {"force_current_mA", value(AxisValue::force_current)},
              {"temperature", value(AxisValue::temperature)},
              {"supply_mV", value(AxisValue::supply)},
              {"control_word", word_json(control_bits(), control_word(state), state.mode())},
              {"status_word", word_json(status_bits(), state.status_word(), state.mode())},
              {"process_status", word_json(process_bits(), state.process_status(), state.mode())},
              {"inputs", word_json(input_bits(), state.inputs(), state.mode())},
              {"outputs", word_json(output_bits(), state.outputs(), state.mode())}};
    return Json{{"host", host}, {"axis", std::move(axis)}}.dump(2) + '\n';
}

std::string axis_json(const std::string& host, const std::string& verb, const AxisOutcome& outcome,
                      const AxisRunner& runner, const std::vector<std::string>& traces) {
    const auto& state = runner.state();
    const Json json{{"host", host},
                    {"verb", verb},
                    {"text", outcome.sentence},
                    {"state", std::string(state_text(state))},
                    {"position", number_or_null(state, AxisValue::position)},
                    {"seconds", runner.seconds()},
                    {"largest_following_error", runner.largest_following_error()},
                    {"traces", traces},
                    {"samples", runner.samples().size()}};
    return json.dump(2) + '\n';
}

ExitCode axis_status(const Console& console, const Settings& settings, const AxisOptions& options) {
    const auto where = parse_host(options.host);
    if (!where) return fail(console, where.error());
    Link link(settings, *where);
    if (const auto failure = link.open()) return fail(console, *failure, options.host);
    ExplicitAxisLink axis(link);
    AxisState state;
    if (const auto failure = axis.read(shown, state)) return fail(console, *failure, options.host);
    console.show(status_text(state), console.json ? status_json(options.host, state) : std::string());
    return ExitCode::done;
}

}  // namespace servobus::scanner::cli
