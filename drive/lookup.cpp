#include "drive/lookup.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <system_error>
#include <utility>

#include "drive/text.hpp"

namespace servobus::drive {

namespace {

/// Letters and digits only, in lower case: what people mean when they type a name.
std::string fold(std::string_view text) {
    std::string folded;
    for (const char c : text) {
        if (c >= 'A' && c <= 'Z') {
            folded += static_cast<char>(c - 'A' + 'a');
        } else if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9')) {
            folded += c;
        }
    }
    return folded;
}

/// What was typed, taken apart: `0x66.AC` asks for `ac` in class 0x66.
struct Query {
    std::optional<std::uint16_t> class_id;
    std::string word;
};

std::optional<std::uint16_t> class_named(std::span<const ParameterClass> classes, std::string_view prefix) {
    if (const auto number = parse_number(prefix); number && *number >= 0 && *number <= highest(Type::u16)) {
        return static_cast<std::uint16_t>(*number);
    }
    const auto found =
        std::ranges::find(classes, fold(prefix), [](const ParameterClass& each) { return fold(each.prefix); });
    return found == classes.end() ? std::nullopt : std::optional(found->class_id);
}

/// A dot that follows no class belongs to the name.
Query read_query(std::span<const ParameterClass> classes, std::string_view what) {
    if (const auto dot = what.find('.'); dot != std::string_view::npos) {
        if (const auto class_id = class_named(classes, what.substr(0, dot))) {
            return {class_id, fold(what.substr(dot + 1))};
        }
    }
    return {std::nullopt, fold(what)};
}

bool in_class(const Query& query, const Parameter& row) {
    return !query.class_id || *query.class_id == row.cip.class_id;
}

template <typename Named>
bool has_name(const Named& named, const std::string& word) {
    return fold(named.name) == word || (!named.mnemonic.empty() && fold(named.mnemonic) + fold(named.name) == word);
}

template <typename Named>
bool has_mnemonic(const Named& named, const std::string& word) {
    return !named.mnemonic.empty() && fold(named.mnemonic) == word;
}

/// Drops each second address whose owner is an answer as well.
void keep_owners(std::vector<const Parameter*>& rows) {
    const auto all = rows;
    std::erase_if(rows, [&all](const Parameter* row) {
        return row->same_as && std::ranges::find(all, *row->same_as, &Parameter::key) != all.end();
    });
}

template <typename Predicate>
std::vector<const Parameter*> matching(std::span<const Parameter> table, Predicate matches) {
    std::vector<const Parameter*> rows;
    for (const Parameter& row : table) {
        if (matches(row)) {
            rows.push_back(&row);
        }
    }
    keep_owners(rows);
    return rows;
}

/// Insertions, deletions and replacements that turn `word` into the first n letters of `text`, for each n. With
/// `anywhere`, into the most similar run of letters that ends there.
std::vector<std::size_t> edits(std::string_view word, std::string_view text, bool anywhere) {
    std::vector<std::size_t> costs(text.size() + 1, 0);
    for (std::size_t t = 0; t <= text.size() && !anywhere; ++t) {
        costs[t] = t;
    }
    for (std::size_t w = 0; w < word.size(); ++w) {
        std::size_t diagonal = std::exchange(costs[0], w + 1);
        for (std::size_t t = 0; t < text.size(); ++t) {
            const std::size_t replaced = diagonal + (word[w] == text[t] ? 0 : 1);
            diagonal = costs[t + 1];
            costs[t + 1] = std::min({replaced, costs[t] + 1, diagonal + 1});
        }
    }
    return costs;
}

/// How far a typed word is from a spelling. The beginning of a long spelling is nearly as good as all of it, and any
/// other part comes next.
std::size_t distance(std::string_view word, std::string_view spelling) {
    constexpr std::size_t shortest_part = 4;
    const auto from_start = edits(word, spelling, false);
    if (word.size() < shortest_part) {
        return from_start.back();
    }
    const auto anywhere = edits(word, spelling, true);
    return std::min(
        {from_start.back(), *std::ranges::min_element(from_start) + 1, *std::ranges::min_element(anywhere) + 2});
}

/// One mistake in three letters is still a likeness.
std::size_t likeness_limit(const std::string& word) { return std::max<std::size_t>(1, word.size() / 3); }

template <typename Named>
std::size_t distance_to(const Named& named, const std::string& word) {
    std::size_t best = distance(word, fold(named.name));
    if (!named.mnemonic.empty()) {
        best = std::min(best, edits(word, fold(named.mnemonic), false).back());
    }
    return best;
}

template <typename Named>
struct Candidate {
    std::size_t distance;
    const Named* named;
};

/// The likely ones, most likely first; equals keep the order of the table.
template <typename Named, typename Predicate>
std::vector<Candidate<Named>> likely(std::span<const Named> table, const std::string& word, Predicate considered) {
    std::vector<Candidate<Named>> candidates;
    for (const Named& named : table) {
        if (!considered(named)) {
            continue;
        }
        if (const std::size_t cost = distance_to(named, word); cost <= likeness_limit(word)) {
            candidates.push_back({cost, &named});
        }
    }
    std::ranges::stable_sort(candidates, {}, &Candidate<Named>::distance);
    return candidates;
}

std::string hex(std::uint16_t number) {
    std::array<char, 4> digits{};
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number, 16);
    return error == std::errc{} ? "0x" + std::string(digits.data(), end) : std::string();
}

