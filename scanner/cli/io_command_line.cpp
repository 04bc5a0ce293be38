#include "scanner/cli/io_command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "scanner/cli/duration.hpp"

namespace servobus::scanner::cli {
namespace {

constexpr int highest_priority = 99;
constexpr int most_cpus = 1024;

constexpr auto io_examples =
    "Examples:\n"
    "  servobus-scanner io 192.168.2.100\n"
    "  servobus-scanner io 192.168.2.100 --rpi 2 --set TargetPositionOrDistance=1000 --duration 10\n"
    "  servobus-scanner io 192.168.2.100 --connection input-only --csv inputs.csv\n"
    "  servobus-scanner io 192.168.1.20 --eds valve.eds 'Exclusive Owner' --set Valve1=On\n"
    "  servobus-scanner io 192.168.1.20 --o2t 150 --o2t-size 8 --t2o 100 --t2o-size 8 --config-instance 151\n"
    "\nThe outputs of a XENAX, and those that a data sheet names, begin as the device has them, so that opening "
    "changes\n"
    "nothing; all others begin with zeros. A drive whose connection ends stops. Ctrl-C closes the connection; a second "
    "one leaves at once.";
constexpr auto open_examples =
    "Examples:\n"
    "  servobus-scanner open 192.168.2.100\n"
    "  servobus-scanner open 192.168.2.100 --connection input-only --rpi 1\n"
    "  servobus-scanner open 192.168.1.20 --o2t 150 --o2t-size 8 --t2o 100 --t2o-size 8 --config-instance 151\n"
    "\nIt sends idle. A drive that moves stops when its owner's connection closes; --connection input-only owns "
    "nothing.";

void add_text(CLI::App& app, const std::string& name, std::string& target, const std::string& type,
              const std::string& description) {
    app.add_option(name, target, description)->type_name(type);
}

}  // namespace

void add_connection_option(CLI::App& app, ConnectionArguments& arguments) {
    add_text(app, "--connection", arguments.connection, "NAME",
             fmt::format("A connection of the XENAX: {} (standard)", connection_keys()));
}

void add_interval_option(CLI::App& app, ConnectionArguments& arguments, const std::string& usual) {
    add_text(app, "--rpi", arguments.rpi, "MS",
             fmt::format("Requested packet interval of both directions, in milliseconds ({})", usual));
}

void add_number_options(CLI::App& app, ConnectionArguments& arguments) {
    const auto size = [&](const std::string& name, std::optional<std::size_t>& target, const std::string& which) {
        app.add_option(name, target, "Octets of the application " + which + ", without header and sequence count")
            ->type_name("OCTETS")
            ->check(CLI::Range(std::size_t{0}, max_io_octets));
    };
    app.add_option("--o2t", arguments.o_to_t_point, "Connection point of the outputs, instead of --connection")
        ->type_name("POINT");
    size("--o2t-size", arguments.o_to_t_octets, "in the outputs");
    app.add_option("--t2o", arguments.t_to_o_point,
                   "Connection point of the inputs; with input-only and listen-only 100, 105 or 113")
        ->type_name("POINT");
    size("--t2o-size", arguments.t_to_o_octets, "in the inputs");
    add_text(app, "--config-instance", arguments.config_instance, "N",
             "Instance of the configuration assembly, or none (1 for a XENAX, otherwise none)");
    add_text(app, "--config", arguments.config, "HEX", "Configuration data, pairs of hex digits");
    add_text(app, "--o2t-format", arguments.o_to_t_format, "FORMAT", "header32, modeless, heartbeat or zero-length");
    add_text(app, "--t2o-format", arguments.t_to_o_format, "FORMAT", "The same for the inputs");
}

CLI::App& IoCommandLine::add_verb(CLI::App& app, const std::string& name, const std::string& description) {
    auto& verb = *app.add_subcommand(name, description);
    decorate_(verb);
    verb.add_option("HOST", arguments_.host, "Name or address of the device, with :PORT if it is not 44818")
        ->required()
        ->type_name("");
    verb.add_option("CONNECTION", positional_, "The same as --connection")->type_name("");
    verb.add_option("--eds", arguments_.connection.eds,
                    "The connections of this data sheet: --connection takes a name, the beginning of one, or a number")
        ->type_name("FILE");
    add_connection_option(verb, arguments_.connection);
    add_number_options(verb, arguments_.connection);
    add_interval_option(verb, arguments_.connection, "10");
    add_manners(verb);
    return verb;
}

void IoCommandLine::take_positional() {
    if (positional_.empty()) return;
    auto& connection = arguments_.connection.connection;
    if (!connection.empty()) throw CLI::ValidationError("CONNECTION", "it is given as --connection already");
    connection = positional_;
}

void IoCommandLine::add_manners(CLI::App& verb) {
    auto& to = arguments_.connection;
    add_text(verb, "--rpi-o2t", to.o_to_t_rpi, "MS", "Another interval for the outputs");
    add_text(verb, "--rpi-t2o", to.t_to_o_rpi, "MS", "Another interval for the inputs");
    verb.add_flag("--multicast", to.multicast, "The inputs are sent to a group of receivers");
    verb.add_option("--multiplier", to.multiplier, "Intervals without a datagram that end it: 4, 8, ... 512 (16)")
        ->type_name("N");
    add_text(verb, "--trigger", to.trigger, "TRIGGER", "When it sends: cyclic, cos or application (cyclic)");
    add_text(verb, "--inhibit", to.inhibit, "MS", "Shortest time between two datagrams of cos and application");
    add_text(verb, "--priority", to.priority, "PRIORITY", "low, high, scheduled or urgent (scheduled)");
    verb.add_flag("--variable", to.variable, "Sizes may vary from datagram to datagram");
    verb.add_flag("--large", to.large, "A Large_Forward_Open also where a small one would do");
    add_text(verb, "--key", to.key, "KEY",
             "Electronic key: none, VENDOR/TYPE/PRODUCT/MAJOR.MINOR, auto: as the device says, eds: as the file says "
             "(none)");
}

void IoCommandLine::add_files(CLI::App& verb) {
    auto& to = arguments_.connection;
    verb.add_option("--set", to.changes, "An output: NAME=VALUE, or @OFFSET:TYPE=VALUE; may be given again")
        ->type_name("OUTPUT")
        ->allow_extra_args(false);
    verb.add_flag("--idle", to.idle, "Sends idle instead of run");
    verb.add_option_function<std::string>(
            "--duration",
            [this](const std::string& text) {
                const auto time = parse_duration(text);
                if (!time) throw CLI::ValidationError("--duration", time.error().text);
                arguments_.duration = *time;
            },
            "How long; without it until Ctrl-C")
        ->type_name("SECONDS");
    add_text(verb, "--csv", arguments_.csv, "FILE", "Writes a line for each datagram of inputs; - is standard output");
    add_text(verb, "--pcapng", arguments_.pcapng, "FILE", "Writes all datagrams, as Wireshark reads them");
    verb.add_flag("--no-reopen", arguments_.no_reopen, "A lost connection stays closed");
}

void IoCommandLine::add_scheduling(CLI::App& verb) {
    auto& to = arguments_.scheduling;
    verb.add_option("--realtime", to.realtime_priority, "Runs with this real-time priority (SCHED_FIFO)")
        ->type_name("PRIORITY")
        ->check(CLI::Range(1, highest_priority));
    verb.add_flag("--lock-memory", to.lock_memory, "Keeps its memory from being paged out");
    verb.add_option("--cpu", to.cpu, "Runs on this CPU only")->type_name("N")->check(CLI::Range(0, most_cpus - 1));
}

void IoCommandLine::add_to(CLI::App& app, const std::function<void(CLI::App&)>& decorate,
                           const std::function<void(Action)>& choose) {
    decorate_ = decorate;
    auto& io_verb = add_verb(app, "io", "Run an I/O connection: outputs, a table of the inputs, interval statistics");
    add_files(io_verb);
    add_scheduling(io_verb);
    io_verb.footer(io_examples);
    io_verb.callback([this, choose] {
        take_positional();
        choose([this](const Console& console, const Settings& settings) { return io(console, settings, arguments_); });
    });
    auto& open_verb = add_verb(app, "open", "Open an I/O connection, and say that it works or why it does not");
    open_verb.footer(open_examples);
    open_verb.callback([this, choose] {
        take_positional();
        choose(
            [this](const Console& console, const Settings& settings) { return open(console, settings, arguments_); });
    });
}

}  // namespace servobus::scanner::cli
