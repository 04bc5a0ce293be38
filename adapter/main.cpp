// servobus-adapter: a virtual XENAX on the network.
#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "adapter/access_file.hpp"
#include "adapter/adapter.hpp"
#include "adapter/address_manager.hpp"
#include "adapter/axis_file.hpp"
#include "adapter/config.hpp"
#include "adapter/control.hpp"
#include "adapter/file_settings.hpp"
#include "adapter/flash_file.hpp"
#include "adapter/fleet.hpp"
#include "adapter/ptp_client.hpp"
#include "adapter/ready_line.hpp"
#include "adapter/ring_node.hpp"
#include "adapter/scenario.hpp"
#include "adapter/state_storing.hpp"
#include "adapter/status_line.hpp"
#include "adapter/terminal_sink.hpp"
#include "adapter/time_sync.hpp"
#include "adapter/version.hpp"
#include "drive/xenax.hpp"
#include "enip/asio/cpu_load.hpp"
#include "enip/asio/interface_reader.hpp"
#include "enip/asio/scheduling.hpp"
#include "enip/asio/target_server.hpp"

namespace {

using servobus::adapter::AccessFile;
using servobus::adapter::Adapter;
using servobus::adapter::AddressChange;
using servobus::adapter::AddressManager;
using servobus::adapter::AllowList;
using servobus::adapter::Config;
using servobus::adapter::Control;
using servobus::adapter::DeviceFile;
using servobus::adapter::DeviceFiles;
using servobus::adapter::FileError;
using servobus::adapter::Fleet;
using servobus::adapter::LineSink;
using servobus::adapter::LogLevel;
using servobus::adapter::LogLine;
using servobus::adapter::PtpClient;
using servobus::adapter::RingNode;
using servobus::adapter::StateDirectory;
using servobus::adapter::StateStoring;
using servobus::adapter::TimeSync;
using servobus::adapter::Timetable;
using servobus::enip::asio::CpuLoad;
using servobus::enip::asio::Listening;
using servobus::enip::asio::TargetServer;
namespace drive = servobus::drive;

constexpr int done = 0;
constexpr int wrong_usage = 2;
constexpr int cannot_listen = 3;

// What the command line says; empty where it says nothing and file or default decide.
struct Arguments {
    std::string config_file;
    std::optional<std::string> variant;
    std::vector<std::string> binds;
    std::optional<std::string> manage_interface;
    std::vector<std::string> ring_ports;
    bool ring_announce = false;
    bool time_sync = false;
    std::string ptp_socket = "/var/run/ptp4l";
    std::uint8_t ptp_domain = 0;
    std::optional<std::uint16_t> port;
    std::optional<std::uint16_t> io_port;
    std::optional<std::size_t> count;
    std::optional<std::string> log_level;
    std::optional<std::string> axis;
    std::optional<std::uint64_t> seed;
    std::optional<std::string> scenario;
    std::optional<std::string> state;
    std::optional<std::uint32_t> serial_number;
    std::optional<std::string> flash;
    std::vector<std::string> controls;
    servobus::enip::asio::Scheduling scheduling;
    bool list_axes = false;
    bool ready_json = false;
    bool status_line = false;
    std::vector<std::string> allowed;
    bool read_only = false;
    bool harden = false;
    std::optional<std::string> access_log;
};

int fail(int code, const std::string& reason) {
    fmt::print(stderr, "servobus-adapter: {}\n", reason);
    return code;
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

// Where the reader cannot look it up, the error does it for him.
std::string check_axis(const std::string& word) {
    Config scratch;
    return choose_axis(word, scratch);
}

void add_state_options(CLI::App& app, Arguments& arguments) {
    app.add_option("--state", arguments.state,
                   "Directory that keeps what is written to the drives over the end of the program");
    app.add_option("--serial", arguments.serial_number,
                   "Serial number of the drive, decimal or 0x hex; further drives have the ones that follow")
        ->type_name("N")
        ->check(CLI::Range(std::uint32_t{1}, std::uint32_t{UINT32_MAX}));
}

void add_machine_options(CLI::App& app, Arguments& arguments) {
    app.add_option("--axis", arguments.axis,
                   fmt::format("What the drive moves: a key of --list-axes, or FILE.json ({} unless given)",
                               servobus::adapter::default_axis))
        ->check(CLI::Validator(check_axis, "KEY|FILE.json"));
    app.add_flag("--list-axes", arguments.list_axes, "Print the axes that ship with the program, and stop");
    app.add_option("--seed", arguments.seed, "Chooses the noise of what the drive measures (1 unless given)")
        ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{INT64_MAX}));
    app.add_option("--flash", arguments.flash, "Firmware image that is in the flash when the power comes on")
        ->type_name("FILE");
    app.add_option("--scenario", arguments.scenario, "JSON file that says what happens to the drive, and when");
    app.add_option(
           "--control", arguments.controls,
           "Lets things happen while it runs, one JSON object to a line: - for standard input, or the path of a "
           "socket to listen at; may be given again")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_flag("--ready-json", arguments.ready_json,
                 "Say in one line of JSON that it listens, and where: for programs that start this one");
    app.add_flag("--status-line", arguments.status_line,
                 "Show lights, owner, connections and state in one line below the log, if stderr is a terminal");
}

