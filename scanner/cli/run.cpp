#include "scanner/cli/run.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <memory>
#include <optional>

#include "scanner/cli/axis_command_line.hpp"
#include "scanner/cli/completion.hpp"
#include "scanner/cli/conformance_command_line.hpp"
#include "scanner/cli/eds_command_line.hpp"
#include "scanner/cli/exit_code.hpp"
#include "scanner/cli/io_command_line.hpp"
#include "scanner/cli/reset.hpp"
#include "scanner/cli/sheet_verbs.hpp"
#include "scanner/cli/verbs.hpp"

namespace servobus::scanner::cli {
namespace {

constexpr double max_timeout_s = 3600;
constexpr int max_wait_ms = 60'000;

std::string exit_code_lines() {
    std::string text = "Exit codes:\n";
    for (const auto& row : exit_codes) text += fmt::format("  {:>3}  {}\n", static_cast<int>(row.code), row.text);
    return text;
}

/// The command line as CLI11 fills it in.
class CommandLine {
public:
    CommandLine(std::ostream& out, std::ostream& err, const Surroundings& around)
        : console_{out, err, false, around.terminal, around.interruptions, around.person} {
        app_.set_version_flag("--version", "servobus-scanner " SERVOBUS_VERSION);
        app_.require_subcommand(1);
        app_.footer(exit_code_lines() + "\n'servobus-scanner VERB --help' shows examples.");
        add_common(app_);
        add_discovery();
        add_parameters();
        add_services();
        add_reset();
        add_axis();
        add_io();
        add_eds();
        add_conformance();
        add_offline();
    }

    ExitCode run(std::vector<std::string> arguments) {
        console_.json = wants_document(arguments);
        std::ranges::reverse(arguments);
        try {
            app_.parse(std::move(arguments));
        } catch (const CLI::CallForHelp& help) {
            app_.exit(help, console_.out, console_.err);
            return ExitCode::done;
        } catch (const CLI::CallForVersion& version) {
            app_.exit(version, console_.out, console_.err);
            return ExitCode::done;
        } catch (const CLI::ParseError& error) {
            return fail(console_, Mistake{fmt::format("{}; see --help", error.what())});
        }
        if (const auto mistake = read_settings()) return fail(console_, *mistake);
        return action_();
    }

private:
    /// Options before or behind the verb mean the same.
    void add_common(CLI::App& app, bool talks = true) {
        app.add_flag("--json", settings_.json, "Print one JSON document instead of text");
        if (talks) add_timeout(app);
    }
    void add_timeout(CLI::App& app) {
        app.add_option("--timeout", timeout_s_, "Longest time to wait for the device, in seconds (5)")
            ->type_name("SECONDS");
    }
    void add_path_options(CLI::App& app) {
        app.add_option("--route", route_, "Hops to the device: PORT/LINK[,PORT/LINK...]")->type_name("ROUTE");
        app.add_flag("--connected", settings_.connected, "Talk over a class 3 connection");
    }

    CLI::App& add_verb(const std::string& name, const std::string& description, const std::string& examples,
                       bool talks = true) {
        auto& verb = *app_.add_subcommand(name, description);
        add_common(verb, talks);
        verb.footer("Examples:\n" + examples);
        return verb;
    }
    /// A verb that talks to one device.
    CLI::App& add_device_verb(const std::string& name, const std::string& description, const std::string& examples) {
        auto& verb = add_verb(name, description, examples);
        add_path_options(verb);
        verb.add_option("HOST", host_, "Name or address of the device, with :PORT if it is not 44818")
            ->required()
            ->type_name("");
        return verb;
    }

