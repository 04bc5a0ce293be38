// discover and identity: who is there, and who it says it is.
#include "scanner/cli/identify.hpp"

#include <fmt/format.h>

#include "cip/services.hpp"
#include "scanner/cli/json_output.hpp"
#include "scanner/cli/text_output.hpp"
#include "scanner/cli/verbs.hpp"

namespace servobus::scanner::cli {
namespace {

using Attempt = boost::system::result<Identity, Failure>;

Failure refusal(const cip::Status& status) {
    return {ExitCode::refused, fmt::format("the Identity object refused with {}", cip::describe(status)), status};
}

/// The attributes from `first` on, one after the other. The state is optional (R-ID-1).
Attempt read_attributes(Link& link, Identity identity, std::uint32_t first) {
    for (std::uint32_t id = first; id <= identity_state_attribute; ++id) {
        const auto path = cip::Path::to(cip::class_id::identity, 1, id);
        const auto answer = link.call({cip::service::get_attribute_single, path, {}});
        if (!answer) return link.failure_of(answer.error());
        if (!answer->status.ok()) {
            if (id > last_required_identity_attribute) break;
            return refusal(answer->status);
        }
        if (!set_attribute(identity, id, answer->data)) return link.failure_of(make_error_code(Error::missing_data));
    }
    return identity;
}

ExitCode nobody(const Console& console, const Failure& failure) {
    console.show({}, console.json ? devices_json({}, failure) : std::string());
    console.say(failure.text);
    return failure.code;
}

}  // namespace

boost::system::result<Identity, Failure> ask_identity(Link& link) {
    const auto answer = link.call({cip::service::get_attributes_all, cip::Path::to(cip::class_id::identity, 1), {}});
    if (!answer) return link.failure_of(answer.error());
    if (!answer->status.ok()) return read_attributes(link, {}, first_identity_attribute);
    const auto identity = scanner::read_identity(answer->data);
    if (!identity) return link.failure_of(make_error_code(Error::missing_data));
    if (identity->state) return *identity;
    // Many devices tell all but their state; what they did tell is not lost when asking for it goes wrong.
    const auto with_state = read_attributes(link, *identity, identity_state_attribute);
    return with_state ? with_state : *identity;
}

ExitCode discover(const Console& console, const Settings& settings, const DiscoverArguments& arguments) {
    const auto where = arguments.host ? parse_host(*arguments.host) : Parsed<Host>(Host{});
    if (!where) return fail(console, where.error());
    const auto wait = std::min(arguments.wait, settings.timeout);
    const auto devices = arguments.host
                             ? probe({where->name, where->port, std::min(wait, settings.timeout / 2), settings.timeout})
                             : broadcast({arguments.port, wait});
    if (!devices) {
        if (arguments.host) return nobody(console, failure_of(devices.error(), *where, settings.timeout));
        return nobody(console, {exit_code_of(devices.error()),
                                fmt::format("no interface can broadcast: {}", words(devices.error()))});
    }
    if (devices->empty()) {
        return nobody(console, {ExitCode::no_connection,
                                "no device answered; try a longer --wait, or --host ADDRESS for a device in another "
                                "network"});
    }
    console.show(devices_text(*devices), console.json ? devices_json(*devices) : std::string());
    return ExitCode::done;
}

ExitCode identity(const Console& console, const Settings& settings, const std::string& host) {
    const auto where = parse_host(host);
    if (!where) return fail(console, where.error());
    Link link(settings, *where);
    if (const auto failure = link.open()) return fail(console, *failure, host);
    const auto identity = ask_identity(link);
    if (!identity) return fail(console, identity.error(), host);
    console.show(identity_text(*identity), identity_json(host, *identity));
    return ExitCode::done;
}

}  // namespace servobus::scanner::cli
