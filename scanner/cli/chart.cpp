#include "scanner/cli/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace servobus::scanner::cli {
namespace {

constexpr double width = 960;
constexpr double left = 120;
constexpr double right = 30;
constexpr double top = 56;
constexpr double panel_height = 132;
constexpr double panel_gap = 34;
constexpr double bottom = 54;
constexpr double plot_width = width - left - right;
/// More points than these are more than there are pixels.
constexpr std::size_t columns = 1600;
constexpr std::array<std::string_view, 5> colours{"#1f5fa8", "#1b8a5a", "#b0532a", "#7a3d9a", "#8a7a12"};

constexpr std::string_view style = R"(<style>
text { font-family: "DejaVu Sans", Helvetica, Arial, sans-serif; font-size: 12px; fill: #333333 }
.title { font-size: 16px; font-weight: bold; fill: #111111 }
.name { font-size: 13px; font-weight: bold }
.y { text-anchor: end }
.x { text-anchor: middle }
.grid { stroke: #e3e3e3; stroke-width: 1 }
.zero { stroke: #a8a8a8; stroke-width: 1 }
.frame { fill: none; stroke: #777777; stroke-width: 1 }
.line { fill: none; stroke-width: 1.6; stroke-linejoin: round }
</style>
)";

struct Range {
    double low = 0;
    double high = 1;

    [[nodiscard]] double share(double value) const { return (value - low) / (high - low); }
};

std::string escaped(std::string_view text) {
    std::string result;
    for (const char c : text) {
        if (c == '&') {
            result += "&amp;";
        } else if (c == '<') {
            result += "&lt;";
        } else if (c == '>') {
            result += "&gt;";
        } else {
            result += c;
        }
    }
    return result;
}

/// `-1 200 000`, `0.25`: thousands apart, no more decimals than the step needs.
std::string number_text(double value, double step) {
    const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
    auto text = fmt::format("{:.{}f}", std::abs(value) < step / 2 ? 0.0 : value, decimals);
    const auto point = std::min(text.find('.'), text.size());
    const std::size_t first = text.front() == '-' ? 1 : 0;
    for (auto at = point; at > first + 3;) {
        at -= 3;
        text.insert(at, " ");
    }
    return text;
}

/// The values and a little air around them; never empty.
Range range_of(const std::vector<double>& values) {
    if (values.empty()) return {};
    const auto [low, high] = std::ranges::minmax(values);
    const double air = std::max((high - low) * 0.06, std::max(1.0, std::abs(high)) * 1e-3);
    return {low - air, high + air};
}

Range x_range_of(const std::vector<double>& x) {
    if (x.size() < 2 || x.back() <= x.front()) return {};
    return {x.front(), x.back()};
}

double step_of(const std::vector<double>& marks) { return marks.size() > 1 ? marks[1] - marks[0] : 1; }

/// Points for a line: of each pixel column the lowest and the highest value, in their order.
std::vector<std::size_t> points(const std::vector<double>& y) {
    std::vector<std::size_t> kept;
    const auto stride = std::max<std::size_t>(1, y.size() / columns);
    for (std::size_t begin = 0; begin < y.size(); begin += stride) {
        const auto first = y.begin() + static_cast<std::ptrdiff_t>(begin);
        const auto last = y.begin() + static_cast<std::ptrdiff_t>(std::min(begin + stride, y.size()));
        const auto [low, high] = std::minmax_element(first, last);
        const auto [earlier, later] = std::minmax(low, high);
        kept.push_back(static_cast<std::size_t>(earlier - y.begin()));
        if (later != earlier) kept.push_back(static_cast<std::size_t>(later - y.begin()));
    }
    return kept;
}

class Drawing {
public:
    explicit Drawing(const Chart& chart) : chart_(chart), x_(x_range_of(chart.x)) {}

    std::string draw() {
        const auto count = static_cast<double>(chart_.panels.size());
        const double height = top + count * panel_height + (count - 1) * panel_gap + bottom;
        text_ = fmt::format(
            R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0:g}" height="{1:g}" viewBox="0 0 {0:g} {1:g}">)"
            "\n",
            width, height);
        text_ += style;
        text_ += fmt::format(R"(<rect width="{:g}" height="{:g}" fill="#ffffff"/>)"
                             "\n",
                             width, height);
        label("title", left, 26, chart_.title);
        for (std::size_t i = 0; i < chart_.panels.size(); ++i) panel(i);
        label("x", left + plot_width / 2, height - 14, chart_.x_label);
        return text_ + "</svg>\n";
    }

private:
    void panel(std::size_t index) {
        const auto& shown = chart_.panels[index];
        const double above = top + static_cast<double>(index) * (panel_height + panel_gap);
        const auto range = range_of(shown.y);
        const auto y_of = [&](double value) { return above + panel_height * (1 - range.share(value)); };
        label("name", left, above - 7, fmt::format("{} [{}]", shown.name, shown.unit));
        const auto y_marks = ticks(range.low, range.high, 6);
        for (const auto mark : y_marks) {
            const bool is_zero = std::abs(mark) < step_of(y_marks) / 2;
            line(is_zero ? "zero" : "grid", left, y_of(mark), left + plot_width, y_of(mark));
            label("y", left - 8, y_of(mark) + 4, number_text(mark, step_of(y_marks)));
        }
        const auto x_marks = ticks(x_.low, x_.high, 12);
        for (const auto mark : x_marks) {
            line("grid", x_of(mark), above, x_of(mark), above + panel_height);
            if (index + 1 < chart_.panels.size()) continue;
            label("x", x_of(mark), above + panel_height + 18, number_text(mark, step_of(x_marks)));
        }
        text_ += fmt::format(R"(<rect class="frame" x="{:g}" y="{:g}" width="{:g}" height="{:g}"/>)"
                             "\n",
                             left, above, plot_width, panel_height);
        text_ += fmt::format(R"(<polyline class="line" stroke="{}" points=")", colours[index % colours.size()]);
        std::string_view gap;
        for (const auto i : points(shown.y)) {
            text_ += fmt::format("{}{:.2f},{:.2f}", gap, x_of(chart_.x[i]), y_of(shown.y[i]));
            gap = " ";
        }
        text_ += "\"/>\n";
    }

    [[nodiscard]] double x_of(double value) const { return left + plot_width * x_.share(value); }

    void line(std::string_view kind, double x1, double y1, double x2, double y2) {
        text_ += fmt::format(R"(<line class="{}" x1="{:.2f}" y1="{:.2f}" x2="{:.2f}" y2="{:.2f}"/>)"
                             "\n",
                             kind, x1, y1, x2, y2);
    }
    void label(std::string_view kind, double x, double y, std::string_view content) {
        text_ += fmt::format(R"(<text class="{}" x="{:.2f}" y="{:.2f}">{}</text>)"
                             "\n",
                             kind, x, y, escaped(content));
    }

    const Chart& chart_;
    Range x_;
    std::string text_;
};

}  // namespace

std::vector<double> ticks(double low, double high, int most) {
    const double least = (high - low) / most;
    const double power = std::pow(10, std::floor(std::log10(least)));
    double step = 10 * power;
    for (const double factor : {1.0, 2.0, 5.0}) {
        if (factor * power >= least) {
            step = factor * power;
            break;
        }
    }
    std::vector<double> marks;
    for (double number = std::ceil(low / step - 1e-9); number * step <= high + step * 1e-9; ++number) {
        marks.push_back(number * step);
    }
    return marks;
}

std::string svg(const Chart& chart) { return Drawing(chart).draw(); }

}  // namespace servobus::scanner::cli