std::string check_network(const std::string& word) {
    const auto network = servobus::adapter::AllowList::parse(word);
    const auto* reason = std::get_if<std::string>(&network);
    return reason != nullptr ? *reason : std::string();
}

void add_protection_options(CLI::App& app, Arguments& arguments) {
    app.add_option("--allow", arguments.allowed,
                   "IPv4 network, such as 192.168.2.0/24, that may speak to the drives; may be given again. Without it "
                   "everybody may, with it nobody else, loopback neither")
        ->expected(1, static_cast<int>(servobus::adapter::max_allowed_networks))
        ->type_name("CIDR")
        ->check(check_network);
    app.add_flag("--read-only", arguments.read_only,
                 "Refuse everything that changes the drive, and connections that carry data to it");
    app.add_flag("--harden", arguments.harden,
                 "Refuse resets, network settings, and parameters that an I/O connection owns");
    app.add_option("--access-log", arguments.access_log,
                   "File that gets a line of JSON for each access that changes something or is refused")
        ->type_name("FILE");
}

void add_scheduling_options(CLI::App& app, servobus::enip::asio::Scheduling& scheduling) {
    app.add_option(
           "--realtime", scheduling.realtime_priority,
           "Runs with this real-time priority (SCHED_FIFO, 1 to 99), for even packet intervals on a busy machine")
        ->type_name("PRIORITY")
        ->check(CLI::Range(1, 99));
    app.add_flag("--lock-memory", scheduling.lock_memory, "Keeps all of its memory in RAM");
    app.add_option("--cpu", scheduling.cpu, "The only CPU that it runs on")->type_name("N")->check(CLI::Range(0, 1023));
}

void add_time_options(CLI::App& app, Arguments& arguments) {
    auto* time_sync = app.add_flag("--time-sync", arguments.time_sync,
                                   "The drives have a Time Sync object, which tells what ptp4l on this machine knows");
    app.add_option("--ptp-socket", arguments.ptp_socket, "Socket of ptp4l for its management")
        ->capture_default_str()
        ->type_name("PATH")
        ->needs(time_sync);
    app.add_option("--ptp-domain", arguments.ptp_domain, "Domain of ptp4l")
        ->capture_default_str()
        ->check(CLI::Range(0, 255))
        ->needs(time_sync);
}

