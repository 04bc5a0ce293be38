// Runs cases against a device, one after the other; those that only wait do so side by side.
#pragma once

#include <chrono>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case.hpp"
#include "scanner/conformance/record.hpp"
#include "scanner/conformance/subject.hpp"

namespace servobus::scanner::conformance {

struct Result {
    const Case* which = nullptr;
    Outcome outcome = Outcome::skipped;
    std::string reason{};             ///< why it was skipped
    std::vector<Finding> findings{};  ///< what is held against the device
    Record record{};
    std::chrono::milliseconds took{};
};

struct Report {
    std::vector<Result> results{};  ///< one for each case that was chosen, in their order
    std::chrono::milliseconds took{};
    bool interrupted = false;
    bool lost = false;  ///< the device has stopped answering, and the rest was skipped

    [[nodiscard]] std::size_t count(Outcome outcome) const;
};

/// Called as soon as the outcome of a case is known: in the order of the cases within a group.
using Progress = std::function<void(const Result&)>;
/// Asked between two cases.
using Interrupted = std::function<bool()>;

[[nodiscard]] Report run_cases(Subject& subject, std::span<const Case* const> cases, const Progress& progress,
                               const Interrupted& interrupted);

/// Asks the device who it is, over TCP. Why that fails, in words without a full stop; empty: the subject knows now.
[[nodiscard]] std::string get_acquainted(Subject& subject);

}  // namespace servobus::scanner::conformance