    void add_discovery() {
        add_path_options(app_);
        auto& discover_verb = add_verb("discover", "Find devices: broadcast on each interface, or ask one host",
                                       "  servobus-scanner discover\n"
                                       "  servobus-scanner discover --wait 3000 --json\n"
                                       "  servobus-scanner discover --host 192.168.2.100\n");
        discover_verb.add_option("--host", discover_.host, "Ask this host only, over UDP and then TCP")
            ->type_name("HOST");
        discover_verb.add_option("--wait", wait_ms_, "How long to collect answers, in milliseconds (1000)")
            ->type_name("MS")
            ->check(CLI::Range(1, max_wait_ms));
        discover_verb.add_option("--port", discover_.port, "UDP port to broadcast to (44818)")
            ->type_name("PORT")
            ->check(CLI::Range(1, 0xFFFF));
        on(discover_verb, [this] { return run_discover(); });

        auto& identity_verb = add_device_verb("identity", "Print who a device says it is",
                                              "  servobus-scanner identity 192.168.2.100\n"
                                              "  servobus-scanner identity plc.local --route 1/0\n");
        on(identity_verb, [this] { return identity(console_, settings_, host_); });
    }

    void add_parameters() {
        auto& get_verb = add_device_verb("get", "Read parameters by name, mnemonic or address",
                                         "  servobus-scanner get 192.168.2.100 SCurve TS PositionActualValue\n"
                                         "  servobus-scanner get 192.168.2.100 drive.Controlword 0x66/1/0x24\n"
                                         "  servobus-scanner get 192.168.2.100 @0x01/1/7 --json\n"
                                         "  servobus-scanner get 192.168.1.20 --eds valve.eds 'Supply Pressure'\n");
        get_verb.add_option("WHAT", words_, "NAME, MNEMONIC, CLASS.NAME or CLASS/INSTANCE/ATTRIBUTE")
            ->required()
            ->type_name("");
        add_sheet_option(get_verb);
        on(get_verb, [this] {
            if (has_sheet()) return sheet_get(console_, settings_, sheet_, host_, words_);
            return get(console_, settings_, host_, words_);
        });

        auto& set_verb =
            add_device_verb("set", "Write parameters; the first refusal ends it",
                            "  servobus-scanner set 192.168.2.100 SCurve=35\n"
                            "  servobus-scanner set 192.168.2.100 drive.Controlword=0x0F SPROF=20000\n"
                            "  servobus-scanner set 192.168.2.100 @0xF5/1/13=UINT:60 @0x64/1/0=hex:32000000\n"
                            "  servobus-scanner set 192.168.1.20 --eds valve.eds 'Set Point' 2.5\n");
        set_verb
            .add_option("WHAT=VALUE", words_,
                        "A value in decimal, 0x hex or 0b binary; TYPE:VALUE or hex:... by address")
            ->required()
            ->type_name("");
        add_sheet_option(set_verb);
        set_verb.add_flag("--force", sheet_.force, "With --eds: send also what the file does not allow");
        on(set_verb, [this] {
            if (has_sheet()) return sheet_set(console_, settings_, sheet_, host_, words_);
            if (sheet_.force) return fail(console_, Mistake{"--force goes with --eds"}, host_);
            return set(console_, settings_, host_, words_);
        });

        auto& dump_verb = add_device_verb("dump", "Read all parameters and print them by class",
                                          "  servobus-scanner dump 192.168.2.100\n"
                                          "  servobus-scanner dump 192.168.2.100 --json\n");
        on(dump_verb, [this] { return dump(console_, settings_, host_); });

        auto& command_verb = add_device_verb("command", "Give the drive a direct command",
                                             "  servobus-scanner command 192.168.2.100 REF\n"
                                             "  servobus-scanner command 192.168.2.100 PowerQuit\n"
                                             "  servobus-scanner list --commands\n");
        command_verb.add_option("MNEMONIC", word_, "Mnemonic, name or number of the command")
            ->required()
            ->type_name("");
        on(command_verb, [this] { return command(console_, settings_, host_, word_); });
    }

    CLI::Option* add_sheet_option(CLI::App& verb) {
        return verb.add_option("--eds", sheet_.file, "The parameters of this data sheet instead of the XENAX's")
            ->type_name("FILE");
    }
    [[nodiscard]] bool has_sheet() const { return !sheet_.file.empty(); }

