#include "scanner/cli/conformance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <random>

#include "assemblies/connection.hpp"
#include "drive/xenax.hpp"
#include "eds/data_sheet.hpp"
#include "scanner/cli/conformance_output.hpp"
#include "scanner/cli/interruption.hpp"
#include "scanner/cli/sheet_file.hpp"
#include "scanner/cli/text_output.hpp"
#include "scanner/conformance/suite.hpp"
#include "scanner/sheet_plan.hpp"

namespace servobus::scanner::cli {
namespace {

using conformance::Candidate;
using conformance::Case;
using Candidates = std::vector<Candidate>;
using Cases = std::vector<const Case*>;

constexpr std::string_view standard_output = "-";

std::string in_capitals(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return text;
}

Parsed<Cases> choose(const ConformanceArguments& arguments) {
    const auto all = conformance::all_cases();
    for (const auto& group : arguments.groups) {
        const bool known = std::ranges::any_of(conformance::groups, [&](const auto& row) { return row.name == group; });
        if (!known) return Mistake{fmt::format("--group: '{}' is no group; --list has them all", group)};
    }
    for (const auto& id : arguments.cases) {
        const bool known = std::ranges::any_of(all, [&](const Case& each) { return each.id == in_capitals(id); });
        if (!known) return Mistake{fmt::format("--case: '{}' is no case; --list has them all", id)};
    }
    const auto wanted = [&](const Case& each) {
        if (arguments.groups.empty() && arguments.cases.empty()) return true;
        const auto is_it = [&](const std::string& id) { return in_capitals(id) == each.id; };
        return std::ranges::count(arguments.groups, conformance::row_of(each.group).name) > 0 ||
               std::ranges::any_of(arguments.cases, is_it);
    };
    Cases chosen;
    for (const auto& each : all) {
        if (wanted(each)) chosen.push_back(&each);
    }
    return chosen;
}

/// A document that goes to a file or to standard output.
class Sink {
public:
    Sink(const Console& console, std::string file) : console_(console), file_(std::move(file)) {}

    [[nodiscard]] bool is_wanted() const { return !file_.empty(); }
    [[nodiscard]] bool takes_standard_output() const { return file_ == standard_output; }

    /// Before the first case, since it is a pity to have run them for nothing.
    std::optional<Mistake> open() {
        if (!is_wanted() || takes_standard_output()) return std::nullopt;
        stream_.open(file_, std::ios::binary | std::ios::trunc);
        return stream_ ? std::nullopt : std::optional(cannot_write());
    }
    std::optional<Mistake> write(const std::string& document) {
        if (!is_wanted()) return std::nullopt;
        if (takes_standard_output()) {
            console_.out << document;
            return std::nullopt;
        }
        stream_ << document << std::flush;
        return stream_ ? std::nullopt : std::optional(cannot_write());
    }

private:
    [[nodiscard]] Mistake cannot_write() const { return {fmt::format("{}: it cannot be written", file_)}; }

