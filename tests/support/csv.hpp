// The transcripts of the manuals' tables under tests/reference: one record for each row, by the names of its columns.
#pragma once

#include <fstream>
#include <map>
#include <string>
#include <utility>
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

/// No records when there is no such file.
inline std::vector<Record> read_csv(const std::string& path) {
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    const auto columns = split_csv(line);
    std::vector<Record> records;
    while (std::getline(file, line)) {
        const auto cells = split_csv(line);
        Record record;
        for (std::size_t i = 0; i < columns.size() && i < cells.size(); ++i) {
            record[columns[i]] = cells[i];
        }
        records.push_back(std::move(record));
    }
    return records;
}

}  // namespace servobus::test
