// What a run of the conformance suite found, for people and for programs.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "scanner/conformance/suite.hpp"

namespace servobus::scanner::cli {

using ConformanceCases = std::span<const conformance::Case* const>;

// For people.

/// What is told before the first case.
[[nodiscard]] std::string conformance_head(const std::string& host, const conformance::Subject& subject);
/// The heading of a group.
[[nodiscard]] std::string conformance_group(conformance::Group group);
/// A line for a case; what is behind a failure or an advisory, and with `verbose` behind all else, in more lines.
[[nodiscard]] std::string conformance_result(const conformance::Result& result, bool verbose);
/// How many of what.
[[nodiscard]] std::string conformance_summary(const conformance::Report& report);
/// The cases themselves, by groups.
[[nodiscard]] std::string conformance_list(ConformanceCases cases);

// For programs.

[[nodiscard]] std::string conformance_json(const std::string& host, const conformance::Subject& subject,
                                           const conformance::Report& report);
[[nodiscard]] std::string conformance_list_json(ConformanceCases cases);
[[nodiscard]] std::string conformance_junit(const std::string& host, const conformance::Report& report);

}  // namespace servobus::scanner::cli
