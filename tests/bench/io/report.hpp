// What was measured: tables for people, in Markdown, and the same as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/io/statistics.hpp"

namespace servobus::bench {

using Row = nlohmann::ordered_json;

class Report {
public:
    /// Starts a table; `note` says what is measured and which row is the base of the ratios.
    void table(const std::string& key, const std::string& title, const std::string& note);
    /// Adds a row to it and prints it.
    void add(const Row& row);
    void set(const std::string& key, const Row& value) { all_[key] = value; }
    [[nodiscard]] std::string json() const { return all_.dump(2); }

private:
    nlohmann::ordered_json all_;
    std::string table_;
    std::vector<std::string> columns_;
};

/// The columns p50_us, p99_us, p999_us and max_us.
void put(Row& row, const Distribution& distribution);
[[nodiscard]] Row interval_row(const std::string& what, const std::string& condition, const Intervals& intervals);
/// product / floor, of two rows' columns; null when the floor is 0.
[[nodiscard]] Row ratio(const Row& product, const Row& floor, const std::string& column);
/// For rows: as many digits as say something.
[[nodiscard]] double rounded(double value);

}  // namespace servobus::bench
