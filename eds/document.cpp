#include "eds/document.hpp"

#include <algorithm>

namespace servobus::eds {
namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

template <class List, class Name>
auto find_in(const List& list, std::string_view what, Name name) -> const typename List::value_type* {
    auto found = std::ranges::find(list, what, name);
    if (found == list.end()) {
        found = std::ranges::find_if(list, [&](const auto& each) { return same_name(each.*name, what); });
    }
    return found != list.end() ? &*found : nullptr;
}

}  // namespace

bool same_name(std::string_view one, std::string_view other) {
    return std::ranges::equal(one, other, {}, lower, lower);
}

std::string lower_case(std::string_view name) {
    std::string result(name);
    std::ranges::transform(result, result.begin(), lower);
    return result;
}

bool is_blank(char c) { return (c >= '\0' && c <= ' ') || c == '\x7F'; }

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    return text;
}

const Field& Entry::field(std::size_t number) const {
    static const Field none;
    return number >= 1 && number <= fields.size() ? fields[number - 1] : none;
}

const Entry* Section::find(std::string_view keyword) const { return find_in(entries, keyword, &Entry::keyword); }

const Section* Document::find(std::string_view section) const { return find_in(sections, section, &Section::name); }

const Entry* Document::find(std::string_view section, std::string_view keyword) const {
    const auto* found = find(section);
    return found != nullptr ? found->find(keyword) : nullptr;
}

}  // namespace servobus::eds
