// Data to one stream, messages to the other.
#pragma once

#include <atomic>
#include <istream>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "scanner/cli/link.hpp"
#include "scanner/cli/results.hpp"

namespace servobus::scanner::cli {

struct Console {
    std::ostream& out;
    std::ostream& err;
    bool json = false;
    bool terminal = false;                            ///< `err` is one: a line may be written over
    const std::atomic<int>* interruptions = nullptr;  ///< counts in place of Ctrl-C, for tests
    std::istream* person = nullptr;                   ///< who answers questions; nullptr: nobody is there

    /// A line, or several, each with the program's name in front.
    void say(std::string_view message) const;
    /// The data of a verb, in the form that was asked for.
    void show(const std::string& text, const std::string& document) const { out << (json ? document : text); }
};

/// Says why, and in JSON mode also prints a document that says so.
ExitCode fail(const Console& console, const Failure& failure, const std::string& host = {});
ExitCode fail(const Console& console, const Mistake& mistake, const std::string& host = {});

/// What `get` and `set` print: values to `out`, refusals to `err`.
ExitCode report(const Console& console, const std::string& host, const std::vector<Outcome>& outcomes,
                const std::optional<Failure>& failure);

}  // namespace servobus::scanner::cli
