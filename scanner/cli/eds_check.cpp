// eds check: is the device what its data sheet says?
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>

#include "cip/file_transfer.hpp"
#include "scanner/cli/eds.hpp"
#include "scanner/cli/identify.hpp"
#include "scanner/cli/io_runner.hpp"
#include "scanner/cli/open_trial.hpp"
#include "scanner/cli/sheet_file.hpp"
#include "scanner/cli/sheet_json.hpp"
#include "scanner/cli/text_output.hpp"
#include "scanner/inflate.hpp"
#include "scanner/sheet_check.hpp"
#include "scanner/sheet_plan.hpp"

namespace servobus::scanner::cli {
namespace {

using Json = nlohmann::ordered_json;
using Group = Comparison::Group;
using Comparisons = std::vector<Comparison>;
/// Why the check came to an early end.
using Ending = std::optional<Failure>;

constexpr std::array groups{Group::identity, Group::parameter, Group::assembly, Group::connection, Group::file};

class Check {
public:
    Check(const Settings& settings, Host host, const eds::DataSheet& sheet, cip::ByteView file)
        : settings_(settings), host_(std::move(host)), sheet_(sheet), file_(file) {}

    Ending run(bool open) {
        {
            Link link(settings_, host_);
            if (auto failure = link.open()) return failure;
            link.count_from_last_answer();
            using Step = Ending (Check::*)(Link&);
            for (const Step step : {&Check::identity, &Check::parameters, &Check::assemblies, &Check::connections,
                                    &Check::file_in_device}) {
                if (auto failure = (this->*step)(link)) return failure;
            }
        }
        if (open) open_connections();
        return std::nullopt;
    }

    [[nodiscard]] const Comparisons& comparisons() const { return comparisons_; }

private:
    Ending identity(Link& link) {
        const auto identity = ask_identity(link);
        if (!identity) return identity.error();
        auto found = compare_identity(sheet_.device, *identity);
        std::ranges::move(found, std::back_inserter(comparisons_));
        return std::nullopt;
    }

    Ending parameters(Link& link) {
        for (const auto& parameter : sheet_.parameters) {
            const auto request = read_request(parameter);
            if (!request) continue;
            const auto answer = link.call(*request);
            if (answer) {
                comparisons_.push_back(compare_parameter(parameter, *answer));
            } else if (trouble_of(answer.error()) == Trouble::connection) {
                return link.failure_of(answer.error());
            } else {
                comparisons_.push_back({Group::parameter, fmt::format("Param{} {}", parameter.number, parameter.name),
                                        Agreement::different, words(answer.error())});
            }
        }
        return std::nullopt;
    }

    /// Each instance is asked once.
    Ending size_of(Link& link, std::uint32_t instance, AssemblySize& size) {
        if (const auto known = sizes_.find(instance); known != sizes_.end()) {
            size = known->second;
            return std::nullopt;
        }
        const auto told = link.call(size_request(instance));
        if (!told) return link.failure_of(told.error());
        std::optional<cip::Response> data;
        if (!told->status.ok()) {
            auto answer = link.call(data_request(instance));
            if (!answer) return link.failure_of(answer.error());
            data = std::move(*answer);
        }
        size = sizes_[instance] = assembly_size(*told, data);
        return std::nullopt;
    }

    Ending assemblies(Link& link) {
        for (const auto& assembly : sheet_.assemblies) {
            const auto instance = instance_of(assembly);
            if (!instance) continue;
            AssemblySize size;
            if (auto failure = size_of(link, *instance, size)) return failure;
            comparisons_.push_back(compare_assembly(assembly, size));
        }
        return std::nullopt;
    }

    Ending connections(Link& link) {
        for (const auto& connection : sheet_.connections) {
            const auto plan = plan_of(sheet_, connection);
            if (!plan) {
                comparisons_.push_back({Group::connection, subject_of(connection), Agreement::different,
                                        "it cannot be opened as the file has it: " + plan.error().text});
                continue;
            }
            ConnectionSizes sizes;
            // Points of another path are no assemblies.
            if (!plan->application_path) {
                if (auto failure = size_of(link, plan->o_to_t.point, sizes.o_to_t)) return failure;
                if (auto failure = size_of(link, plan->t_to_o.point, sizes.t_to_o)) return failure;
                if (plan->configuration_instance && !plan->configuration.empty()) {
                    if (auto failure = size_of(link, *plan->configuration_instance, sizes.configuration))
                        return failure;
                }
            }
            comparisons_.push_back(compare_connection(connection, *plan, sizes));
        }
        return std::nullopt;
    }

    /// Most devices keep no file about themselves, which is no difference.
    Ending file_in_device(Link& link) {
        const auto outcome = link.upload({}, {});
        if (!outcome) return link.failure_of(outcome.error());
        if (const auto* failure = std::get_if<UploadFailure>(&*outcome)) {
            const bool none = failure->error == UploadError::no_file_object || failure->error == UploadError::no_file ||
                              failure->error == UploadError::busy || failure->error == UploadError::refused;
            comparisons_.push_back({Group::file, "the file in the device (class 0x37)",
                                    none ? Agreement::not_compared : Agreement::different, describe(*failure)});
            return std::nullopt;
        }
        const auto& uploaded = std::get<UploadedFile>(*outcome);
        auto content = uploaded.content;
        if (uploaded.attributes.encoding == cip::file::Encoding::compressed) {
            if (auto inflated = inflate(content)) content = std::move(*inflated);
        }
        comparisons_.push_back(compare_file(content, file_));
        return std::nullopt;
    }

