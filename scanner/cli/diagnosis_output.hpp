// The doctor's findings for people and for programs; `doctor`, `open` and `io` print the same.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "scanner/open_doctor.hpp"

namespace servobus::scanner::cli {

/// Lines, each with `indent` blanks in front: what was asked, what is so, likely causes, what to do, and the corrected
/// command line for `host`.
[[nodiscard]] std::string diagnosis_text(const Diagnosis& diagnosis, const std::string& host, std::size_t indent = 0);

/// `well`, `may_pass`, `summary`, `asked`, `findings`, `causes`, `next`, `corrected`: null, or `command` and `arguments`.
[[nodiscard]] nlohmann::ordered_json diagnosis_json(const Diagnosis& diagnosis, const std::string& host);

}  // namespace servobus::scanner::cli