// Nullopt: go on. Otherwise the exit code: help was asked for, or the usage is wrong.
std::optional<int> parse(int argc, char** argv, Arguments& arguments) {
    CLI::App app("A virtual Jenny Science XENAX Xvi servo drive on EtherNet/IP.", "servobus-adapter");
    std::vector<std::string> variants;
    for (const auto& model : drive::xenax_models()) variants.emplace_back(model.key);
    app.add_option("--variant", arguments.variant, "Which XENAX Xvi (75v8s unless given)")
        ->check(CLI::IsMember(variants));
    app.add_option("--bind", arguments.binds,
                   "IPv4 address to listen at (127.0.0.1 unless given); once for each drive, or the first of --count")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--manage-interface", arguments.manage_interface,
                   "The drive comes to its address by itself, by DHCP unless told otherwise, and sets it on this "
                   "interface; takes CAP_NET_RAW and CAP_NET_ADMIN")
        ->type_name("IFACE");
    auto* ring =
        app.add_option("--ring-ports", arguments.ring_ports,
                       "The two interfaces by which the drive is a node of a Device Level Ring; takes CAP_NET_RAW")
            ->type_name("IFACE1,IFACE2")
            ->delimiter(',')
            ->expected(2);
    app.add_flag("--ring-announce", arguments.ring_announce,
                 "In the ring it looks at announcements, once a second, and not at beacons")
        ->needs(ring);
    app.add_option("--count", arguments.count,
                   "How many drives, each at an address of its own, with a serial number of its own (1 unless given)")
        ->check(CLI::Range(std::size_t{1}, servobus::adapter::max_drives));
    app.add_option("--port", arguments.port, "TCP and UDP port (44818 unless given; 0 takes a free one)")
        ->check(CLI::Range(0, 65535));
    app.add_option("--io-port", arguments.io_port,
                   "UDP port of I/O data (2222 unless given, or another one when that is taken)")
        ->check(CLI::Range(0, 65535));
    app.add_option("--config", arguments.config_file, "JSON file with these settings and more; see docs/adapter.md");
    app.add_option("--log-level", arguments.log_level, "How much to say on stderr (info unless given)")
        ->check(CLI::IsMember({"trace", "debug", "info", "warning", "error"}));
    add_state_options(app, arguments);
    add_machine_options(app, arguments);
    add_time_options(app, arguments);
    add_protection_options(app, arguments);
    add_scheduling_options(app, arguments.scheduling);
    app.set_version_flag("--version", std::string("servobus-adapter ") + servobus::adapter::version);
    app.footer(
        "Examples:\n"
        "  servobus-adapter                          a 75V8S on this machine alone\n"
        "  servobus-adapter --variant 48v8 --port 0  a 48V8 at a free port\n"
        "  servobus-adapter --bind 192.168.1.20      on the network; read SECURITY.md first\n"
        "  servobus-adapter --bind 192.168.1.20 --allow 192.168.1.7 --harden\n"
        "                                            for one controller alone\n"
        "  servobus-adapter --manage-interface eth1  with an address of its own, from a DHCP server\n"
        "  servobus-adapter --bind 127.0.1.1 --count 8\n"
        "                                            eight of them, at 127.0.1.1 to 127.0.1.8\n"
        "  servobus-adapter --realtime 20 --lock-memory --cpu 1\n"
        "                                            with even packet intervals beside other work\n"
        "  servobus-adapter --state press-7          what is set stays, over the end of the program\n"
        "  servobus-adapter --config drive.json      with identity, start values and limits of its own\n"
        "  servobus-adapter --axis linax-lxc-230f10 --control -\n"
        "                                            with that axis, and events from standard input\n"
        "Exit codes: 0 stopped by SIGINT or SIGTERM, 2 wrong usage or configuration, 3 cannot listen.");
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& wanted) {
        app.exit(wanted);
        return done;
    } catch (const CLI::ParseError& error) {
        return fail(wrong_usage, first_line(error.what()) + " (--help shows the options)");
    }
    if (std::ranges::count(arguments.controls, "-") > 1) {
        return fail(wrong_usage,
                    "--control - can be given once: there is one standard input (--help shows the options)");
    }
    if (arguments.status_line && std::ranges::count(arguments.controls, "-") > 0) {
        return fail(wrong_usage,
                    "--status-line and --control - want the same terminal; give --control a path (--help shows the "
                    "options)");
    }
    return std::nullopt;
}

