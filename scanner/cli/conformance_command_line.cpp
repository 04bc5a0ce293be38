#include "scanner/cli/conformance_command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "scanner/cli/io_command_line.hpp"
#include "scanner/conformance/case.hpp"

namespace servobus::scanner::cli {
namespace {

constexpr auto examples =
    "Examples:\n"
    "  servobus-scanner conformance 192.168.1.20 --eds valve.eds\n"
    "  servobus-scanner conformance 192.168.1.20 --eds valve.eds --junit conformance.xml\n"
    "  servobus-scanner conformance 192.168.2.100 --allow-writes\n"
    "  servobus-scanner conformance 192.168.1.20 --group sessions --case MAL-40 --verbose\n"
    "  servobus-scanner conformance --list\n"
    "\nWithout --allow-writes nothing is written, nothing is reset and no output is owned. It opens, closes and "
    "floods,\n"
    "and sends what is malformed: the device should do nothing else meanwhile. Exit code 4: a case has failed.\n";

std::string group_names() {
    std::string names;
    for (const auto& row : conformance::groups) names += fmt::format("{}{}", names.empty() ? "" : ", ", row.name);
    return names;
}

}  // namespace

void ConformanceCommandLine::add_to(CLI::App& app, const std::function<void(CLI::App&)>& decorate,
                                    const std::function<void(Action)>& choose) {
    auto& verb = *app.add_subcommand("conformance", "Put a device to the test: does it keep the rules of EtherNet/IP?");
    decorate(verb);
    auto& to = arguments_;
    verb.add_option("HOST", to.host, "Name or address of the device, with :PORT if it is not 44818")->type_name("");
    verb.add_option("--eds", to.connection.eds, "The I/O connections of this data sheet")->type_name("FILE");
    verb.add_option("--connection", to.connection.connection,
                    "Only this connection: of the data sheet by name or number, of a XENAX by its key")
        ->type_name("NAME");
    add_number_options(verb, to.connection);
    verb.add_flag("--multicast", to.connection.multicast, "With --o2t: the inputs are sent to a group");
    verb.add_flag("--allow-writes", to.writes, "Also cases that write, and own the outputs, which stay idle");
    verb.add_option("--group", to.groups, "Only these cases; may be given again: " + group_names())
        ->type_name("GROUP")
        ->allow_extra_args(false);
    verb.add_option("--case", to.cases, "Only this case; may be given again")->type_name("ID")->allow_extra_args(false);
    verb.add_flag("--list", to.list, "Print the cases, and ask no device");
    verb.add_flag("--verbose", to.verbose, "Print what was sent and what came of cases that pass, too");
    verb.add_option("--junit", to.junit, "Write the outcome as JUnit XML; - is standard output")->type_name("FILE");
    verb.add_option("--json", to.json, "Write the outcome as JSON; - is standard output")->type_name("FILE");
    verb.footer(examples);
    verb.callback([this, choose] {
        choose([this](const Console& console, const Settings& settings) {
            return conformance(console, settings, arguments_);
        });
    });
}

}  // namespace servobus::scanner::cli
