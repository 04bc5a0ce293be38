// Lines over one common axis, in panels on top of each other, as an SVG document.
#pragma once

#include <string>
#include <vector>

namespace servobus::scanner::cli {

struct ChartPanel {
    std::string name;
    std::string unit;
    std::vector<double> y;  ///< as many as Chart::x
};

struct Chart {
    std::string title;
    std::string x_label;
    std::vector<double> x;  ///< ascending
    std::vector<ChartPanel> panels;
};

[[nodiscard]] std::string svg(const Chart& chart);

/// Round numbers from at least `low` to at most `high`, as many as `most` at most: steps of 1, 2 or 5 and powers of 10.
[[nodiscard]] std::vector<double> ticks(double low, double high, int most);

}  // namespace servobus::scanner::cli