// The command line wins over the file.
void override_with(const Arguments& arguments, Config& config) {
    if (arguments.variant) config.variant = *arguments.variant;
    if (!arguments.binds.empty()) config.bind = arguments.binds.front();
    if (arguments.manage_interface) config.manage_interface = *arguments.manage_interface;
    if (arguments.io_port) config.io_port = *arguments.io_port;
    if (arguments.binds.size() > 1) config.count = arguments.binds.size();
    if (arguments.count) config.count = *arguments.count;
    if (arguments.port) config.port = *arguments.port;
    if (arguments.log_level) config.log_level = *servobus::adapter::log_level(*arguments.log_level);
    if (arguments.axis) static_cast<void>(choose_axis(*arguments.axis, config));  // checked by parse()
    if (arguments.seed) config.seed = *arguments.seed;
    if (arguments.scenario) config.scenario = *arguments.scenario;
    if (arguments.state) config.state = *arguments.state;
    if (arguments.serial_number) config.serial_number = *arguments.serial_number;
    if (arguments.flash) config.flash = *arguments.flash;
    if (!arguments.allowed.empty()) {
        config.allowed = {};
        for (const auto& word : arguments.allowed) {  // checked by parse()
            config.allowed.add(std::get<AllowList::Network>(AllowList::parse(word)));
        }
    }
    config.protection.read_only |= arguments.read_only;
    config.protection.harden |= arguments.harden;
    if (arguments.access_log) config.access_log = *arguments.access_log;
}

spdlog::level::level_enum to_spdlog(LogLevel level) {
    switch (level) {
        case LogLevel::trace:
            return spdlog::level::trace;
        case LogLevel::debug:
            return spdlog::level::debug;
        case LogLevel::info:
            return spdlog::level::info;
        case LogLevel::warning:
            return spdlog::level::warn;
        case LogLevel::error:
            return spdlog::level::err;
    }
    return spdlog::level::info;
}

std::shared_ptr<spdlog::logger> make_logger(LogLevel level, spdlog::sink_ptr sink) {
    auto logger = std::make_shared<spdlog::logger>("adapter", std::move(sink));
    logger->set_pattern("%H:%M:%S.%e %l: %v");
    logger->set_level(to_spdlog(level));
    logger->flush_on(spdlog::level::trace);
    return logger;
}

// Every connection is a descriptor; a shell's usual 1,024 may be fewer than the limits ask for.
void make_room_for_descriptors(const servobus::adapter::Limits& limits, std::size_t drives, spdlog::logger& logger) {
    constexpr rlim_t own = 64;
    // All the connections that one drive serves, a few for each of many, and everybody's own sockets.
    constexpr rlim_t of_each = 16;
    const rlim_t wanted = limits.tcp_connections + limits.refusals + own + of_each * drives;
    rlimit files{};
    if (::getrlimit(RLIMIT_NOFILE, &files) != 0 || files.rlim_cur >= wanted) return;
    files.rlim_cur = std::min(wanted, files.rlim_max);
    if (::setrlimit(RLIMIT_NOFILE, &files) != 0 || files.rlim_cur < wanted) {
        logger.warn(
            "this process may open {} files, which is fewer than {} TCP connections need; raise it with ulimit -n",
            files.rlim_cur, limits.tcp_connections);
    }
}

std::uint64_t unpredictable_seed() {
    std::random_device source;
    return std::uint64_t{source()} << 32 | source();
}

// What a configuration names and other files say.
struct Files {
    DeviceFiles device;
    Timetable scenario;
    std::optional<servobus::adapter::FlashImage> flash;
    std::shared_ptr<AccessFile> access_log;  ///< null: there is none
};