    static std::string subject_of(const eds::Connection& connection) {
        return fmt::format("{} {}", connection.keyword, connection.name);
    }

    /// A connection that others can listen to the inputs of: one that sends them to a group.
    [[nodiscard]] std::optional<IoPlan> companion_of(const IoPlan& listener) const {
        for (const auto& each : sheet_.connections) {
            if (each.transport.is(eds::Ownership::listen_only) || !each.parameters.t_to_o().multicast) continue;
            auto plan = plan_of(sheet_, each);
            if (!plan || plan->t_to_o.point != listener.t_to_o.point) continue;
            plan->t_to_o.type = cip::ConnectionType::multicast;
            plan->t_to_o.rpi = listener.t_to_o.rpi;
            plan->route = settings_.route;
            return *plan;
        }
        return std::nullopt;
    }

    void open_connections() {
        for (const auto& connection : sheet_.connections) {
            auto plan = plan_of(sheet_, connection);
            if (!plan) continue;
            plan->route = settings_.route;
            const bool listens = connection.transport.is(eds::Ownership::listen_only);
            const auto result = try_open(host_, settings_.timeout, *plan, listens ? companion_of(*plan) : std::nullopt);
            const auto subject = subject_of(connection) + ", opened";
            if (result.well) {
                comparisons_.push_back({Group::connection, subject, Agreement::equal, {}});
                continue;
            }
            comparisons_.push_back({Group::connection, subject, Agreement::different,
                                    result.closed ? failure_of(*result.closed, host_, settings_.timeout).text
                                                  : "it opened, and no datagram came"});
        }
    }

    const Settings& settings_;
    const Host host_;
    const eds::DataSheet& sheet_;
    cip::ByteView file_;
    std::map<std::uint32_t, AssemblySize> sizes_;
    Comparisons comparisons_;
};

std::size_t count(const Comparisons& all, std::optional<Group> group, std::optional<Agreement> agreement = {}) {
    return static_cast<std::size_t>(std::ranges::count_if(all, [&](const Comparison& each) {
        return (!group || each.group == *group) && (!agreement || each.agreement == *agreement);
    }));
}

std::string plural(Group group, std::size_t number) {
    if (group == Group::identity) return fmt::format("{} of the identity", number);
    const auto word = group == Group::assembly && number != 1 ? "assemblie" : std::string(name(group));
    return fmt::format("{} {}{}", number, word, number == 1 ? "" : "s");
}

std::string text_of(const Comparisons& all) {
    std::string text;
    for (const auto& each : all) {
        if (each.agreement == Agreement::equal) continue;
        text +=
            printable(fmt::format("{}{}: {}", each.agreement == Agreement::different ? "DIFFERENT  " : "not compared  ",
                                  each.subject, each.words)) +
            '\n';
    }
    std::vector<std::string> counted;
    for (const auto group : groups) {
        if (const auto number = count(all, group); number > 0) counted.push_back(plural(group, number));
    }
    text += fmt::format("{} checked: {}\n", all.size(), fmt::join(counted, ", "));
    return text + fmt::format("{} equal, {} different, {} not compared\n", count(all, {}, Agreement::equal),
                              count(all, {}, Agreement::different), count(all, {}, Agreement::not_compared));
}

Json counts_json(const Comparisons& all, std::optional<Group> group) {
    return {{"checked", count(all, group)},
            {"equal", count(all, group, Agreement::equal)},
            {"different", count(all, group, Agreement::different)},
            {"not_compared", count(all, group, Agreement::not_compared)}};
}

std::string json_of(const EdsCheckArguments& arguments, const Comparisons& all, const Ending& failure) {
    Json json{{"host", arguments.host}, {"file", arguments.file}, {"counts", counts_json(all, {})}};
    for (const auto group : groups) json["groups"][std::string(name(group))] = counts_json(all, group);
    json["findings"] = Json::array();
    for (const auto& each : all) {
        if (each.agreement == Agreement::equal) continue;
        json["findings"].push_back({{"group", std::string(name(each.group))},
                                    {"subject", printable(each.subject)},
                                    {"agreement", std::string(name(each.agreement))},
                                    {"text", printable(each.words)}});
    }
    if (failure) {
        json["error"] = {{"kind", std::string(row_of(failure->code).kind)},
                         {"text", failure->text},
                         {"exit_code", static_cast<int>(failure->code)}};
    }
    return document(json);
}

}  // namespace

ExitCode eds_check(const Console& console, const Settings& settings, const EdsCheckArguments& arguments) {
    const auto host = parse_host(arguments.host);
    if (!host) return fail(console, host.error());
    const auto text = read_sheet_file(arguments.file);
    if (!text) return fail(console, text.error(), arguments.host);
    const auto sheet = load_sheet(arguments.file);
    if (!sheet) return fail(console, sheet.error(), arguments.host);
    const cip::Bytes octets(text->begin(), text->end());
    Check check(settings, *host, **sheet, octets);
    const auto failure = check.run(arguments.open);
    const auto& all = check.comparisons();
    console.show(text_of(all), console.json ? json_of(arguments, all, failure) : std::string());
    if (failure) {
        console.say(failure->text);
        return failure->code;
    }
    const auto different = count(all, {}, Agreement::different);
    if (different == 0) return ExitCode::done;
    console.say(fmt::format("{} is not what {} says: {} of {} differ", to_string(*host), arguments.file, different,
                            all.size()));
    return ExitCode::refused;
}

}  // namespace servobus::scanner::cli
