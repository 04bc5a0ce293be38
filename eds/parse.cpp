#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <unordered_map>
#include <utility>

#include "eds/document.hpp"

namespace servobus::eds {
namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
constexpr std::string_view line_ends = "\r\n";

// The text as characters, with the number of the line that the next one is in. CR, LF and CR LF end a line. Nothing here
// looks further than it reads, so that a text costs what its length is, however it is written.
class Cursor {
public:
    struct Place {
        std::size_t at = 0;
        std::size_t line = 1;
    };

    explicit Cursor(std::string_view text) : text_(text) {}

    [[nodiscard]] bool at_end() const { return place_.at >= text_.size(); }
    [[nodiscard]] char peek() const { return text_[place_.at]; }
    [[nodiscard]] bool sees(char c) const { return !at_end() && peek() == c; }
    [[nodiscard]] std::string_view rest() const { return text_.substr(place_.at); }
    [[nodiscard]] std::size_t line() const { return place_.line; }
    [[nodiscard]] Place place() const { return place_; }
    void back_to(Place place) { place_ = place; }

    [[nodiscard]] bool first_in_line() const {
        auto at = place_.at;
        while (at > 0 && is_blank(text_[at - 1]) && line_ends.find(text_[at - 1]) == std::string_view::npos) --at;
        return at == 0 || is_blank(text_[at - 1]);
    }

    void skip() {
        const char c = text_[place_.at++];
        if (c == '\n' || (c == '\r' && !sees('\n'))) ++place_.line;
    }

    /// Within the line.
    std::string_view take(std::size_t count) {
        const auto taken = text_.substr(place_.at, count);
        place_.at += count;
        return taken;
    }
    /// What stands before the first of `stops`, which ends of lines belong to.
    std::string_view take_until(std::string_view stops) {
        return take(std::min(rest().find_first_of(stops), rest().size()));
    }

    /// Past blanks, ends of lines and comments.
    void skip_blanks() {
        while (!at_end() && (is_blank(peek()) || peek() == '$')) {
            if (peek() == '$') {
                take_until(line_ends);
            } else {
                skip();
            }
        }
    }

private:
    std::string_view text_;
    Place place_{};
};

// The string literal that `text` begins with, without its quotes. A backslash keeps the quote behind it from ending the
// string, except where no other quote of the line does.
struct Literal {
    std::size_t octets = 0;
    bool closed = false;
};

Literal literal(std::string_view text) {
    std::optional<std::size_t> escaped;
    std::size_t end = 0;
    for (; end < text.size() && line_ends.find(text[end]) == std::string_view::npos; ++end) {
        if (text[end] == '"') return {end, true};
        const auto pair = text.substr(end, 2);
        if (pair == "\\\"") escaped = end + 1;
        if (pair == "\\\"" || pair == "\\\\") ++end;
    }
    if (escaped) return {*escaped, true};
    text = text.substr(0, end);
    text = text.substr(0, text.find('$'));
    const auto last = text.find_last_not_of(" \t,;");
    return {last == std::string_view::npos ? 0 : last + 1, false};
}

// Known escapes as the character they stand for; a backslash before anything else is one, as in `C:\icons`.
std::string unescaped(std::string_view text) {
    std::string result;
    result.reserve(text.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
        constexpr std::string_view escapes = "\\\"'nt";
        constexpr std::string_view meanings = "\\\"'\n\t";
        const auto which = text[i] == '\\' && i + 1 < text.size() ? escapes.find(text[i + 1]) : std::string_view::npos;
        if (which == std::string_view::npos) {
            result.push_back(text[i]);
        } else {
            result.push_back(meanings[which]);
            ++i;
        }
    }
    return result;
}

class Parser {
public:
    explicit Parser(std::string_view text) : cursor_(text) {}

    boost::system::result<Document, Finding> run() {
        cursor_.skip_blanks();
        while (!cursor_.at_end() && !refusal_) {
            if (cursor_.peek() == '[') {
                read_section();
            } else {
                read_entry();
            }
            cursor_.skip_blanks();
        }
        if (refusal_) return *refusal_;
        if (document_.sections.empty()) return Finding{0, Severity::error, "there is no [section] in it"};
        return std::move(document_);
    }

private:
    void warn(std::size_t line, std::string words) {
        auto& warnings = document_.warnings;
        if (warnings.size() < max_findings) {
            warnings.push_back({line, Severity::warning, std::move(words)});
        } else if (warnings.size() == max_findings) {
            warnings.push_back({line, Severity::warning, "there are more warnings, from here on left out"});
        }
    }

    void refuse(std::string words) {
        if (!refusal_) refusal_ = Finding{cursor_.line(), Severity::error, std::move(words)};
    }

    void read_section() {
        const auto line = cursor_.line();
        cursor_.skip();
        const auto name = trimmed(cursor_.take_until("]$\r\n"));
        if (cursor_.sees(']')) {
            cursor_.skip();
        } else {
            warn(line, fmt::format("[{} has no closing bracket", shown(name)));
        }
        const auto [known, is_new] = section_of_name_.try_emplace(lower_case(name), document_.sections.size());
        section_ = known->second;
        if (!is_new) {
            return warn(line,
                        fmt::format("[{}] is already in line {}", shown(name), document_.sections[*section_].line));
        }
        if (document_.sections.size() == max_sections) {
            return refuse(fmt::format("there are more than {} sections", max_sections));
        }
        document_.sections.push_back({std::string(name), line, {}});
    }

