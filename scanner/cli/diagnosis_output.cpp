#include "scanner/cli/diagnosis_output.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "scanner/plan_arguments.hpp"

namespace servobus::scanner::cli {

std::string diagnosis_text(const Diagnosis& diagnosis, const std::string& host, std::size_t indent) {
    std::string text;
    const auto line = [&](std::size_t depth, std::string_view words) {
        text += fmt::format("{:{}}{}\n", "", indent + depth, words);
    };
    const auto list = [&](std::string_view title, const std::vector<std::string>& entries, bool numbered) {
        if (entries.empty()) return;
        line(0, title);
        for (std::size_t i = 0; i < entries.size(); ++i) {
            line(2, numbered && entries.size() > 1 ? fmt::format("{}. {}", i + 1, entries[i]) : entries[i]);
        }
    };
    line(0, diagnosis.summary);
    list("asked", diagnosis.asked, false);
    list("findings", diagnosis.findings, false);
    list(diagnosis.causes.size() > 1 ? "likely causes" : "likely cause", diagnosis.causes, true);
    list("what to do", diagnosis.next, false);
    if (diagnosis.corrected) {
        line(0, "corrected");
        line(2, command_line(*diagnosis.corrected, host));
    }
    return text;
}

nlohmann::ordered_json diagnosis_json(const Diagnosis& diagnosis, const std::string& host) {
    nlohmann::ordered_json json{{"well", diagnosis.well},         {"may_pass", diagnosis.may_pass},
                                {"summary", diagnosis.summary},   {"asked", diagnosis.asked},
                                {"findings", diagnosis.findings}, {"causes", diagnosis.causes},
                                {"next", diagnosis.next}};
    json["corrected"] = nullptr;
    if (diagnosis.corrected) {
        json["corrected"] = {{"command", command_line(*diagnosis.corrected, host)},
                             {"arguments", plan_arguments(*diagnosis.corrected, host)}};
    }
    return json;
}

}  // namespace servobus::scanner::cli
