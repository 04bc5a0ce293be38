#include "scanner/cli/table.hpp"

#include <algorithm>

namespace servobus::scanner::cli {
namespace {

/// Characters of a UTF-8 text.
std::size_t width(std::string_view text) {
    return static_cast<std::size_t>(
        std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string line(const std::vector<std::string>& cells, const std::vector<std::size_t>& widths) {
    std::string text;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        text += cells[i];
        text.append(widths[i] - width(cells[i]) + 2, ' ');
    }
    text.erase(text.find_last_not_of(' ') + 1);
    return text + '\n';
}

}  // namespace

std::string Table::text() const {
    std::vector<std::size_t> widths;
    for (const auto& title : titles_) widths.push_back(width(title));
    for (const auto& row : rows_) {
        for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
    }
    auto text = line(titles_, widths);
    for (const auto& row : rows_) text += line(row, widths);
    return text;
}

}  // namespace servobus::scanner::cli
