#include "scanner/cli/completion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "scanner/cli/io_options.hpp"

namespace servobus::scanner::cli {
namespace {

// The scripts ask the program itself for names, so they do not age. @VERBS@ and the like are filled in.

constexpr std::string_view bash_script = R"sh(# bash completion for servobus-scanner.
# Load it with: source <(servobus-scanner completion bash)
_servobus_scanner() {
    local program=${COMP_WORDS[0]} current=${COMP_WORDS[COMP_CWORD]} verb= at=0 i
    COMPREPLY=()
    for ((i = 1; i < COMP_CWORD; i++)); do
        case ${COMP_WORDS[i]} in
            @VERB_PATTERN@) verb=${COMP_WORDS[i]} at=$i; break ;;
        esac
    done
    local words= sub=
    if [[ $verb == axis ]]; then
        for ((i = at + 2; i < COMP_CWORD; i++)); do
            case ${COMP_WORDS[i]} in
                @AXIS_PATTERN@) sub=${COMP_WORDS[i]} ;;
            esac
        done
    elif [[ $verb == eds ]] && ((COMP_CWORD > at + 1)); then
        sub=${COMP_WORDS[at + 1]}
    fi
    if [[ ${COMP_WORDS[COMP_CWORD - 1]} == -@(o|-trace|-out|-output|-csv|-pcapng|-eds) ]]; then
        mapfile -t COMPREPLY < <(compgen -f -- "$current")
        return
    elif [[ ${COMP_WORDS[COMP_CWORD - 1]} == --connection ]]; then
        words="@CONNECTIONS@"
    elif [[ $current == -* ]]; then
        case "$verb${sub:+ $sub}" in
@OPTION_CASES@
            *) words="@COMMON_OPTIONS@" ;;
        esac
    elif [[ -z $verb ]]; then
        words="@VERBS@"
    elif [[ $verb == completion ]]; then
        words="bash zsh fish"
    elif [[ $verb == eds && -z $sub ]]; then
        words="@EDS_VERBS@"
    elif [[ $sub == @(lint|show) || $sub == check && $COMP_CWORD -gt $((at + 2)) ]]; then
        mapfile -t COMPREPLY < <(compgen -f -- "$current")
        return
    elif [[ $verb != eds ]] && ((COMP_CWORD > at + 1)); then
        case $verb in
            get | set | call) words=$("$program" list --names 2>/dev/null) ;;
            command) words=$("$program" list --names --commands 2>/dev/null) ;;
            axis)
                case $sub in
                    '') words="@AXIS_VERBS@" ;;
                    jog) words="positive negative" ;;
                    trace) words="@TRACED_VERBS@" ;;
                esac ;;
        esac
        if [[ $verb == set ]]; then
            compopt -o nospace
            mapfile -t COMPREPLY < <(compgen -S = -W "$words" -- "$current")
            return
        fi
    elif [[ $verb == list ]]; then
        words=$("$program" list --names 2>/dev/null)
    elif [[ $verb != discover ]]; then
        mapfile -t COMPREPLY < <(compgen -A hostname -- "$current")
        return
    fi
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
}
complete -F _servobus_scanner servobus-scanner
)sh";

constexpr std::string_view zsh_script = R"sh(#compdef servobus-scanner
# zsh completion for servobus-scanner.
# Load it with: source <(servobus-scanner completion zsh)
_servobus_scanner() {
    local -a verbs axis_verbs eds_verbs names
    local verb= sub= at=0 i
    verbs=(
@VERB_LINES@
    )
    axis_verbs=(
@AXIS_LINES@
    )
    eds_verbs=(
@EDS_LINES@
    )
    for ((i = 2; i < CURRENT; i++)); do
        case $words[i] in
            @VERB_PATTERN@) verb=$words[i]; at=$i; break ;;
        esac
    done
    if [[ $verb == axis ]]; then
        for ((i = at + 2; i < CURRENT; i++)); do
            case $words[i] in
                @AXIS_PATTERN@) sub=$words[i] ;;
            esac
        done
    elif [[ $verb == eds ]] && ((CURRENT > at + 1)); then
        sub=$words[at + 1]
    fi
    if [[ $words[CURRENT - 1] == (-o|--trace|--out|--output|--csv|--pcapng|--eds) ]]; then
        _files
    elif [[ $words[CURRENT - 1] == --connection ]]; then
        compadd -- @CONNECTIONS@
    elif [[ $PREFIX == -* ]]; then
        case "$verb${sub:+ $sub}" in