// Nullopt, or the exit code.
std::optional<int> load_device_file(const std::optional<std::string>& path, std::optional<DeviceFile>& file) {
    if (!path) return std::nullopt;
    auto loaded = servobus::adapter::load_device_file(*path);
    if (const auto* error = std::get_if<FileError>(&loaded)) return fail(wrong_usage, describe(*path, *error));
    file = std::get<DeviceFile>(std::move(loaded));
    return std::nullopt;
}

// All that can be wrong is said before anything starts: nullopt, or the exit code.
std::optional<int> load_files(Config& config, Files& files) {
    const auto axis_file = config.axis_file;
    if (const auto error = load_axis(config)) return fail(wrong_usage, describe(*axis_file, *error));
    if (!config.eds) files.device = generated_files(config);
    if (const auto code = load_device_file(config.eds, files.device.eds)) return code;
    if (const auto code = load_device_file(config.icon, files.device.icon)) return code;
    if (config.flash) {
        auto image = servobus::adapter::load_flash(*config.flash);
        if (const auto* reason = std::get_if<std::string>(&image)) return fail(wrong_usage, *reason);
        files.flash = std::get<servobus::adapter::FlashImage>(std::move(image));
    }
    if (config.access_log) {
        auto file = AccessFile::open(*config.access_log);
        if (const auto* reason = std::get_if<std::string>(&file)) return fail(wrong_usage, *reason);
        files.access_log = std::make_shared<AccessFile>(std::get<AccessFile>(std::move(file)));
    }
    if (!config.scenario) return std::nullopt;
    auto scenario = servobus::adapter::load_scenario(*config.scenario);
    if (const auto* error = std::get_if<FileError>(&scenario)) {
        return fail(wrong_usage, describe(*config.scenario, *error));
    }
    files.scenario = std::get<Timetable>(std::move(scenario));
    return std::nullopt;
}

void announce(const drive::Identity& identity, const Listening& listening, const Config& config) {
    const bool usual = listening.io_port == servobus::enip::io_port;
    const auto io = usual ? std::string() : fmt::format("; I/O data at UDP {}", listening.io_port);
    const auto where = config.manage_interface
                           ? fmt::format("has {} for itself and no address yet; port {}", *config.manage_interface,
                                         listening.local.port)
                           : fmt::format("listens at {}", servobus::enip::to_string(listening.local));
    fmt::print(
        "{} (vendor {}, device type {}, product code 0x{:04X}, revision {}.{}, serial number 0x{:08X}) "
        "{}, TCP and UDP{}\n",
        identity.product_name, identity.vendor, identity.device_type, identity.product_code, identity.major_revision,
        identity.minor_revision, identity.serial_number, where, io);
}

void announce_in_json(Fleet& fleet, const Config& config, const std::vector<std::string>& addresses,
                      const std::vector<Listening>& places, const std::vector<std::string>& controls) {
    std::vector<servobus::adapter::ReadyDrive> drives;
    for (std::size_t i = 0; i < fleet.size(); ++i) {
        const auto address = config.manage_interface ? std::nullopt : std::optional(addresses[i]);
        drives.push_back(
            {address, places[i].local.port, places[i].io_port, fleet[i].device.identity(), config.manage_interface});
    }
    fmt::print("{}\n", servobus::adapter::ready_line(drives, ::getpid(), controls));
}

// Nullopt, or the exit code.
std::optional<int> serve_lines(TargetServer& server, const std::vector<std::string>& controls, Control& control) {
    using servobus::adapter::control_error;
    const servobus::enip::asio::LineService service{
        .answer = [&](std::string_view line, servobus::enip::Time now) { return control.answer(line, now); },
        .too_long =
            control_error(fmt::format("the line is longer than {} octets", servobus::enip::asio::max_line_octets)),
        .too_many = control_error(fmt::format("there are {} clients already", servobus::enip::asio::max_line_clients)),
    };
    for (const auto& where : controls) {
        if (const auto error = server.serve_lines(service, where)) return fail(cannot_listen, error->reason);
    }
    return std::nullopt;
}

