// What an axis did, sample by sample, as a table or a picture.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scanner/axis_state.hpp"
#include "scanner/mistake.hpp"

namespace servobus::scanner::cli {

struct Sample {
    double time = 0;  ///< s since the recording began, by the local clock
    std::uint16_t status_word = 0;
    std::int64_t position = 0;
    std::int64_t velocity = 0;
    std::int64_t current = 0;
    std::int64_t following_error = 0;
};
using Samples = std::vector<Sample>;

[[nodiscard]] Sample sample_of(const AxisState& state, double time);

/// A header with units, then a row for each sample.
[[nodiscard]] std::string csv(const Samples& samples);

/// increment/s2 at each sample: the slope of the line that fits the velocities around it best. A plain difference of
/// neighbours would show noise only.
[[nodiscard]] std::vector<double> accelerations(const Samples& samples);

/// Panels of position, velocity, acceleration, current and following error over one time axis, as an SVG document.
[[nodiscard]] std::string picture(const Samples& samples, const std::string& title);

/// Why a file cannot hold a recording: it is to end with .csv or .svg, and it is to be writable.
[[nodiscard]] std::optional<Mistake> check_trace_file(const std::string& file);
/// Writes what the file's name says; false when it cannot be written.
[[nodiscard]] bool write_trace_file(const std::string& file, const Samples& samples, const std::string& title);

}  // namespace servobus::scanner::cli
