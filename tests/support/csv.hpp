// The transcripts of the manuals' tables under tests/reference: one record for each row, by the names of its columns.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace servobus::test {

using Record = std::map<std::string, std::string>;

inline std::vector<std::string> split_csv(const std::string& line) {
    std::vector<std::string> cells(1);
    bool quoted = false;
    for (const char c : line) {
        if (c == '"') {
            quoted = !quoted;
        } else if (c == ',' && !quoted) {
            cells.emplace_back();
        } else if (c != '\r') {
            cells.back() += c;
        }
    }
    return cells;
}

}  // namespace servobus::test
