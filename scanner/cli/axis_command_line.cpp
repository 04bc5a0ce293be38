#include "scanner/cli/axis_command_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>

#include "drive/text.hpp"
#include "scanner/cli/duration.hpp"
#include "scanner/cli/io_command_line.hpp"

namespace servobus::scanner::cli {
namespace {

struct MethodName {
    std::string_view name;
    int number;
};

/// cw is clockwise, ccw counter clockwise; the second word is the way to the Z-mark (004 §4.2.19).
constexpr std::array<MethodName, 12> method_names{{
    {"positive", 1},
    {"negative", 2},
    {"gantry-positive-same", 3},
    {"gantry-negative-same", 4},
    {"gantry-positive-contrary", 5},
    {"gantry-negative-contrary", 6},
    {"cw-ccw", 10},
    {"cw-cw", 11},
    {"ccw-ccw", 12},
    {"ccw-cw", 13},
    {"cw-shortest", 14},
    {"ccw-shortest", 15},
}};

std::string lower(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

/// An option that holds a time.
CLI::Option* add_time(CLI::App& app, const std::string& name, std::function<void(Time)> take,
                      const std::string& description) {
    const auto read = [name, take = std::move(take)](const std::string& text) {
        const auto time = parse_duration(text);
        if (!time) throw CLI::ValidationError(name, time.error().text);
        take(*time);
    };
    return app.add_option_function<std::string>(name, read, description)->type_name("TIME");
}

/// What a row holds on the bus; its limits are the device's affair.
std::int64_t parse_value(const std::string& name, AxisValue which, const std::string& text) {
    const auto& row = row_of(which);
    const auto value = drive::parse(row, text);
    if (const auto* error = std::get_if<drive::ParseError>(&value)) {
        throw CLI::ValidationError(name, fmt::format("'{}': {}", text, error->reason));
    }
    return std::get<std::int64_t>(std::get<drive::Value>(value));
}

template <class Target>
CLI::Option* add_value(CLI::App& app, const std::string& name, AxisValue which, Target& target,
                       const std::string& description) {
    const auto read = [name, which, &target](const std::string& text) { target = parse_value(name, which, text); };
    const auto unit = row_of(which).unit;
    return app
        .add_option_function<std::string>(name, read,
                                          unit.empty() ? description : fmt::format("{}, in {}", description, unit))
        ->type_name(name.starts_with("--") ? "N" : "");
}

std::string method_list() {
    std::vector<std::string_view> names;
    names.reserve(method_names.size());
    for (const auto& row : method_names) names.push_back(row.name);
    return fmt::format("a number from 1 to 15, or {}", fmt::join(names, ", "));
}

int parse_method(const std::string& text) {
    const auto named = std::ranges::find(method_names, lower(text), &MethodName::name);
    if (named != method_names.end()) return named->number;
    const auto number = drive::parse_number(text).value_or(0);
    if (number < 1 || number > 15) throw CLI::ValidationError("--method", "it takes " + method_list());
    return static_cast<int>(number);
}

bool parse_direction(const std::string& text) {
    const auto word = lower(text);
    if (word != "positive" && word != "negative") {
        throw CLI::ValidationError("DIRECTION", fmt::format("'{}' is neither positive nor negative", text));
    }
    return word == "positive";
}

}  // namespace

void AxisCommandLine::add_to(CLI::App& app, const std::function<void(CLI::App&)>& decorate,
                             std::function<void(Action)> choose) {
    decorate_ = decorate;
    auto& axis = *app.add_subcommand("axis", "Move an axis: status, enable, reference, move, jog, halt, trace, ...");
    decorate_(axis);
    axis.require_subcommand(1);
    axis.add_option("HOST", options_.host, "Name or address of the drive, with :PORT if it is not 44818")
        ->required()
        ->type_name("");
    axis.footer(
        "Examples:\n"
        "  servobus-scanner axis 192.168.2.100 status\n"
        "  servobus-scanner axis 192.168.2.100 reference\n"
        "  servobus-scanner axis 192.168.2.100 move 100000 --trace move.svg\n"
        "  servobus-scanner axis 192.168.2.100 jog negative --speed 20000 --duration 2s\n"
        "  servobus-scanner axis 192.168.2.100 move 0 --io --rpi 2\n"
        "\nCtrl-C halts the axis; a second one leaves at once. 'axis HOST VERB --help' has more.");
    add_status(axis);
    add_power(axis);
    add_motions(axis, false);
    add_stops(axis);
    add_trace(axis);
    axis.callback([this, choose = std::move(choose)] {
        choose([this](const Console& console, const Settings& settings) {
            if (status_) return axis_status(console, settings, options_);
            return run_axis(console, settings, options_, verb_name_, make_verb_ ? make_verb_() : AxisVerb());
        });
    });
}

CLI::App& AxisCommandLine::add_verb(CLI::App& parent, const std::string& name, const std::string& description,
                                    const std::string& examples, std::function<AxisVerb()> make) {
    auto& verb = *parent.add_subcommand(name, description);
    decorate_(verb);
    if (name != "status") add_connection(verb);
    verb.footer("Examples:\n" + examples);
    verb.callback([this, name, make = std::move(make)] {
        verb_name_ = name;
        make_verb_ = make;
    });
    return verb;
}

void AxisCommandLine::add_connection(CLI::App& verb) {
    verb.add_flag("--io", options_.io, "Over an I/O connection instead of explicit messages");
    add_connection_option(verb, options_.connection);
    add_interval_option(verb, options_.connection, "4");
}

void AxisCommandLine::add_wait(CLI::App& verb) {
    add_time(
        verb, "--wait", [this](Time time) { options_.wait = time; },
        "Longest time for the motion, instead of what it should take");
}

void AxisCommandLine::add_trace_files(CLI::App& verb, const std::string& option) {
    verb.add_option(option, options_.traces, "Record the motion to this .csv or .svg file; may be given again")
        ->type_name("FILE")
        ->allow_extra_args(false);
    if (option == "--trace") {
        add_time(
            verb, "--interval", [this](Time time) { options_.interval = time; }, "Time between two samples (2ms)");
    }
}

void AxisCommandLine::add_status(CLI::App& axis) {
    auto& verb = add_verb(axis, "status", "Print the state of the axis in words",
                          "  servobus-scanner axis 192.168.2.100 status\n"
                          "  servobus-scanner axis 192.168.2.100 status --json\n",
                          {});
    verb.callback([this] { status_ = true; });
}

void AxisCommandLine::add_power(CLI::App& axis) {
    add_verb(axis, "enable", "Switch the power on, so that the axis holds its position",
             "  servobus-scanner axis 192.168.2.100 enable\n", [] { return AxisVerb(enable_axis); });
    add_verb(axis, "disable", "Switch the power off", "  servobus-scanner axis 192.168.2.100 disable\n",
             [] { return AxisVerb(disable_axis); });
    add_verb(axis, "fault-reset", "End a fault, and say what it was",
             "  servobus-scanner axis 192.168.2.100 fault-reset\n", [] { return AxisVerb(reset_fault); });
}

void AxisCommandLine::add_stops(CLI::App& axis) {
    auto& halt = add_verb(axis, "halt", "Stop the running motion and wait for standstill",
                          "  servobus-scanner axis 192.168.2.100 halt\n", [] { return AxisVerb(halt_axis); });
    add_wait(halt);
    add_verb(axis, "quick-stop", "Stop with the deceleration for emergencies",
             "  servobus-scanner axis 192.168.2.100 quick-stop\n", [] { return AxisVerb(quick_stop_axis); });
}

void AxisCommandLine::add_motions(CLI::App& parent, bool traced) {
    add_reference(parent, traced);
    add_move(parent, traced);
    add_jog(parent, traced);
    add_calibration(parent, traced);
}

void AxisCommandLine::add_reference(CLI::App& parent, bool traced) {
    auto& verb = add_verb(parent, "reference", "Switch the power on and find the absolute position",
                          "  servobus-scanner axis 192.168.2.100 reference\n"
                          "  servobus-scanner axis 192.168.2.100 reference --method negative\n"
                          "  servobus-scanner axis 192.168.2.100 reference --method cw-ccw --z-mark-speed 20000\n",
                          [this] { return reference_verb(method_, reference_); });
    verb.add_option_function<std::string>(
            "--method", [this](const std::string& text) { method_ = parse_method(text); },
            "Which way: " + method_list())
        ->type_name("METHOD");
    add_value(verb, "--sensor-speed", AxisValue::sensor_speed, reference_.sensor_speed,
              "Speed of a rotative motor to its sensor; 0 when there is none");
    add_value(verb, "--z-mark-speed", AxisValue::z_mark_speed, reference_.z_mark_speed,
              "Speed of a rotative motor to its Z-mark; 0 when there is none");
    add_wait(verb);
    if (!traced) add_trace_files(verb, "--trace");
}

void AxisCommandLine::add_move(CLI::App& parent, bool traced) {
    auto& verb = add_verb(parent, "move", "Move to a position, or by a distance",
                          "  servobus-scanner axis 192.168.2.100 move 100000\n"
                          "  servobus-scanner axis 192.168.2.100 move -5000 --relative --speed 20000\n"
                          "  servobus-scanner axis 192.168.2.100 move 0 --trace move.svg --trace move.csv\n",
                          [this] { return move_verb(move_); });
    add_value(verb, "POSITION", AxisValue::target, move_.position, "Where to, or how far")->required();
    verb.add_flag("--relative", move_.relative, "POSITION is a distance from where the axis stands");
    add_value(verb, "--speed", AxisValue::speed, move_.speed, "Speed");
    add_value(verb, "--acceleration", AxisValue::acceleration, move_.acceleration, "Acceleration and deceleration");
    add_value(verb, "--scurve", AxisValue::s_curve, move_.s_curve, "How round the speed's ramps are, 1 to 100");
    add_value(verb, "--window", AxisValue::target_window, move_.window, "How near the target is reached");
    add_value(verb, "--following-window", AxisValue::following_window, move_.following_window,
              "How far from the trajectory is a fault");
    add_wait(verb);
    if (!traced) add_trace_files(verb, "--trace");
}

void AxisCommandLine::add_jog(CLI::App& parent, bool traced) {
    auto& verb = add_verb(parent, "jog", "Move at a speed, until Ctrl-C or for a time",
                          "  servobus-scanner axis 192.168.2.100 jog positive --speed 20000\n"
                          "  servobus-scanner axis 192.168.2.100 jog negative --speed 20000 --duration 2s\n",
                          [this] { return jog_verb(jog_); });
    verb.add_option_function<std::string>(
            "DIRECTION", [this](const std::string& text) { jog_.positive = parse_direction(text); },
            "positive or negative")
        ->required()
        ->type_name("");
    add_value(verb, "--speed", AxisValue::speed, jog_.speed, "Speed")->required();
    add_value(verb, "--acceleration", AxisValue::acceleration, jog_.acceleration, "Acceleration and deceleration");
    add_time(
        verb, "--duration", [this](Time time) { jog_.duration = time; }, "How long at that speed; without it: Ctrl-C");
    if (!traced) add_trace_files(verb, "--trace");
}

void AxisCommandLine::add_calibration(CLI::App& parent, bool traced) {
    auto& verb = add_verb(parent, "force-calibrate", "Record cogging and friction over a way, to compensate them",
                          "  servobus-scanner axis 192.168.2.100 force-calibrate --way 30000\n"
                          "  servobus-scanner axis 192.168.2.100 force-calibrate --start 1000 --way 30000\n",
                          [this] { return force_calibration_verb(calibration_); });
    add_value(verb, "--start", AxisValue::calibration_start, calibration_.start, "Where to begin; without it: here");
    add_value(verb, "--way", AxisValue::calibration_way, calibration_.way, "How far, forward and back")->required();
    add_wait(verb);
    if (!traced) add_trace_files(verb, "--trace");
}

void AxisCommandLine::add_trace(CLI::App& axis) {
    auto& verb = *axis.add_subcommand("trace", "Record position, velocity, current and following error");
    decorate_(verb);
    add_connection(verb);
    verb.footer(
        "With a VERB it records from before that until it is done, and for --duration at least.\n"
        "\nExamples:\n"
        "  servobus-scanner axis 192.168.2.100 trace --duration 2s --out axis.csv\n"
        "  servobus-scanner axis 192.168.2.100 trace --duration 2s --out move.csv --out move.svg move 100000\n");
    add_trace_files(verb, "--out");
    verb.get_option("--out")->required();
    add_time(
        verb, "--duration", [this](Time time) { options_.duration = time; }, "How long (1s)");
    add_time(
        verb, "--interval", [this](Time time) { options_.interval = time; }, "Time between two samples (2ms)");
    verb.require_subcommand(0, 1);
    add_motions(verb, true);
    verb.callback([this] {
        if (verb_name_.empty()) verb_name_ = "trace";
    });
}

}  // namespace servobus::scanner::cli
