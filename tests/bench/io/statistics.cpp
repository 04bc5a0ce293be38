#include "tests/bench/io/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace servobus::bench {
namespace {

double rank(const std::vector<double>& sorted, double share) {
    const auto place = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
    return sorted[std::clamp<std::size_t>(place, 1, sorted.size()) - 1];
}

/// Microseconds per number, by least squares.
double slope(std::span<const Arrival> arrivals) {
    const auto count = static_cast<double>(arrivals.size());
    double mean_x = 0;
    double mean_y = 0;
    const auto x = [&](const Arrival& each) { return static_cast<double>(each.sequence - arrivals.front().sequence); };
    const auto y = [&](const Arrival& each) { return static_cast<double>(each.time - arrivals.front().time) / 1000; };
    for (const auto& each : arrivals) {
        mean_x += x(each) / count;
        mean_y += y(each) / count;
    }
    double above = 0;
    double below = 0;
    for (const auto& each : arrivals) {
        above += (x(each) - mean_x) * (y(each) - mean_y);
        below += (x(each) - mean_x) * (x(each) - mean_x);
    }
    return below > 0 ? above / below : 0;
}

}  // namespace

Distribution Distribution::of(std::vector<double> values) {
    if (values.empty()) return {};
    std::ranges::sort(values);
    return {values.size(), rank(values, 0.5), rank(values, 0.99), rank(values, 0.999), values.back()};
}

Intervals Intervals::of(std::span<const Arrival> arrivals, double granted_us) {
    Intervals result;
    result.granted_us = granted_us;
    result.packets = arrivals.size();
    if (arrivals.size() < 2) return result;
    for (std::size_t i = 1; i < arrivals.size(); ++i) {
        const auto step = static_cast<std::int32_t>(arrivals[i].sequence - arrivals[i - 1].sequence);
        if (step <= 0) ++result.disorder;
        if (step > 1) result.lost += static_cast<std::size_t>(step - 1);
        const auto measured = static_cast<double>(arrivals[i].time - arrivals[i - 1].time) / 1000;
        result.errors.push_back(std::abs(measured - granted_us));
    }
    const auto span_us = static_cast<double>(arrivals.back().time - arrivals.front().time) / 1000;
    result.kept = static_cast<double>(arrivals.size() - 1) / std::max(1.0, std::round(span_us / granted_us));
    if (result.disorder == 0) result.drift_ppm = (slope(arrivals) / granted_us - 1) * 1e6;
    return result;
}

void Intervals::pool(const Intervals& other) {
    if (packets == 0) {
        *this = other;
        return;
    }
    const auto all = static_cast<double>(packets + other.packets);
    kept = (kept * static_cast<double>(packets) + other.kept * static_cast<double>(other.packets)) / all;
    packets += other.packets;
    lost += other.lost;
    disorder += other.disorder;
    if (other.drift_ppm && std::abs(*other.drift_ppm) > std::abs(drift_ppm.value_or(0))) drift_ppm = other.drift_ppm;
    errors.insert(errors.end(), other.errors.begin(), other.errors.end());
}

}  // namespace servobus::bench