    void add_services() {
        auto& verb = add_device_verb("call", "Call any CIP service on any path",
                                     "  servobus-scanner call 192.168.2.100 Get_Attribute_Single 0x66/1/0x24\n"
                                     "  servobus-scanner call 192.168.2.100 0x10 0x64/1/0 32 00 00 00\n"
                                     "  servobus-scanner call 192.168.2.100 0x01 'hex:20 01 24 01' --json\n");
        verb.add_option("SERVICE", word_, "Number (0x0E) or name (Get_Attribute_Single)")->required()->type_name("");
        verb.add_option("PATH", path_, "CLASS/INSTANCE[/ATTRIBUTE], hex:EPATH, or a parameter's name")
            ->required()
            ->type_name("");
        verb.add_option("HEX", words_, "Request data: pairs of hex digits, or TYPE:VALUE")->type_name("");
        on(verb, [this] { return call(console_, settings_, host_, word_, path_, words_); });
    }

    void add_reset() {
        auto& verb = add_device_verb("reset", "Restart a device, or bring its factory defaults back",
                                     "  servobus-scanner reset 192.168.2.100\n"
                                     "  servobus-scanner reset 192.168.2.100 --factory\n"
                                     "  servobus-scanner reset 192.168.2.100 --factory-keep-network --yes --json\n");
        auto* all = verb.add_flag("--factory", reset_all_, "Everything that was set goes back (type 1)");
        verb.add_flag("--factory-keep-network", reset_but_network_, "The same but for the network settings (type 2)")
            ->excludes(all);
        verb.add_flag("--yes", reset_.yes, "Ask nobody");
        auto* no_wait = verb.add_flag("--no-wait", reset_at_once_, "Do not wait until the device answers again");
        verb.add_option("--wait", patience_s_, "How long to wait for it, in seconds (30)")
            ->type_name("SECONDS")
            ->check(CLI::Range(0.1, max_timeout_s))
            ->excludes(no_wait);
        on(verb, [this] {
            if (reset_all_) reset_.kind = ResetKind::factory;
            if (reset_but_network_) reset_.kind = ResetKind::factory_keep_network;
            reset_.wait = !reset_at_once_;
            reset_.patience = std::chrono::milliseconds(std::llround(patience_s_ * 1000));
            return reset(console_, settings_, host_, reset_);
        });
    }

    void add_axis() { axis_.add_to(app_, decoration(), chooser()); }

    void add_io() { io_.add_to(app_, decoration(), chooser()); }

    void add_eds() { eds_.add_to(app_, decoration(), chooser()); }

    void add_conformance() {
        conformance_.add_to(
            app_, [this](CLI::App& verb) { add_timeout(verb); }, chooser());
    }

    /// Whether standard output is for a program: `--json`, which behind `conformance` takes a file.
    static bool wants_document(const std::vector<std::string>& arguments) {
        const auto found = std::ranges::find(arguments, "--json");
        if (found == arguments.end()) return false;
        const bool takes_file = std::find(arguments.begin(), found, "conformance") != found;
        return !takes_file || (found + 1 != arguments.end() && *(found + 1) == "-");
    }

    /// What verbs of a command line of their own have as well.
    std::function<void(CLI::App&)> decoration() {
        return [this](CLI::App& verb) {
            add_common(verb);
            add_path_options(verb);
        };
    }
    std::function<void(AxisCommandLine::Action)> chooser() {
        return [this](AxisCommandLine::Action action) {
            action_ = [this, action = std::move(action)] { return action(console_, settings_); };
        };
    }