@OPTION_CASES@
            *) compadd -- @COMMON_OPTIONS@ ;;
        esac
    elif [[ -z $verb ]]; then
        _describe verb verbs
    elif [[ $verb == completion ]]; then
        compadd -- bash zsh fish
    elif [[ $verb == eds && -z $sub ]]; then
        _describe verb eds_verbs
    elif [[ $sub == (lint|show) ]] || [[ $sub == check ]] && ((CURRENT > at + 2)); then
        _files
    elif [[ $verb == eds ]]; then
        _hosts
    elif [[ $verb == list ]] || ((CURRENT > at + 1)); then
        case $verb in
            get | call | list) names=(${(f)"$($words[1] list --names 2>/dev/null)"}); compadd -a names ;;
            set) names=(${(f)"$($words[1] list --names 2>/dev/null)"}); compadd -S = -a names ;;
            command) names=(${(f)"$($words[1] list --names --commands 2>/dev/null)"}); compadd -a names ;;
            axis)
                case $sub in
                    '') _describe verb axis_verbs ;;
                    jog) compadd -- positive negative ;;
                    trace) compadd -- @TRACED_VERBS@ ;;
                esac ;;
        esac
    else
        _hosts
    fi
}
if [[ $funcstack[1] == _servobus_scanner ]]; then
    _servobus_scanner "$@"
else
    compdef _servobus_scanner servobus-scanner
fi
)sh";

constexpr std::string_view fish_script = R"sh(# fish completion for servobus-scanner.
# Load it with: servobus-scanner completion fish | source
complete -c servobus-scanner -f
@FISH_LINES@complete -c servobus-scanner -n '__fish_seen_subcommand_from completion' -a 'bash zsh fish'
complete -c servobus-scanner -n '__fish_seen_subcommand_from get call list' -a '(servobus-scanner list --names)'
complete -c servobus-scanner -n '__fish_seen_subcommand_from set' -a '(servobus-scanner list --names)='
complete -c servobus-scanner -n '__fish_seen_subcommand_from command' -a '(servobus-scanner list --names --commands)'
complete -c servobus-scanner -n '__fish_seen_subcommand_from identity dump io open' -a '(__fish_print_hostnames)'
complete -c servobus-scanner -n '__fish_seen_subcommand_from jog' -a 'positive negative'
complete -c servobus-scanner -n '__fish_seen_subcommand_from lint show check' -F
complete -c servobus-scanner -n '__fish_seen_subcommand_from upload check' -a '(__fish_print_hostnames)'
)sh";

std::string replaced(std::string text, std::string_view mark, std::string_view with) {
    for (auto at = text.find(mark); at != std::string::npos; at = text.find(mark, at + with.size())) {
        text.replace(at, mark.size(), with);
    }
    return text;
}

std::vector<std::string> names(const std::vector<VerbInfo>& verbs) {
    std::vector<std::string> list;
    list.reserve(verbs.size());
    for (const auto& verb : verbs) list.push_back(verb.name);
    return list;
}

/// Options that every verb has which has any.
std::vector<std::string> common_options() {
    return {"--help", "--version", "--json", "--timeout", "--route", "--connected"};
}

/// `axis move` is `axis\ move` in a pattern.
std::string option_cases(const std::vector<VerbInfo>& verbs, std::string_view format, const std::string& prefix = {}) {
    std::vector<std::string> cases;
    for (const auto& verb : verbs) {
        const auto name = prefix + verb.name;
        cases.push_back(fmt::format(fmt::runtime(format), name, fmt::join(verb.options, " ")));
        if (!verb.verbs.empty() && prefix.empty()) cases.push_back(option_cases(verb.verbs, format, name + "\\ "));
    }
    return fmt::format("{}", fmt::join(cases, "\n"));
}

