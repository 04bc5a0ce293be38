#include "eds/sheet_text.hpp"

#include <algorithm>

namespace servobus::eds {
namespace {

constexpr std::size_t longest_string = 60;
constexpr std::size_t entry_indent = 8;
constexpr std::size_t field_indent = 16;
constexpr std::size_t comment_column = 48;

std::string escaped(std::string_view text) {
    std::string result;
    for (const char c : text) {
        if (c == '"' || c == '\\') result.push_back('\\');
        result.push_back(c);
    }
    return result;
}

void append_piece(std::string& pieces, std::string_view piece) {
    if (!pieces.empty()) pieces.append("\n").append(field_indent, ' ');
    pieces.append("\"").append(escaped(piece)).append("\"");
}

}  // namespace

std::string quoted(std::string_view text) {
    std::string pieces;
    while (text.size() > longest_string) {
        const auto blank = text.substr(0, longest_string).rfind(' ');
        const auto length = blank == std::string_view::npos ? longest_string : blank + 1;
        append_piece(pieces, text.substr(0, length));
        text.remove_prefix(length);
    }
    append_piece(pieces, text);
    return pieces;
}

std::string quoted_block(std::string_view text) {
    std::string pieces;
    for (std::size_t at = 0; at < text.size(); at += longest_string)
        append_piece(pieces, text.substr(at, longest_string));
    return pieces;
}

void SheetText::line(std::string_view content, std::size_t indent, std::string_view comment) {
    text_.append(indent, ' ').append(content);
    if (!comment.empty()) {
        const auto begin = text_.rfind('\n') + 1;
        const auto width = text_.size() - begin;
        text_.append(width < comment_column ? comment_column - width : 1, ' ').append("$ ").append(comment);
    }
    text_.append("\n");
}

void SheetText::comment(std::string_view text) { text_.append(text.empty() ? "$" : "$ ").append(text).append("\n"); }

void SheetText::section(std::string_view name) { text_.append("\n[").append(name).append("]\n"); }

void SheetText::entry(std::string_view keyword, std::string_view fields, std::string_view comment) {
    line(std::string(keyword).append(" = ").append(fields).append(";"), entry_indent, comment);
}

void SheetText::open(std::string_view keyword, std::string_view comment) {
    line(std::string(keyword).append(" ="), entry_indent, comment);
}

void SheetText::fields(std::string_view fields, std::string_view comment) {
    line(std::string(fields).append(","), field_indent, comment);
}

void SheetText::remark(std::string_view comment) { line({}, 0, comment); }

void SheetText::close(std::string_view fields, std::string_view comment) {
    line(std::string(fields).append(";"), field_indent, comment);
}

}  // namespace servobus::eds
