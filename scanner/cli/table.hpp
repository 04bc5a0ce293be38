// Columns that line up.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace servobus::scanner::cli {

class Table {
public:
    explicit Table(std::vector<std::string> titles) : titles_(std::move(titles)) {}

    void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
    [[nodiscard]] std::string text() const;

private:
    std::vector<std::string> titles_;
    std::vector<std::vector<std::string>> rows_;
};

}  // namespace servobus::scanner::cli
