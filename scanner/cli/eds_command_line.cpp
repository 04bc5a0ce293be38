#include "scanner/cli/eds_command_line.hpp"

#include <CLI/CLI.hpp>
#include <utility>

namespace servobus::scanner::cli {
namespace {

void add_file(CLI::App& verb, std::string& file) {
    verb.add_option("FILE", file, "An EDS file")->required()->type_name("");
}

void add_host(CLI::App& verb, std::string& host) {
    verb.add_option("HOST", host, "Name or address of the device, with :PORT if it is not 44818")
        ->required()
        ->type_name("");
}

}  // namespace

void EdsCommandLine::add_to(CLI::App& app, const std::function<void(CLI::App&)>& decorate,
                            std::function<void(Action)> choose) {
    decorate_ = decorate;
    choose_ = std::move(choose);
    auto& eds = *app.add_subcommand("eds", "Work with data sheets (EDS files): upload, lint, show, check");
    decorate_(eds);
    eds.require_subcommand(1);
    eds.footer(
        "Examples:\n"
        "  servobus-scanner eds upload 192.168.2.100\n"
        "  servobus-scanner eds lint drive.eds\n"
        "  servobus-scanner eds show drive.eds\n"
        "  servobus-scanner eds check 192.168.2.100 drive.eds\n"
        "\n'eds VERB --help' has more.");
    add_upload(eds);
    add_reading(eds);
    add_check(eds);
}

CLI::App& EdsCommandLine::add_verb(CLI::App& eds, const std::string& name, const std::string& description,
                                   const std::string& examples, Action action) {
    auto& verb = *eds.add_subcommand(name, description);
    decorate_(verb);
    verb.footer("Examples:\n" + examples);
    verb.callback([this, action = std::move(action)] { choose_(action); });
    return verb;
}

void EdsCommandLine::add_upload(CLI::App& eds) {
    auto& verb = add_verb(
        eds, "upload", "Store the data sheet that a device keeps about itself",
        "  servobus-scanner eds upload 192.168.2.100\n"
        "  servobus-scanner eds upload 192.168.2.100 -o drive.eds --force\n"
        "  servobus-scanner eds upload 192.168.2.100 --icon -o drive.ico\n",
        [this](const Console& console, const Settings& settings) { return eds_upload(console, settings, upload_); });
    add_host(verb, upload_.host);
    verb.add_option("-o,--output", upload_.output,
                    "Where to; - is standard output. Without it here, as the device calls the file")
        ->type_name("FILE");
    verb.add_flag("--icon", upload_.icon, "The icon instead of the data sheet");
    verb.add_flag("--force", upload_.force, "Overwrite a file that is there");
    verb.add_flag("--raw", upload_.raw, "Do not decompress what a device keeps compressed");
}

void EdsCommandLine::add_reading(CLI::App& eds) {
    auto& lint = add_verb(eds, "lint", "Say what is wrong with a data sheet, line by line",
                          "  servobus-scanner eds lint drive.eds\n"
                          "  servobus-scanner eds lint drive.eds --json\n",
                          [this](const Console& console, const Settings&) { return eds_lint(console, file_); });
    add_file(lint, file_);
    auto& show = add_verb(eds, "show", "Print parameters, assemblies and connections of a data sheet",
                          "  servobus-scanner eds show drive.eds\n",
                          [this](const Console& console, const Settings&) { return eds_show(console, file_); });
    add_file(show, file_);
}

void EdsCommandLine::add_check(CLI::App& eds) {
    auto& verb = add_verb(
        eds, "check", "Say whether a device is what its data sheet says",
        "  servobus-scanner eds check 192.168.2.100 drive.eds\n"
        "  servobus-scanner eds check 192.168.2.100 drive.eds --open --json\n"
        "\nIt reads, and writes nothing. With --open it owns the device for a moment, and a drive that\n"
        "moves stops.\n",
        [this](const Console& console, const Settings& settings) { return eds_check(console, settings, check_); });
    add_host(verb, check_.host);
    add_file(verb, check_.file);
    verb.add_flag("--open", check_.open, "Also open each connection, one after the other, with idle outputs");
}

}  // namespace servobus::scanner::cli
