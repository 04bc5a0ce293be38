#include "scanner/cli/reset.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <thread>

#include "cip/services.hpp"
#include "cip/wire.hpp"
#include "enip/endpoint.hpp"
#include "scanner/cli/identify.hpp"
#include "scanner/cli/json_output.hpp"
#include "scanner/cli/text_output.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::uint16_t tcp_ip_class = 0xF5;
constexpr std::uint32_t control_attribute = 3;
constexpr std::uint32_t interface_attribute = 5;
constexpr std::uint32_t method_bits = 0xF;

/// A device that restarts closes its connections; one that does not is asked again after this.
constexpr auto longest_farewell = 1s;
constexpr auto between_looks = 20ms;
constexpr auto between_attempts = 250ms;
constexpr auto longest_attempt = 2s;
constexpr auto longest_search = 1s;

std::optional<std::uint32_t> first_word(Link& link, std::uint32_t attribute) {
    const auto path = cip::Path::to(tcp_ip_class, 1, attribute);
    const auto answer = link.call({cip::service::get_attribute_single, path, {}});
    if (!answer || !answer->status.ok()) return std::nullopt;
    cip::Reader reader(answer->data);
    const auto word = reader.u32();
    return reader.ok() ? std::optional(word) : std::nullopt;
}

/// Not every device has the TCP/IP Interface object, and no reset fails for that.
ResetDevice ask(Link& link, Identity identity) {
    ResetDevice device{std::move(identity), {}, {}};
    if (const auto control = first_word(link, control_attribute)) {
        device.address_method = static_cast<std::uint8_t>(*control & method_bits);
    }
    if (const auto address = first_word(link, interface_attribute)) device.address = enip::address_text(*address);
    return device;
}

bool is_same(const Identity& left, const Identity& right) {
    return left.vendor == right.vendor && left.product_code == right.product_code &&
           left.serial_number == right.serial_number;
}

std::string name_of(const Identity& identity) {
    return fmt::format("{}, product code 0x{:04X}, serial number 0x{:08X}", printable(identity.product_name),
                       identity.product_code, identity.serial_number);
}

std::string what_happens(ResetKind kind) {
    switch (kind) {
        case ResetKind::restart:
            return "It restarts: all its connections end, and a motion stops. What is stored is kept.";
        case ResetKind::factory:
            return "Everything that has been set is lost, the network settings too, and it restarts: all its "
                   "connections "
                   "end.\nA XENAX then asks a DHCP server for its address, so that it may be found at another one.";
        case ResetKind::factory_keep_network:
            return "Everything that has been set is lost but for the network settings, and it restarts: all its "
                   "connections end.";
    }
    return {};
}

bool agrees(const Console& console, const ResetDevice& device, const std::string& host, ResetKind kind) {
    const auto method = address_method_text(device.address_method);
    console.err << fmt::format("{}, at {}{}\n{}\nGo on? [y/N] ", name_of(device.identity), host,
                               method.empty() ? std::string() : fmt::format(" ({})", method), what_happens(kind))
                << std::flush;
    std::string answer;
    std::getline(*console.person, answer);
    return answer == "y" || answer == "Y" || answer == "yes";
}

Failure refusal(const cip::Status& status, ResetKind kind) {
    std::string hint;
    if (status.general == cip::GeneralStatus::device_state_conflict) {
        hint = "; an owner runs it, or another reset or a download is on its way";
    } else if (status.general == cip::GeneralStatus::invalid_parameter && kind != ResetKind::restart) {
        hint = "; it does not have this kind of reset";
    } else if (status.general == cip::GeneralStatus::store_operation_failure) {
        hint = "; the defaults could not be stored, and nothing has changed";
    }
    return {ExitCode::refused, fmt::format("the reset is refused with {}{}", cip::describe(status), hint), status};
}

/// Some devices go without a word.
bool is_gone(const error_code& error) {
    return error != make_error_code(Error::timeout) && trouble_of(error) == Trouble::connection;
}

/// Until the session is over, or for a while: a device that has not restarted yet would answer as well.
void watch_it_go(Link& link) {
    for (const auto end = Clock::now() + longest_farewell; Clock::now() < end;) {
        const auto path = cip::Path::to(cip::class_id::identity, 1, first_identity_attribute);
        const auto answer = link.call({cip::service::get_attribute_single, path, {}});
        if (!answer && is_gone(answer.error())) return;
        link.wait_until(Clock::now() + between_looks);
    }
}