void add_once(std::vector<std::string>& names, std::string name) {
    if (std::ranges::find(names, name) == names.end()) {
        names.push_back(std::move(name));
    }
}

}  // namespace

std::vector<const Parameter*> find_by_name(std::span<const Parameter> table, std::span<const ParameterClass> classes,
                                           std::string_view what) {
    const Query query = read_query(classes, what);
    if (query.word.empty()) {
        return {};
    }
    auto rows =
        matching(table, [&query](const Parameter& row) { return in_class(query, row) && has_name(row, query.word); });
    if (!rows.empty()) {
        return rows;
    }
    return matching(table,
                    [&query](const Parameter& row) { return in_class(query, row) && has_mnemonic(row, query.word); });
}

std::vector<std::string> nearest_names(std::span<const Parameter> table, std::span<const ParameterClass> classes,
                                       std::string_view what, std::size_t count) {
    const Query query = read_query(classes, what);
    if (query.word.empty()) {
        return {};
    }
    std::vector<std::string> names;
    for (const auto& candidate :
         likely(table, query.word, [&query](const Parameter& row) { return in_class(query, row); })) {
        if (names.size() == count) {
            break;
        }
        const Parameter& row = *candidate.named;
        const bool plain = !query.class_id && find_by_name(table, classes, row.name).size() == 1;
        add_once(names, plain ? std::string(row.name) : qualified_name(classes, row));
    }
    return names;
}

std::string qualified_name(std::span<const ParameterClass> classes, const Parameter& row) {
    const auto found = std::ranges::find(classes, row.cip.class_id, &ParameterClass::class_id);
    const std::string prefix = found == classes.end() ? hex(row.cip.class_id) : std::string(found->prefix);
    return prefix + "." + std::string(row.name);
}

const DirectCommand* find_command(std::span<const DirectCommand> commands, std::string_view what) {
    const std::string word = fold(what);
    const auto number = parse_number(what);
    const auto found = std::ranges::find_if(commands, [&](const DirectCommand& command) {
        return number == command.value || (!word.empty() && (has_name(command, word) || has_mnemonic(command, word)));
    });
    return found == commands.end() ? nullptr : &*found;
}

std::vector<std::string> nearest_commands(std::span<const DirectCommand> commands, std::string_view what,
                                          std::size_t count) {
    const std::string word = fold(what);
    if (word.empty()) {
        return {};
    }
    std::vector<std::string> names;
    for (const auto& candidate : likely(commands, word, [](const DirectCommand&) { return true; })) {
        if (names.size() == count) {
            break;
        }
        const DirectCommand& command = *candidate.named;
        add_once(names, std::string(command.mnemonic.empty() ? command.name : command.mnemonic));
    }
    return names;
}

}  // namespace servobus::drive