    const Console& console_;
    std::string file_;
    std::ofstream stream_;
};

bool is_xenax(const Identity& identity) {
    return std::ranges::any_of(drive::xenax_models(), [&](const drive::Model& model) {
        return model.identity.vendor == identity.vendor && model.identity.product_code == identity.product_code;
    });
}

/// The connections that the user has described, or the sheet; nullopt: nobody has.
Parsed<std::optional<Candidates>> described(const ConnectionArguments& arguments) {
    if (!arguments.eds.empty()) {
        if (arguments.o_to_t_point || arguments.t_to_o_point) {
            return Mistake{"--eds has the points of the connections; --o2t and --t2o are for devices without a file"};
        }
        const auto sheet = load_sheet(arguments.eds);
        if (!sheet) return sheet.error();
        auto candidates = conformance::candidates_of(**sheet);
        if (!arguments.connection.empty()) {
            const auto chosen = choose_connection(**sheet, arguments.connection);
            if (!chosen) return Mistake{fmt::format("{}: {}", arguments.eds, printable(chosen.error().text))};
            const auto& wanted = (*chosen)->name.empty() ? (*chosen)->keyword : (*chosen)->name;
            std::erase_if(candidates, [&](const Candidate& each) { return each.name != wanted; });
        }
        return std::optional(std::move(candidates));
    }
    if (arguments.o_to_t_point) {
        const auto task = make_task(arguments, {});
        if (!task) return task.error();
        return std::optional(Candidates{conformance::candidate_of(task->plan)});
    }
    if (arguments.t_to_o_point || arguments.o_to_t_octets || arguments.t_to_o_octets) {
        return Mistake{"--t2o, --o2t-size and --t2o-size go with --o2t"};
    }
    if (!arguments.connection.empty() && assemblies::find_connection(arguments.connection) == nullptr) {
        return Mistake{fmt::format("--connection: '{}' is none of {}; others need --eds", arguments.connection,
                                   connection_keys())};
    }
    return std::optional<Candidates>();
}

/// Those of a XENAX, or those of them that have the key.
Candidates built_in(const std::string& key) {
    auto candidates = conformance::candidates_of_xenax();
    if (!key.empty())
        std::erase_if(candidates, [&](const Candidate& each) { return !each.name.starts_with(key + " "); });
    return candidates;
}

ExitCode list(const Console& console, const Cases& cases, Sink& json) {
    if (!json.takes_standard_output()) console.out << conformance_list(cases);
    const auto mistake = json.write(conformance_list_json(cases));
    return mistake ? fail(console, *mistake) : ExitCode::done;
}

}  // namespace

ExitCode conformance(const Console& console, const Settings& settings, const ConformanceArguments& arguments) {
    Sink junit(console, arguments.junit);
    Sink json(console, arguments.json.empty() && settings.json ? std::string(standard_output) : arguments.json);
    if (junit.takes_standard_output() && json.takes_standard_output()) {
        return fail(console, Mistake{"--junit and --json cannot both go to standard output"});
    }
    const auto cases = choose(arguments);
    if (!cases) return fail(console, cases.error());
    if (!settings.route.segments.empty() || settings.connected) {
        return fail(console,
                    Mistake{"conformance has no --route and no --connected: it asks the device at HOST itself"});
    }
    const auto known = described(arguments.connection);
    if (!known) return fail(console, known.error());
    for (auto* sink : {&junit, &json}) {
        if (const auto mistake = sink->open()) return fail(console, *mistake);
    }
    if (arguments.list) return list(console, *cases, json);
    if (arguments.host.empty()) return fail(console, Mistake{"HOST is missing; see --help"});
    const auto host = parse_host(arguments.host);
    if (!host) return fail(console, host.error());

    const auto seed = std::random_device()();
    conformance::SubjectOptions options{.host = *host,
                                        .timeout = settings.timeout,
                                        .writes = arguments.writes,
                                        .candidates = known->value_or(Candidates{}),
                                        .seed = seed};
    conformance::Subject subject(options);
    if (const auto why = get_acquainted(subject); !why.empty()) {
        return fail(console, Failure{ExitCode::no_connection, fmt::format("{}: {}", to_string(*host), why)},
                    arguments.host);
    }
    if (!*known && subject.identity && is_xenax(*subject.identity)) {
        subject.set_candidates(built_in(arguments.connection.connection));
    }

    const bool speaks = !junit.takes_standard_output() && !json.takes_standard_output();
    if (speaks) console.out << conformance_head(arguments.host, subject) << std::flush;
    std::optional<conformance::Group> group;
    const auto progress = [&](const conformance::Result& result) {
        if (!speaks) return;
        if (group != result.which->group) console.out << conformance_group(result.which->group);
        group = result.which->group;
        console.out << conformance_result(result, arguments.verbose) << std::flush;
    };
    const Interruption interruption(console.interruptions);
    const auto report = run_cases(subject, *cases, progress, [&] { return interruption.count() > 0; });
    if (speaks) console.out << conformance_summary(report);

    auto wrong = junit.write(conformance_junit(arguments.host, report));
    if (const auto also = json.write(conformance_json(arguments.host, subject, report)); also && !wrong) wrong = also;
    if (wrong) return fail(console, *wrong);
    if (report.interrupted) {
        console.say("interrupted");
        return ExitCode::interrupted;
    }
    const auto failed = report.count(conformance::Outcome::fail);
    if (failed == 0) return ExitCode::done;
    console.say(fmt::format("{} fails {} of {} cases", to_string(*host), failed, report.results.size()));
    return ExitCode::refused;
}

}  // namespace servobus::scanner::cli
