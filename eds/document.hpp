// The text of a data sheet as sections, entries and fields, before anybody says what they mean (R-EDS-1).
#pragma once

#include <boost/system/result.hpp>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "eds/finding.hpp"

namespace servobus::eds {

// What a text may have at most; one more is refused, since no device's data sheet comes near.
inline constexpr std::size_t max_octets = std::size_t{8} * 1024 * 1024;
inline constexpr std::size_t max_sections = 4096;
inline constexpr std::size_t max_entries = 262'144;  ///< of all sections
inline constexpr std::size_t max_fields = 65'536;    ///< of one entry
inline constexpr std::size_t max_all_fields = 1'048'576;
/// Past this many findings about one text, the others are left out.
inline constexpr std::size_t max_findings = 1000;

/// What stands between two commas.
struct Field {
    enum class Kind : std::uint8_t {
        empty,  ///< the default, or not used
        word,   ///< a number, a date, a keyword, a reference: as written
        text,   ///< in double quotes: adjacent strings joined, escapes resolved, ISO 8859-1
    };

    Kind kind = Kind::empty;
    std::string value{};
    std::size_t line = 0;

    [[nodiscard]] bool is_empty() const { return kind == Kind::empty; }
    friend bool operator==(const Field&, const Field&) = default;
};

/// `Keyword = field, field;`. There is always one field, which may be empty.
struct Entry {
    std::string keyword{};
    std::size_t line = 0;
    std::vector<Field> fields{};

    /// Field `number` as the format counts them, from 1; an empty one where the entry is shorter.
    [[nodiscard]] const Field& field(std::size_t number) const;
    friend bool operator==(const Entry&, const Entry&) = default;
};

struct Section {
    std::string name{};
    std::size_t line = 0;
    std::vector<Entry> entries{};

    /// The first of that name, written so; otherwise the first that differs in case alone; or nullptr.
    [[nodiscard]] const Entry* find(std::string_view keyword) const;
    friend bool operator==(const Section&, const Section&) = default;
};

struct Document {
    std::vector<Section> sections{};  ///< in the order of the text; one that comes twice is continued in the first
    std::vector<Finding> warnings{};  ///< what was not written as the format asks, and could be read all the same

    /// As Section::find.
    [[nodiscard]] const Section* find(std::string_view section) const;
    /// The entry, or nullptr when it or its section is not there.
    [[nodiscard]] const Entry* find(std::string_view section, std::string_view keyword) const;
};

/// The text of anybody's data sheet. What is written badly is read as it was probably meant, with a warning: a missing
/// semicolon, bracket or quote, a section that comes twice. Refused is only what is no such text, or past a limit.
[[nodiscard]] boost::system::result<Document, Finding> parse(std::string_view octets);

/// As names compare when the case does not count (ASCII).
[[nodiscard]] bool same_name(std::string_view one, std::string_view other);
[[nodiscard]] std::string lower_case(std::string_view name);
/// Without blanks and control characters at its ends.
[[nodiscard]] std::string_view trimmed(std::string_view text);
/// A space, a control character, the end-of-file mark of old editors: whatever is no character of a line.
[[nodiscard]] bool is_blank(char c);

}  // namespace servobus::eds