    void add_offline() {
        auto& list_verb = add_verb("list", "Print the parameters that exist, without a device",
                                   "  servobus-scanner list\n"
                                   "  servobus-scanner list position\n"
                                   "  servobus-scanner list 'drive.*' --json\n"
                                   "  servobus-scanner list --commands\n"
                                   "  servobus-scanner list --eds valve.eds\n",
                                   false);
        list_verb.add_option("PATTERN", list_.pattern, "Part of a name, mnemonic or address; or with * and ?")
            ->type_name("");
        list_verb.add_flag("--names", list_.names, "Only names and mnemonics, one a line");
        auto* commands = list_verb.add_flag("--commands", list_.commands, "Direct commands instead of parameters");
        add_sheet_option(list_verb)->excludes(commands);
        on(list_verb, [this] {
            if (has_sheet()) return sheet_list(console_, sheet_, list_.pattern, list_.names);
            return list(console_, list_);
        });

        auto& doctor_verb = add_verb("doctor", "Say why I/O connections in a capture did not open, or do not work",
                                     "  servobus-scanner doctor machine.pcapng\n"
                                     "  servobus-scanner doctor machine.pcap --json\n",
                                     false);
        doctor_verb.add_option("FILE", word_, "A capture of Wireshark or tcpdump: pcapng or pcap")
            ->required()
            ->type_name("");
        on(doctor_verb, [this] { return doctor(console_, word_); });

        auto& completion_verb = add_verb("completion", "Print a script that makes a shell complete commands",
                                         "  source <(servobus-scanner completion bash)\n"
                                         "  source <(servobus-scanner completion zsh)\n"
                                         "  servobus-scanner completion fish | source\n",
                                         false);
        completion_verb.add_option("SHELL", word_, "bash, zsh or fish")->required()->type_name("");
        on(completion_verb, [this] { return completion(); });
    }

    void on(CLI::App& verb, std::function<ExitCode()> action) {
        verb.callback([this, action = std::move(action)] { action_ = action; });
    }

    std::optional<Mistake> read_settings() {
        if (!std::isfinite(timeout_s_) || timeout_s_ < 0.001 || timeout_s_ > max_timeout_s) {
            return Mistake{fmt::format("--timeout is a number of seconds from 0.001 to {}", max_timeout_s)};
        }
        settings_.timeout = std::chrono::milliseconds(std::llround(timeout_s_ * 1000));
        discover_.wait = std::chrono::milliseconds(wait_ms_);
        if (!route_) return std::nullopt;
        auto route = parse_route(*route_);
        if (!route) return route.error();
        settings_.route = std::move(*route);
        return std::nullopt;
    }

    ExitCode run_discover() {
        if (route_ || settings_.connected) {
            return fail(console_,
                        Mistake{"discover has no --route and no --connected: it asks devices on this network"});
        }
        return discover(console_, settings_, discover_);
    }

    ExitCode completion() {
        const auto script = completion_script(word_, verbs_of(app_));
        if (!script)
            return fail(console_, Mistake{fmt::format("'{}' is no shell that is known: bash, zsh, fish", word_)});
        console_.out << *script;
        return ExitCode::done;
    }

    static std::vector<VerbInfo> verbs_of(const CLI::App& app) {
        std::vector<VerbInfo> verbs;
        for (const auto* verb : app.get_subcommands({})) {
            VerbInfo info{verb->get_name(), verb->get_description(), {}, verbs_of(*verb)};
            for (const auto* option : verb->get_options()) {
                if (!option->get_positional()) info.options.push_back("--" + option->get_lnames().front());
            }
            verbs.push_back(std::move(info));
        }
        return verbs;
    }

    Console console_;
    CLI::App app_{"Reads, writes and commands servo drives and other EtherNet/IP devices.", "servobus-scanner"};
    Settings settings_;
    DiscoverArguments discover_;
    ListArguments list_;
    AxisCommandLine axis_;
    IoCommandLine io_;
    EdsCommandLine eds_;
    ConformanceCommandLine conformance_;
    SheetArguments sheet_;
    ResetArguments reset_;
    bool reset_all_ = false;
    bool reset_but_network_ = false;
    bool reset_at_once_ = false;
    double patience_s_ = 30;
    double timeout_s_ = 5;
    int wait_ms_ = 1000;
    std::optional<std::string> route_;
    std::string host_;
    std::string word_;
    std::string path_;
    std::vector<std::string> words_;
    std::function<ExitCode()> action_;
};

}  // namespace

int run(std::vector<std::string> arguments, std::ostream& out, std::ostream& err, const Surroundings& around) {
    auto code = ExitCode::fault;
    try {
        code = CommandLine(out, err, around).run(std::move(arguments));
    } catch (const std::exception& error) {
        err << "servobus-scanner: unexpected: " << error.what() << '\n';
    }
    return static_cast<int>(code);
}

}  // namespace servobus::scanner::cli