    void read_entry() {
        Entry entry;
        entry.line = cursor_.line();
        entry.keyword = trimmed(cursor_.take_until("=;,\"[]$\r\n"));
        cursor_.skip_blanks();
        if (entry.keyword.empty() || !cursor_.sees('=')) return skip_no_entry(entry);
        cursor_.skip();
        read_fields(entry);
        keep(std::move(entry));
    }

    // To the semicolon in the same line, or to the next line.
    void skip_no_entry(const Entry& entry) {
        warn(entry.line, entry.keyword.empty()
                             ? "here should be a keyword"
                             : fmt::format("'{}' is no entry, since '=' does not follow", shown(entry.keyword)));
        if (cursor_.line() != entry.line) return;
        cursor_.take_until(";\r\n");
        if (cursor_.sees(';')) cursor_.skip();
    }

    void keep(Entry entry) {
        if (!section_) return warn(entry.line, fmt::format("{} is in no section", shown(entry.keyword)));
        if (++entries_ > max_entries) return refuse(fmt::format("there are more than {} entries", max_entries));
        document_.sections[*section_].entries.push_back(std::move(entry));
    }

    // Up to and with the semicolon, or as far as the entry goes when it has none.
    void read_fields(Entry& entry) {
        Field field;
        bool goes_on = true;
        while (goes_on && !refusal_) {
            cursor_.skip_blanks();
            if (field.is_empty()) field.line = cursor_.line();
            if (cursor_.sees(',')) {
                cursor_.skip();
                add(entry, std::exchange(field, {}));
            } else if (cursor_.sees('"')) {
                read_string(entry, field);
            } else {
                goes_on = !cursor_.at_end() && !cursor_.sees(';') && !begins_a_section() && read_word(entry, field);
            }
        }
        if (cursor_.sees(';')) {
            cursor_.skip();
        } else {
            warn(entry.line, fmt::format("{} has no semicolon at its end", shown(entry.keyword)));
        }
        add(entry, std::move(field));
    }

    void add(Entry& entry, Field field) {
        if (entry.fields.size() == max_fields) {
            return refuse(fmt::format("{} has more than {} fields", shown(entry.keyword), max_fields));
        }
        if (++fields_ > max_all_fields) return refuse(fmt::format("there are more than {} fields", max_all_fields));
        entry.fields.push_back(std::move(field));
    }

    // A bracket elsewhere belongs to a path: `20 04 24 01 2C [Param6]`.
    [[nodiscard]] bool begins_a_section() const { return cursor_.sees('[') && cursor_.first_in_line(); }

    void read_string(const Entry& entry, Field& field) {
        const auto line = cursor_.line();
        cursor_.skip();
        const auto found = literal(cursor_.rest());
        if (field.kind == Field::Kind::word) {
            warn(line,
                 fmt::format("{} has a string behind '{}' without a comma", shown(entry.keyword), shown(field.value)));
        }
        field.kind = Field::Kind::text;
        field.value += unescaped(cursor_.take(found.octets));
        if (found.closed) {
            cursor_.skip();
        } else {
            warn(line, fmt::format("a string of {} is not closed in its line", shown(entry.keyword)));
        }
    }

    // False, with nothing read, when the word is the keyword of the next entry.
    bool read_word(const Entry& entry, Field& field) {
        const auto before = cursor_.place();
        const auto word = cursor_.take_until(" \t,;\"=$\r\n");
        if (word.empty()) {
            warn(before.line, fmt::format("{} has a '=' inside a field", shown(entry.keyword)));
            cursor_.skip();
            return true;
        }
        cursor_.skip_blanks();
        if (cursor_.sees('=')) {
            cursor_.back_to(before);
            return false;
        }
        if (field.kind == Field::Kind::text) {
            warn(before.line,
                 fmt::format("{} has '{}' behind a string without a comma", shown(entry.keyword), shown(word)));
        }
        if (!field.value.empty()) field.value.push_back(' ');
        field.value += word;
        if (field.is_empty()) field.kind = Field::Kind::word;
        return true;
    }

    Cursor cursor_;
    Document document_{};
    std::unordered_map<std::string, std::size_t> section_of_name_{};
    std::optional<std::size_t> section_{};  ///< index of the one that entries belong to
    std::size_t entries_ = 0;
    std::size_t fields_ = 0;
    std::optional<Finding> refusal_{};
};

std::optional<std::string> why_no_text(std::string_view octets) {
    if (octets.size() > max_octets) return fmt::format("it is larger than {} octets", max_octets);
    if (octets.starts_with("\xFF\xFE") || octets.starts_with("\xFE\xFF")) {
        return "it is UTF-16; a data sheet is ISO 8859-1";
    }
    if (octets.find('\0') != std::string_view::npos) return "it is no text: it has octets of value 0";
    return std::nullopt;
}

}  // namespace

boost::system::result<Document, Finding> parse(std::string_view octets) {
    if (auto why = why_no_text(octets)) return Finding{0, Severity::error, std::move(*why)};
    const bool marked = octets.starts_with(byte_order_mark);
    if (marked) octets.remove_prefix(byte_order_mark.size());
    auto document = Parser(octets).run();
    if (document && marked) {
        auto& warnings = document->warnings;
        warnings.insert(warnings.begin(), {1, Severity::warning, "the file begins with the mark of UTF-8"});
    }
    return document;
}

}  // namespace servobus::eds
