// What a row of the report is made of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tests/bench/io/clock.hpp"

namespace servobus::bench {

/// By nearest rank, in microseconds.
struct Distribution {
    std::size_t count = 0;
    double p50 = 0;
    double p99 = 0;
    double p999 = 0;
    double max = 0;

    [[nodiscard]] static Distribution of(std::vector<double> values);
};

/// A datagram as the kernel took it.
struct Arrival {
    Nanoseconds time = 0;          ///< of CLOCK_REALTIME
    std::uint32_t sequence = 0;    ///< of the encapsulation
    std::uint32_t outputs = 0;     ///< DigitalOutputsXENAX, where the data holds them
    std::uint32_t connection = 0;  ///< its id
};

/// The measured packet interval against the granted one.
struct Intervals {
    double granted_us = 0;
    std::size_t packets = 0;
    std::size_t lost = 0;      ///< sequence numbers that were left out
    std::size_t disorder = 0;  ///< duplicated or not newer than the one before
    double kept = 0;           ///< packets of those that the granted interval promises; 1 is all
    /// By least squares over all arrivals; positive: slower than granted. None when numbers went back: the connection
    /// was opened again.
    std::optional<double> drift_ppm{};
    std::vector<double> errors;  ///< |measured - granted|, in microseconds

    [[nodiscard]] static Intervals of(std::span<const Arrival> arrivals, double granted_us);
    [[nodiscard]] Distribution jitter() const { return Distribution::of(errors); }
    /// Several runs as one. The drift is the largest of them.
    void pool(const Intervals& other);
};

}  // namespace servobus::bench
