#include "scanner/cli/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "scanner/cli/chart.hpp"

namespace servobus::scanner::cli {
namespace {

/// Samples on each side that a slope is taken from: some, and more in a long recording.
constexpr std::size_t least_neighbours = 5;
constexpr std::size_t samples_per_neighbour = 200;

/// The slope of the best line through velocities from one sample to another.
double slope(const Samples& samples, std::size_t first, std::size_t last) {
    double time = 0;
    double velocity = 0;
    const auto count = static_cast<double>(last - first + 1);
    for (auto i = first; i <= last; ++i) {
        time += samples[i].time / count;
        velocity += static_cast<double>(samples[i].velocity) / count;
    }
    double both = 0;
    double square = 0;
    for (auto i = first; i <= last; ++i) {
        const double from_middle = samples[i].time - time;
        both += from_middle * (static_cast<double>(samples[i].velocity) - velocity);
        square += from_middle * from_middle;
    }
    return square > 0 ? both / square : 0;
}

template <class Member>
std::vector<double> column(const Samples& samples, Member member) {
    std::vector<double> values;
    values.reserve(samples.size());
    for (const auto& sample : samples) values.push_back(static_cast<double>(sample.*member));
    return values;
}

bool is_picture(const std::string& file) { return file.ends_with(".svg"); }

}  // namespace

Sample sample_of(const AxisState& state, double time) {
    return {time,
            state.status_word(),
            state.number(AxisValue::position),
            state.number(AxisValue::velocity),
            state.number(AxisValue::current),
            state.number(AxisValue::following_error)};
}

std::string csv(const Samples& samples) {
    std::string text =
        "time [s],position [increment],velocity [increment/s],current [mA],following error [increment],status word\n";
    for (const auto& sample : samples) {
        text += fmt::format("{:.6f},{},{},{},{},0x{:04X}\n", sample.time, sample.position, sample.velocity,
                            sample.current, sample.following_error, sample.status_word);
    }
    return text;
}

std::vector<double> accelerations(const Samples& samples) {
    const auto reach = least_neighbours + samples.size() / samples_per_neighbour;
    std::vector<double> values;
    values.reserve(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
        // The same number on both sides, so that nothing is shifted in time.
        const auto around = std::min({reach, i, samples.size() - 1 - i});
        values.push_back(slope(samples, i - around, i + around));
    }
    return values;
}

std::string picture(const Samples& samples, const std::string& title) {
    Chart chart;
    chart.title = title;
    chart.x_label = "time [s]";
    chart.x = column(samples, &Sample::time);
    chart.panels = {{"position", "increment", column(samples, &Sample::position)},
                    {"velocity", "increment/s", column(samples, &Sample::velocity)},
                    {"acceleration", "increment/s²", accelerations(samples)},
                    {"current", "mA", column(samples, &Sample::current)},
                    {"following error", "increment", column(samples, &Sample::following_error)}};
    return svg(chart);
}

std::optional<Mistake> check_trace_file(const std::string& file) {
    if (!is_picture(file) && !file.ends_with(".csv")) {
        return Mistake{fmt::format("'{}' ends neither with .csv nor with .svg", file)};
    }
    // Nothing of an older recording is lost by this.
    if (!std::ofstream(file, std::ios::app)) return Mistake{fmt::format("'{}' cannot be written", file)};
    return std::nullopt;
}

bool write_trace_file(const std::string& file, const Samples& samples, const std::string& title) {
    std::ofstream stream(file, std::ios::trunc);
    stream << (is_picture(file) ? picture(samples, title) : csv(samples));
    stream.close();
    return !stream.fail();
}

}  // namespace servobus::scanner::cli