std::string fish_lines(const std::vector<VerbInfo>& verbs, const std::string& condition = "__fish_use_subcommand",
                       const std::string& prefix = {}) {
    std::string text;
    for (const auto& verb : verbs) {
        const auto seen = fmt::format("{}__fish_seen_subcommand_from {}", prefix, verb.name);
        text +=
            fmt::format("complete -c servobus-scanner -n '{}' -a {} -d '{}'\n", condition, verb.name, verb.description);
        for (const auto& option : verb.options) {
            text += fmt::format("complete -c servobus-scanner -n '{}' -l {}\n", seen, option.substr(2));
        }
        if (verb.verbs.empty() || !prefix.empty()) continue;
        const auto none =
            fmt::format("{}; and not __fish_seen_subcommand_from {}", seen, fmt::join(names(verb.verbs), " "));
        text += fish_lines(verb.verbs, none, seen + "; and ");
    }
    return text;
}

/// The verbs of a verb.
std::vector<VerbInfo> verbs_of(const std::vector<VerbInfo>& verbs, std::string_view name) {
    const auto verb = std::ranges::find(verbs, name, &VerbInfo::name);
    return verb == verbs.end() ? std::vector<VerbInfo>() : verb->verbs;
}

std::string zsh_verb_lines(const std::vector<VerbInfo>& verbs) {
    std::vector<std::string> lines;
    lines.reserve(verbs.size());
    for (const auto& verb : verbs) lines.push_back(fmt::format("        '{}:{}'", verb.name, verb.description));
    return fmt::format("{}", fmt::join(lines, "\n"));
}

}  // namespace

std::optional<std::string> completion_script(std::string_view shell, const std::vector<VerbInfo>& verbs) {
    std::string script;
    if (shell == "bash") {
        script = replaced(std::string(bash_script), "@OPTION_CASES@",
                          option_cases(verbs, "            {}) words=\"{}\" ;;"));
    } else if (shell == "zsh") {
        script = replaced(std::string(zsh_script), "@OPTION_CASES@",
                          option_cases(verbs, "            {}) compadd -- {} ;;"));
        script = replaced(std::move(script), "@VERB_LINES@", zsh_verb_lines(verbs));
        script = replaced(std::move(script), "@AXIS_LINES@", zsh_verb_lines(verbs_of(verbs, "axis")));
        script = replaced(std::move(script), "@EDS_LINES@", zsh_verb_lines(verbs_of(verbs, "eds")));
    } else if (shell == "fish") {
        return replaced(std::string(fish_script), "@FISH_LINES@", fish_lines(verbs));
    } else {
        return std::nullopt;
    }
    script = replaced(std::move(script), "@CONNECTIONS@", replaced(connection_keys(), ",", ""));
    const auto axis = verbs_of(verbs, "axis");
    const auto traced = names(verbs_of(axis, "trace"));
    script = replaced(std::move(script), "@AXIS_PATTERN@", fmt::format("{}", fmt::join(names(axis), " | ")));
    script = replaced(std::move(script), "@AXIS_VERBS@", fmt::format("{}", fmt::join(names(axis), " ")));
    script =
        replaced(std::move(script), "@EDS_VERBS@", fmt::format("{}", fmt::join(names(verbs_of(verbs, "eds")), " ")));
    script = replaced(std::move(script), "@TRACED_VERBS@", fmt::format("{}", fmt::join(traced, " ")));
    script = replaced(std::move(script), "@VERBS@", fmt::format("{}", fmt::join(names(verbs), " ")));
    script = replaced(std::move(script), "@VERB_PATTERN@", fmt::format("{}", fmt::join(names(verbs), " | ")));
    return replaced(std::move(script), "@COMMON_OPTIONS@", fmt::format("{}", fmt::join(common_options(), " ")));
}

}  // namespace servobus::scanner::cli
