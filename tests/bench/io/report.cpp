#include "tests/bench/io/report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

namespace servobus::bench {
namespace {

std::string word(const Row& value) {
    if (value.is_string()) return value.get<std::string>();
    if (value.is_null()) return "";
    return value.dump();
}

}  // namespace

void Report::table(const std::string& key, const std::string& title, const std::string& note) {
    table_ = key;
    columns_.clear();
    all_[key] = {{"title", title}, {"note", note}, {"rows", nlohmann::ordered_json::array()}};
    fmt::print("\n### {}\n\n{}\n", title, note);
    std::fflush(stdout);
}

void Report::add(const Row& row) {
    all_[table_]["rows"].push_back(row);
    std::vector<std::string> columns;
    std::string names = "|";
    std::string line = "|";
    std::string rule = "|";
    for (const auto& [name, value] : row.items()) {
        columns.push_back(name);
        names += fmt::format(" {} |", name);
        rule += "---|";
        line += fmt::format(" {} |", word(value));
    }
    if (columns != columns_) fmt::print("\n{}\n{}\n", names, rule);
    columns_ = columns;
    fmt::print("{}\n", line);
    std::fflush(stdout);
}

double rounded(double value) { return std::stod(fmt::format("{:.4g}", value)); }

void put(Row& row, const Distribution& distribution) {
    row["p50_us"] = rounded(distribution.p50);
    row["p99_us"] = rounded(distribution.p99);
    row["p999_us"] = rounded(distribution.p999);
    row["max_us"] = rounded(distribution.max);
}

Row interval_row(const std::string& what, const std::string& condition, const Intervals& intervals) {
    Row row{{"what", what}, {"condition", condition}, {"packets", intervals.packets}};
    row["kept_percent"] = std::round(intervals.kept * 1e5) / 1e3;
    row["lost"] = intervals.lost;
    row["disorder"] = intervals.disorder;
    put(row, intervals.jitter());
    row["drift_ppm"] = intervals.drift_ppm ? Row(std::round(*intervals.drift_ppm * 10) / 10) : Row(nullptr);
    return row;
}

Row ratio(const Row& product, const Row& floor, const std::string& column) {
    const auto below = floor.at(column).get<double>();
    if (below <= 0) return nullptr;
    return std::round(product.at(column).get<double>() / below * 100) / 100;
}

}  // namespace servobus::bench