// What the drive tells of its Ethernet port is what the interface is at which it listens.
void read_port(const std::string& interface, servobus::adapter::NetworkState& network) {
    if (interface.empty()) return;
    auto reader = std::make_shared<servobus::enip::asio::InterfaceReader>(interface);
    const auto& facts = reader->read();
    if (facts.ethernet) network.mac = facts.mac;
    network.ports[0] = [reader = std::move(reader)] { return reader->read(); };
}

void tell_of_host(Adapter& adapter) {
    adapter.measure_cpu([load = std::make_shared<CpuLoad>()] { return load->read(); });
}

// Nullopt, or the exit code.
std::optional<int> listen(TargetServer& server, Fleet& fleet, const Config& config,
                          const std::vector<std::string>& addresses, std::vector<Listening>& places) {
    for (std::size_t i = 0; i < fleet.size(); ++i) {
        auto& adapter = fleet[i].adapter;
        const auto listening =
            server.listen(adapter, {.address = addresses[i], .port = config.port, .io_port = config.io_port});
        if (!listening) return fail(cannot_listen, listening.error().reason);
        auto& network = adapter.network();
        network.state.host = servobus::adapter::InterfaceConfiguration{.address = listening->local.address,
                                                                       .mask = listening->subnet_mask};
        network.state.io_port = listening->io_port;
        read_port(listening->interface, network.state);
        servobus::adapter::apply_address_settings(network);
        places.push_back(*listening);
    }
    return std::nullopt;
}

// The log takes what its level lets through; the file takes all, connections too, which the log tells in its own words.
LineSink access_sink(const std::shared_ptr<spdlog::logger>& logger, LogLevel lowest,
                     const std::shared_ptr<AccessFile>& file) {
    const auto take = [logger, file](const LogLine& line) {
        if (logger->should_log(to_spdlog(line.level))) {
            logger->log(to_spdlog(line.level), servobus::adapter::to_text(line));
        }
        if (!file) return;
        if (const auto reason = file->write(line, std::chrono::system_clock::now())) logger->error(*reason);
    };
    return {file ? LogLevel::trace : lowest, take};
}

// Twice as often as a light changes, so that it is seen to blink.
void show_status(TargetServer& server, Fleet& fleet, const std::shared_ptr<servobus::adapter::TerminalSink>& terminal) {
    constexpr std::chrono::milliseconds interval{250};
    std::vector<const servobus::adapter::Adapter*> drives;
    for (std::size_t i = 0; i < fleet.size(); ++i) drives.push_back(&fleet[i].adapter);
    server.every(interval, [drives, terminal](servobus::enip::Time now) {
        terminal->show(servobus::adapter::status_line(drives, now, terminal->width()));
    });
}

// The drive comes to its address by itself. Nullopt, or the exit code.
std::optional<int> manage(TargetServer& server, Adapter& adapter, AddressManager& manager, const Config& config,
                          spdlog::logger& logger) {
    auto& state = adapter.network().state;
    const auto& interface = *config.manage_interface;
    const auto mac =
        server.manage(adapter, manager,
                      {.interface = interface,
                       .port = config.port,
                       .io_port = config.io_port,
                       .listens = [&](const Listening& listening) {
                           state.io_port = listening.io_port;
                           logger.info("listens at {}, TCP and UDP", servobus::enip::to_string(listening.local));
                       }});
    if (!mac) return fail(cannot_listen, mac.error().reason);
    state.mac = *mac;
    state.address_service = servobus::adapter::AddressService::dhcp_and_bootp;
    read_port(interface, state);
    manager.on_loss([&] { adapter.give_address_up(); });
    adapter.on_address_change(
        [&](AddressChange change) { change == AddressChange::set ? manager.change_address() : manager.restart(); });
    manager.restart();
    return std::nullopt;
}

