// Puts a data sheet's text together: sections, entries, strings that are split, comments at one column.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace servobus::eds {

/// In quotes, with escapes; a long one as adjacent strings of whole words, each in a line of its own.
[[nodiscard]] std::string quoted(std::string_view text);
/// The same without words: cut at every 60th character.
[[nodiscard]] std::string quoted_block(std::string_view text);

class SheetText {
public:
    /// `$ text`, from the margin.
    void comment(std::string_view text);
    void section(std::string_view name);
    /// `Keyword = fields;` in one line. `fields` is written as it is, here and below.
    void entry(std::string_view keyword, std::string_view fields, std::string_view comment = {});
    /// `Keyword =`, followed by field lines of which the last one closes the entry.
    void open(std::string_view keyword, std::string_view comment = {});
    void fields(std::string_view fields, std::string_view comment = {});
    /// A comment behind the fields, in a line without any.
    void remark(std::string_view comment);
    void close(std::string_view fields, std::string_view comment = {});

    [[nodiscard]] std::string take() { return std::move(text_); }

private:
    void line(std::string_view content, std::size_t indent, std::string_view comment);

    std::string text_{};
};

}  // namespace servobus::eds
