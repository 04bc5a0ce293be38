#include "scanner/cli/sheet_verbs.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <set>
#include <variant>

#include "cip/hex.hpp"
#include "cip/services.hpp"
#include "scanner/cli/pattern.hpp"
#include "scanner/cli/results.hpp"
#include "scanner/cli/sheet_file.hpp"
#include "scanner/cli/sheet_json.hpp"
#include "scanner/cli/table.hpp"
#include "scanner/cli/text_output.hpp"
#include "scanner/sheet_check.hpp"
#include "scanner/sheet_value.hpp"

namespace servobus::scanner::cli {
namespace {

using Json = nlohmann::ordered_json;
// Those of a data sheet; what is called so in here is about the drive's table.
using scanner::limits_text;
using scanner::type_name;
using scanner::value_text;
using Sheet = std::shared_ptr<const eds::DataSheet>;

/// What became of one parameter. Octets are of a type that is not understood.
struct SheetOutcome {
    const eds::Parameter* parameter = nullptr;
    std::variant<NotAsked, eds::Value, cip::Bytes, cip::Status, error_code> result;

    [[nodiscard]] bool has_value() const { return result.index() == 1 || result.index() == 2; }
    [[nodiscard]] const error_code* error() const { return std::get_if<error_code>(&result); }
};

struct SheetAssignment {
    const eds::Parameter* parameter = nullptr;
    eds::Value value{};
};

cip::Path path_to(const eds::Parameter& parameter) { return read_request(parameter)->path; }

Parsed<const eds::Parameter*> addressed(const eds::DataSheet& sheet, std::string_view word) {
    auto found = find_parameter(sheet, word);
    if (!found || read_request(**found)) return found;
    return Mistake{
        fmt::format("{} has no address in the file: it is a part of connections alone", display_name(sheet, **found))};
}

// -------------------------------------------------------------------------------------------------------------- asking

SheetOutcome read(Link& link, const eds::Parameter& parameter) {
    auto answer = link.call(*read_request(parameter));
    if (!answer) return {&parameter, answer.error()};
    if (!answer->status.ok()) return {&parameter, answer->status};
    const auto size = value_octets(parameter, answer->data);
    if (size && *size > answer->data.size()) return {&parameter, make_error_code(Error::missing_data)};
    const auto value = size ? decode(parameter, cip::ByteView(answer->data).first(*size)) : std::nullopt;
    if (value) return {&parameter, *value};
    return {&parameter, std::move(answer->data)};
}

SheetOutcome write(Link& link, const SheetAssignment& assignment) {
    const auto& parameter = *assignment.parameter;
    const auto answer =
        link.call({cip::service::set_attribute_single, path_to(parameter), *parameter.encode(assignment.value)});
    if (!answer) return {&parameter, answer.error()};
    if (!answer->status.ok()) return {&parameter, answer->status};
    return {&parameter, assignment.value};
}

ExitCode exit_code_of(const SheetOutcome& outcome) {
    if (outcome.has_value() || std::holds_alternative<NotAsked>(outcome.result)) return ExitCode::done;
    return outcome.error() != nullptr ? cli::exit_code_of(*outcome.error()) : ExitCode::refused;
}

/// The worst of them, as everywhere.
ExitCode exit_code_of(const std::vector<SheetOutcome>& outcomes) {
    for (const auto code : {ExitCode::no_connection, ExitCode::nonsense, ExitCode::refused, ExitCode::usage}) {
        for (const auto& outcome : outcomes) {
            if (exit_code_of(outcome) == code) return code;
        }
    }
    return ExitCode::done;
}

// ------------------------------------------------------------------------------------------------------------- showing

std::string shown(const SheetOutcome& outcome) {
    const auto& parameter = *outcome.parameter;
    if (const auto* octets = std::get_if<cip::Bytes>(&outcome.result)) return cip::to_hex(*octets);
    const auto text = printable(value_text(parameter, std::get<eds::Value>(outcome.result)));
    return parameter.units.empty() ? text : fmt::format("{} {}", text, printable(parameter.units));
}

std::string refusal_text(const eds::DataSheet& sheet, const SheetOutcome& outcome) {
    const auto name = display_name(sheet, *outcome.parameter);
    if (const auto* reason = std::get_if<NotAsked>(&outcome.result)) return fmt::format("{}: {}", name, reason->reason);
    if (outcome.error() != nullptr) return fmt::format("{}: {}", name, words(*outcome.error()));
    const auto& status = std::get<cip::Status>(outcome.result);
    const auto limits = limits_text(*outcome.parameter);
    const bool is_value = status.general == cip::GeneralStatus::invalid_attribute_value && !limits.empty();
    return fmt::format("{}: refused with {}{}", name, cip::describe(status),
                       is_value ? "; it takes " + printable(limits) : std::string());
}

Json outcome_json(const SheetOutcome& outcome) {
    auto json = parameter_json(*outcome.parameter);
    if (const auto* value = std::get_if<eds::Value>(&outcome.result)) {
        json["value"] = value_json(engineering(*outcome.parameter, *value));
        json["raw"] = value_json(*value);
        const auto* whole = std::get_if<std::int64_t>(value);
        const auto* text = whole != nullptr ? outcome.parameter->enum_text(*whole) : nullptr;
        if (text != nullptr) json["text"] = printable(*text);
    } else if (const auto* octets = std::get_if<cip::Bytes>(&outcome.result)) {
        json["value"] = nullptr;
        json["octets"] = cip::to_hex(*octets);
    } else if (const auto* status = std::get_if<cip::Status>(&outcome.result)) {
        json["error"] = {{"general", static_cast<int>(status->general)},
                         {"extended", status->extended},
                         {"text", cip::describe(*status)}};
    } else if (outcome.error() != nullptr) {
        json["error"] = {{"kind", std::string(row_of(exit_code_of(outcome)).kind)}, {"text", words(*outcome.error())}};
    } else {
        json["not_asked"] = std::get<NotAsked>(outcome.result).reason;
    }
    return json;
}

ExitCode report(const Console& console, const std::string& host, const eds::DataSheet& sheet,
                const std::vector<SheetOutcome>& outcomes, const std::optional<Failure>& failure) {
    std::string text;
    Json json{{"host", host}, {"values", Json::array()}};
    for (const auto& outcome : outcomes) {
        json["values"].push_back(outcome_json(outcome));
        if (!outcome.has_value()) continue;
        text += fmt::format("{} = {}  (CIP {}, Param{})\n", display_name(sheet, *outcome.parameter), shown(outcome),
                            cip_address(*outcome.parameter), outcome.parameter->number);
    }
    const auto code = failure ? failure->code : exit_code_of(outcomes);
    if (failure) {
        json["error"] = {
            {"kind", std::string(row_of(code).kind)}, {"text", failure->text}, {"exit_code", static_cast<int>(code)}};
    }
    console.show(text, document(json));
    for (const auto& outcome : outcomes) {
        if (!outcome.has_value()) console.say(refusal_text(sheet, outcome));
    }
    if (failure) console.say(failure->text);
    return code;
}

// ---------------------------------------------------------------------------------------------------------- assignments

/// What the sheet has against it; empty: nothing.
std::string objection(const eds::Parameter& parameter, const eds::Value& value) {
    if (parameter.read_only()) return "the file says that it is read only";
    if (!within_limits(parameter, value)) return fmt::format("it takes {}", printable(limits_text(parameter)));
    return {};
}

Parsed<SheetAssignment> assignment_of(const eds::DataSheet& sheet, std::string_view name, std::string_view text,
                                      bool force) {
    const auto parameter = addressed(sheet, name);
    if (!parameter) return parameter.error();
    const auto shown_name = display_name(sheet, **parameter);
    auto value = parse_value(**parameter, text);
    if (!value) return Mistake{fmt::format("{}: {}", shown_name, printable(value.error().text))};
    const auto against = objection(**parameter, *value);
    if (!force && !against.empty()) {
        return Mistake{fmt::format("{}: {}; --force sends it all the same", shown_name, against)};
    }
    return SheetAssignment{*parameter, std::move(*value)};
}

Parsed<std::vector<SheetAssignment>> assignments_of(const eds::DataSheet& sheet, const std::vector<std::string>& words,
                                                    bool force) {
    std::vector<SheetAssignment> all;
    const bool pair = words.size() == 2 && words[0].find('=') == std::string::npos;
    for (std::size_t i = 0; i < words.size(); i += pair ? 2 : 1) {
        const auto equals = words[i].find('=');
        if (!pair && equals == std::string::npos) {
            return Mistake{fmt::format("'{}' has no value: write NAME=VALUE", words[i])};
        }
        auto assignment = pair ? assignment_of(sheet, words[0], words[1], force)
                               : assignment_of(sheet, std::string_view(words[i]).substr(0, equals),
                                               std::string_view(words[i]).substr(equals + 1), force);
        if (!assignment) return assignment.error();
        all.push_back(std::move(*assignment));
    }
    return all;
}

/// One after the other, until the connection is lost or, with `stops`, one has no value.
template <class Item, class Ask>
ExitCode ask_all(const Console& console, const std::string& host, const eds::DataSheet& sheet, Link& link,
                 const std::vector<Item>& items, Ask ask, bool stops) {
    std::vector<SheetOutcome> outcomes;
    std::optional<Failure> failure;
    bool stopped = false;
    for (const auto& item : items) {
        if (failure || stopped) {
            const auto reason = failure ? "not asked any more" : "not set, since the one before failed";
            outcomes.push_back(ask(item, reason));
            continue;
        }
        outcomes.push_back(ask(item, nullptr));
        stopped = stops && !outcomes.back().has_value();
        const auto* error = outcomes.back().error();
        if (error != nullptr && trouble_of(*error) == Trouble::connection) failure = link.failure_of(*error);
    }
    return report(console, host, sheet, outcomes, failure);
}

// ---------------------------------------------------------------------------------------------------------------- list

std::string_view access_text(const eds::Parameter& parameter) {
    if (!read_request(parameter)) return "connection";
    return parameter.read_only() ? "get" : "get/set";
}

bool is_meant(const eds::Parameter& parameter, std::string_view pattern) {
    if (pattern.empty()) return true;
    for (const auto& word :
         {printable(parameter.name), fmt::format("Param{}", parameter.number), cip_address(parameter)}) {
        if (matches(pattern, lower_case(word))) return true;
    }
    return false;
}

std::vector<std::string> list_row(const eds::Parameter& parameter) {
    const bool has_default = !std::holds_alternative<std::monostate>(parameter.standard);
    return {printable(parameter.name),
            fmt::format("Param{}", parameter.number),
            type_name(parameter.type),
            printable(parameter.units),
            std::string(access_text(parameter)),
            printable(limits_text(parameter)),
            has_default ? printable(value_text(parameter, parameter.standard)) : std::string(),
            cip_address(parameter)};
}

std::string names_of(const eds::DataSheet& sheet, const std::vector<const eds::Parameter*>& parameters) {
    std::set<std::string> names;
    for (const auto* each : parameters) {
        if (read_request(*each)) names.insert(display_name(sheet, *each));
    }
    return fmt::format("{}\n", fmt::join(names, "\n"));
}

}  // namespace

ExitCode sheet_get(const Console& console, const Settings& settings, const SheetArguments& arguments,
                   const std::string& host, const std::vector<std::string>& words) {
    const auto where = parse_host(host);
    if (!where) return fail(console, where.error());
    const auto sheet = load_sheet(arguments.file);
    if (!sheet) return fail(console, sheet.error(), host);
    std::vector<const eds::Parameter*> parameters;
    for (const auto& word : words) {
        const auto parameter = addressed(**sheet, word);
        if (!parameter) return fail(console, parameter.error(), host);
        parameters.push_back(*parameter);
    }
    Link link(settings, *where);
    if (const auto failure = link.open()) return fail(console, *failure, host);
    const auto ask = [&](const eds::Parameter* parameter, const char* reason) -> SheetOutcome {
        if (reason != nullptr) return {parameter, NotAsked{reason}};
        return read(link, *parameter);
    };
    return ask_all(console, host, **sheet, link, parameters, ask, false);
}

ExitCode sheet_set(const Console& console, const Settings& settings, const SheetArguments& arguments,
                   const std::string& host, const std::vector<std::string>& words) {
    const auto where = parse_host(host);
    if (!where) return fail(console, where.error());
    const auto sheet = load_sheet(arguments.file);
    if (!sheet) return fail(console, sheet.error(), host);
    const auto assignments = assignments_of(**sheet, words, arguments.force);
    if (!assignments) return fail(console, assignments.error(), host);
    Link link(settings, *where);
    if (const auto failure = link.open()) return fail(console, *failure, host);
    const auto ask = [&](const SheetAssignment& assignment, const char* reason) -> SheetOutcome {
        if (reason != nullptr) return {assignment.parameter, NotAsked{reason}};
        return write(link, assignment);
    };
    return ask_all(console, host, **sheet, link, *assignments, ask, true);
}

ExitCode sheet_list(const Console& console, const SheetArguments& arguments, const std::string& pattern, bool names) {
    const auto sheet = load_sheet(arguments.file);
    if (!sheet) return fail(console, sheet.error());
    std::vector<const eds::Parameter*> parameters;
    for (const auto& each : (*sheet)->parameters) {
        if (is_meant(each, lower_case(pattern))) parameters.push_back(&each);
    }
    if (parameters.empty()) return fail(console, Mistake{fmt::format("nothing in the file is called '{}'", pattern)});
    Table table({"NAME", "PARAM", "TYPE", "UNIT", "ACCESS", "LIMITS", "DEFAULT", "CIP"});
    Json json{{"parameters", Json::array()}};
    for (const auto* each : parameters) {
        table.add(list_row(*each));
        auto entry = parameter_json(*each);
        entry["access"] = std::string(access_text(*each));
        entry["default"] = value_json(engineering(*each, each->standard));
        entry["text"] = printable(each->help);
        json["parameters"].push_back(std::move(entry));
    }
    console.show(names ? names_of(**sheet, parameters) : table.text(), document(json));
    return ExitCode::done;
}

}  // namespace servobus::scanner::cli