// Nullopt, or the exit code.
std::optional<int> join_ring(TargetServer& server, RingNode& node, const Arguments& arguments) {
    if (arguments.ring_ports.empty()) return std::nullopt;
    const auto error = server.join_ring(node, arguments.ring_ports);
    return error ? std::optional(fail(cannot_listen, error->reason)) : std::nullopt;
}

// Nullopt, or the exit code.
std::optional<int> follow_ptp(TargetServer& server, PtpClient& client, const Arguments& arguments) {
    if (!arguments.time_sync) return std::nullopt;
    const auto error = server.converse(client, arguments.ptp_socket);
    return error ? std::optional(fail(wrong_usage, error->reason)) : std::nullopt;
}

int serve(const Config& config, const Files& files, const std::vector<std::string>& addresses,
          const Arguments& arguments, std::optional<StateDirectory> state) {
    const auto& controls = arguments.controls;
    const auto terminal = arguments.status_line && ::isatty(STDERR_FILENO) != 0
                              ? std::make_shared<servobus::adapter::TerminalSink>(stderr)
                              : nullptr;
    const auto logger = make_logger(
        config.log_level, terminal ? spdlog::sink_ptr(terminal) : std::make_shared<spdlog::sinks::stderr_sink_st>());
    make_room_for_descriptors(config.limits, addresses.size(), *logger);
    const auto log = [&](LogLevel level, std::string_view line) { logger->log(to_spdlog(level), line); };
    TimeSync time_sync;  // of this machine, and so of all its drives
    PtpClient ptp(time_sync, arguments.ptp_domain, servobus::adapter::Log(log));
    Fleet fleet(config, addresses, unpredictable_seed(), log, files.device, files.scenario);
    if (files.flash) {
        if (const auto wrong = fleet.install(*files.flash)) {
            return fail(wrong_usage, fmt::format("{}: {}", *config.flash, *wrong));
        }
    }
    fleet.on_access(access_sink(logger, config.log_level, files.access_log));
    Control control(fleet[0].adapter, axis_of(config), addresses[0]);
    for (std::size_t i = 1; i < fleet.size(); ++i) control.add(fleet[i].adapter, addresses[i]);
    for (std::size_t i = 0; i < fleet.size(); ++i) tell_of_host(fleet[i].adapter);
    for (std::size_t i = 0; arguments.time_sync && i < fleet.size(); ++i) fleet[i].adapter.follow_time(time_sync);
    auto& network = fleet[0].adapter.network();
    std::optional<AddressManager> manager;
    RingNode node(network.state, servobus::adapter::Log(log));
    network.state.ring.announce_based = arguments.ring_announce;
    TargetServer server([&](const std::string& line) { logger->warn(line); });
    servobus::adapter::PosixFileSystem file_system;
    std::optional<StateStoring> storing;
    if (state) {
        const auto background = [&server](servobus::adapter::Adapter& adapter, auto job, auto then) {
            server.in_background(adapter, std::move(job), std::move(then));
        };
        storing.emplace(file_system, *std::move(state), background, log);
        for (std::size_t i = 0; i < fleet.size(); ++i) storing->keep(fleet[i].adapter);
    }
    control.on_stop([&] { server.stop(); });
    std::vector<Listening> places;
    if (config.manage_interface) {
        manager.emplace(network, unpredictable_seed(), servobus::adapter::Log(log));
        if (const auto code = manage(server, fleet[0].adapter, *manager, config, *logger)) return *code;
        places.push_back({.local = {0, config.port}, .io_port = config.io_port.value_or(servobus::enip::io_port)});
    } else if (const auto code = listen(server, fleet, config, addresses, places)) {
        return *code;
    }
    if (const auto code = join_ring(server, node, arguments)) return *code;
    if (const auto code = follow_ptp(server, ptp, arguments)) return *code;
    if (const auto code = serve_lines(server, controls, control)) return *code;
    server.catch_signals();  // before anybody is told that it listens
    if (arguments.ready_json) {
        announce_in_json(fleet, config, addresses, places, controls);
    } else {
        for (std::size_t i = 0; i < fleet.size(); ++i) announce(fleet[i].device.identity(), places[i], config);
    }
    std::fflush(stdout);
    if (fleet[0].device.has_machine()) logger->info("the axis is a {}", axis_of(config).name);
    if (terminal) show_status(server, fleet, terminal);
    server.run([&] {
        if (terminal) terminal->show({});
        logger->info("stopping: {} sessions are closed", fleet.sessions());
        fleet.shut_down();
    });
    if (storing) storing->finish();
    return done;
}

