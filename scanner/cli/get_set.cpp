// get, set and command: the verbs for single parameters.
#include <fmt/format.h>

#include "cip/services.hpp"
#include "drive/lookup.hpp"
#include "drive/xenax.hpp"
#include "scanner/cli/json_output.hpp"
#include "scanner/cli/text_output.hpp"
#include "scanner/cli/verbs.hpp"

namespace servobus::scanner::cli {
namespace {

/// Everything after the connection has gone is not asked any more.
bool is_end(const Outcome& outcome) {
    const auto* error = std::get_if<error_code>(&outcome.result);
    return error != nullptr && trouble_of(*error) == Trouble::connection;
}

Outcome read(Link& link, const What& what) {
    if (const auto* row = what.row()) {
        auto answer = link.read(*row);
        if (!answer) return {what, answer.error()};
        if (!answer->value) return {what, answer->status};
        return {what, std::move(*answer->value), answer->surplus};
    }
    auto answer = link.call({cip::service::get_attribute_single, what.path(), {}});
    if (!answer) return {what, answer.error()};
    if (!answer->status.ok()) return {what, answer->status};
    return {what, std::move(answer->data)};
}

cip::Request request_of(const Assignment& assignment) {
    if (const auto* octets = std::get_if<cip::Bytes>(&assignment.value)) {
        return {cip::service::set_attribute_single, assignment.what.path(), *octets};
    }
    return write_request(*assignment.what.row(), std::get<drive::Value>(assignment.value));
}

Outcome write(Link& link, const Assignment& assignment) {
    const auto answer = link.call(request_of(assignment));
    if (!answer) return {assignment.what, answer.error()};
    if (!answer->status.ok()) return {assignment.what, answer->status};
    if (const auto* octets = std::get_if<cip::Bytes>(&assignment.value)) return {assignment.what, *octets};
    return {assignment.what, std::get<drive::Value>(assignment.value)};
}

/// The row that takes direct commands.
const drive::Parameter* command_row(const drive::Model& model) {
    for (const auto& row : model.parameters) {
        if (model.direct_command_row && row.key() == *model.direct_command_row) return &row;
    }
    return nullptr;
}

}  // namespace

ExitCode get(const Console& console, const Settings& settings, const std::string& host,
             const std::vector<std::string>& whats) {
    const auto where = parse_host(host);
    if (!where) return fail(console, where.error());
    std::vector<What> targets;
    for (const auto& text : whats) {
        const auto what = parse_what(text);
        if (!what) return fail(console, what.error(), host);
        targets.push_back(*what);
    }
    Link link(settings, *where);
    if (const auto failure = link.open()) return fail(console, *failure, host);

    std::vector<Outcome> outcomes;
    std::optional<Failure> failure;
    for (const auto& what : targets) {
        if (failure) {
            outcomes.push_back({what, NotAsked{"not asked any more"}});
            continue;
        }
        outcomes.push_back(read(link, what));
        if (is_end(outcomes.back())) {
            failure = link.failure_of(std::get<error_code>(outcomes.back().result));
        }
    }
    return report(console, host, outcomes, failure);
}

ExitCode set(const Console& console, const Settings& settings, const std::string& host,
             const std::vector<std::string>& assignments) {
    const auto where = parse_host(host);
    if (!where) return fail(console, where.error());
    std::vector<Assignment> values;
    for (const auto& text : assignments) {
        auto assignment = parse_assignment(text);
        if (!assignment) return fail(console, assignment.error(), host);
        values.push_back(std::move(*assignment));
    }
    Link link(settings, *where);
    if (const auto failure = link.open()) return fail(console, *failure, host);

    // A later value may rest on an earlier one, so a refusal ends it.
    std::vector<Outcome> outcomes;
    std::optional<Failure> failure;
    bool stopped = false;
    for (const auto& assignment : values) {
        if (stopped) {
            outcomes.push_back({assignment.what, NotAsked{"not set, since the one before failed"}});
            continue;
        }
        outcomes.push_back(write(link, assignment));
        stopped = !outcomes.back().has_value();
        if (is_end(outcomes.back())) {
            failure = link.failure_of(std::get<error_code>(outcomes.back().result));
        }
    }
    return report(console, host, outcomes, failure);
}

ExitCode command(const Console& console, const Settings& settings, const std::string& host,
                 const std::string& mnemonic) {
    const auto where = parse_host(host);
    if (!where) return fail(console, where.error());
    const auto& model = drive::xenax_models().front();
    const auto* known = drive::find_command(model.direct_commands, mnemonic);
    const auto* row = command_row(model);
    if (known == nullptr || row == nullptr) {
        const auto near = drive::nearest_commands(model.direct_commands, mnemonic);
        const auto hint = near.empty() ? "'servobus-scanner list --commands' shows all" : suggestion(near);
        return fail(console, Mistake{fmt::format("no direct command is called '{}'; {}", mnemonic, hint)}, host);
    }
    Link link(settings, *where);
    if (const auto failure = link.open()) return fail(console, *failure, host);
    const Assignment assignment{What{row}, drive::Value(std::int64_t{known->value})};
    const CommandResult result{known, write(link, assignment)};
    if (is_end(result.outcome)) {
        return fail(console, link.failure_of(std::get<error_code>(result.outcome.result)), host);
    }
    console.show(result.outcome.has_value() ? command_text(result) : std::string(), command_json(host, result));
    if (const auto* status = std::get_if<cip::Status>(&result.outcome.result)) {
        console.say(fmt::format("{}: refused with {}", known->name, cip::describe(*status)));
    } else if (const auto* error = std::get_if<error_code>(&result.outcome.result)) {
        console.say(fmt::format("{}: {}", known->name, words(*error)));
    }
    return exit_code_of({result.outcome});
}

}  // namespace servobus::scanner::cli