/// In a session of its own: a person may take longer to answer than a device keeps one.
std::optional<Failure> send(const Settings& settings, const Host& where, const ResetArguments& arguments) {
    Link link(settings, where);
    if (auto failure = link.open()) return failure;
    const auto path = cip::Path::to(cip::class_id::identity, 1);
    const auto answer = link.call({cip::service::reset, path, {static_cast<std::uint8_t>(arguments.kind)}});
    if (!answer && !is_gone(answer.error())) return link.failure_of(answer.error());
    if (answer && !answer->status.ok()) return refusal(answer->status, arguments.kind);
    if (answer && arguments.wait) watch_it_go(link);
    return std::nullopt;
}

boost::system::result<ResetDevice, Failure> examine(const Settings& settings, const Host& where) {
    Link link(settings, where);
    if (auto failure = link.open()) return *std::move(failure);
    auto identity = ask_identity(link);
    if (!identity) return identity.error();
    return ask(link, *std::move(identity));
}

std::optional<ResetDevice> wait_for(const Settings& settings, const Host& where, Clock::time_point end) {
    auto hasty = settings;
    hasty.timeout = std::min<std::chrono::milliseconds>(settings.timeout, longest_attempt);
    do {
        if (auto device = examine(hasty, where)) return *std::move(device);
        std::this_thread::sleep_for(std::min<Clock::duration>(between_attempts, std::max(end - Clock::now(), 0ns)));
    } while (Clock::now() < end);
    return std::nullopt;
}

/// By broadcast, where the device may have another address now.
std::string found_elsewhere(const Identity& identity) {
    const auto devices = broadcast({enip::tcp_port, longest_search});
    if (!devices) return {};
    const auto found =
        std::ranges::find_if(*devices, [&](const auto& each) { return is_same(identity_of(each.identity), identity); });
    return found != devices->end() ? found->address : std::string();
}

Failure absence(const Settings& settings, const ResetDevice& before, const Host& where,
                const ResetArguments& arguments) {
    const auto seconds = static_cast<double>(arguments.patience.count()) / 1000;
    auto text = fmt::format("{} did not answer at {} within {} s", printable(before.identity.product_name),
                            to_string(where), seconds);
    const bool is_here = where.name == "localhost" || where.name.starts_with("127.");
    const auto elsewhere =
        settings.route.segments.empty() && !is_here ? found_elsewhere(before.identity) : std::string();
    if (!elsewhere.empty()) {
        text += fmt::format("; it is at {} now", elsewhere);
    } else if (arguments.kind == ResetKind::factory) {
        text += "; it may wait for an address, or have another one: 'servobus-scanner discover' shows who is there";
    }
    return {ExitCode::no_connection, text};
}

Failure stranger(const ResetDevice& device) {
    return {ExitCode::nonsense, fmt::format("another device answers there now: {}", name_of(device.identity))};
}

}  // namespace

ExitCode reset(const Console& console, const Settings& settings, const std::string& host,
               const ResetArguments& arguments) {
    const auto where = parse_host(host);
    if (!where) return fail(console, where.error());
    if (!arguments.yes && console.person == nullptr) {
        return fail(console, Mistake{"reset asks before it does anything, and there is nobody to answer here; --yes "
                                     "goes on without a question"});
    }
    const auto before = examine(settings, *where);
    if (!before) return fail(console, before.error(), host);
    if (!arguments.yes && !agrees(console, *before, host, arguments.kind)) {
        return fail(console, Mistake{"nothing was reset"}, host);
    }
    if (const auto failure = send(settings, *where, arguments)) return fail(console, *failure, host);
    ResetResult result{arguments.kind, *before, {}, {}};
    if (arguments.wait) {
        const auto begin = Clock::now();
        result.after = wait_for(settings, *where, begin + arguments.patience);
        result.away = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - begin);
        if (!result.after) return fail(console, absence(settings, *before, *where, arguments), host);
        if (!is_same(before->identity, result.after->identity)) return fail(console, stranger(*result.after), host);
    }
    console.show(reset_text(result), console.json ? reset_json(host, result) : std::string());
    return ExitCode::done;
}

}  // namespace servobus::scanner::cli