int list_axes() {
    for (const auto& axis : servobus::adapter::shipped_axes()) fmt::print("{:<24} {}\n", axis.key, axis.name);
    return done;
}

// The directory, if there is one; or why it cannot be used.
std::variant<std::optional<StateDirectory>, std::string> open_state(const Config& config) {
    if (!config.state) return std::nullopt;
    // A file that grows past a limit is an error like any other, and not the end of the program.
    static_cast<void>(std::signal(SIGXFSZ, SIG_IGN));
    auto directory = StateDirectory::open(*config.state);
    if (auto* reason = std::get_if<std::string>(&directory)) return std::move(*reason);
    return std::optional(std::get<StateDirectory>(std::move(directory)));
}

// A descriptor that is missing here would be the next socket's, and be read or written as if it were a stream.
void keep_standard_descriptors() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        if (::fcntl(stream, F_GETFD) < 0) static_cast<void>(::open("/dev/null", O_RDWR));
    }
}

int run(int argc, char** argv) {
    Arguments arguments;
    if (const auto code = parse(argc, argv, arguments)) return *code;
    if (arguments.list_axes) return list_axes();
    Config config;
    if (!arguments.config_file.empty()) {
        auto loaded = servobus::adapter::load_config(arguments.config_file);
        if (const auto* error = std::get_if<FileError>(&loaded)) {
            return fail(wrong_usage, describe(arguments.config_file, *error));
        }
        config = std::get<Config>(std::move(loaded));
    }
    override_with(arguments, config);
    Files files;
    if (const auto code = load_files(config, files)) return *code;
    if (config.manage_interface && (config.count > 1 || !arguments.binds.empty())) {
        return fail(wrong_usage,
                    "--manage-interface is for one drive, which has an address of its own; leave out --bind "
                    "and --count");
    }
    const auto binds =
        arguments.binds.size() > 1 ? arguments.binds : std::vector{config.manage_interface.value_or(config.bind)};
    const auto addresses = servobus::adapter::drive_addresses(binds, config.count);
    if (const auto* reason = std::get_if<std::string>(&addresses)) return fail(wrong_usage, *reason);
    if (config.serial_number.value_or(1) > UINT32_MAX - (config.count - 1)) {
        return fail(wrong_usage, fmt::format("there are no {} serial numbers from {} on; the last one is 4294967295",
                                             config.count, *config.serial_number));
    }
    if (const auto refused = servobus::enip::asio::apply(arguments.scheduling)) return fail(wrong_usage, *refused);
    auto state = open_state(config);
    if (const auto* reason = std::get_if<std::string>(&state)) return fail(wrong_usage, *reason);
    return serve(config, files, std::get<std::vector<std::string>>(addresses), arguments,
                 std::get<std::optional<StateDirectory>>(std::move(state)));
}

}  // namespace

int main(int argc, char** argv) {
    try {
        keep_standard_descriptors();
        return run(argc, argv);
    } catch (const std::exception& error) {  // a library's; nothing here throws
        return fail(1, error.what());
    }
}
