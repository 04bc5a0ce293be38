#include "scanner/cli/console.hpp"

#include "scanner/cli/json_output.hpp"
#include "scanner/cli/text_output.hpp"

namespace servobus::scanner::cli {

void Console::say(std::string_view message) const {
    while (!message.empty()) {
        const auto end = message.find('\n');
        err << "servobus-scanner: " << message.substr(0, end) << '\n';
        message = end == std::string_view::npos ? std::string_view() : message.substr(end + 1);
    }
}

ExitCode fail(const Console& console, const Failure& failure, const std::string& host) {
    if (console.json) console.out << failure_json(host, failure);
    console.say(failure.text);
    return failure.code;
}

ExitCode fail(const Console& console, const Mistake& mistake, const std::string& host) {
    return fail(console, Failure{ExitCode::usage, mistake.text}, host);
}

ExitCode report(const Console& console, const std::string& host, const std::vector<Outcome>& outcomes,
                const std::optional<Failure>& failure) {
    std::string text;
    for (const auto& outcome : outcomes) text += value_text(outcome);
    console.show(text, console.json ? values_json(host, outcomes, failure) : std::string());
    for (const auto& outcome : outcomes) {
        console.say(warning_text(outcome));
        console.say(refusal_text(outcome));
    }
    if (failure) console.say(failure->text);
    return failure ? failure->code : exit_code_of(outcomes);
}

}  // namespace servobus::scanner::cli
