// Capturing the position on an edge of an input (CP121, CP120, CLCP, TCP1 to 8, TCPB1 to 8; 004 §3.4.1, §3.4.2).
// How the two lists differ is not printed. Here TCP keeps the first eight positions since CLCP, TCPB the last eight.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace servobus::drive {

class PositionCapture {
public:
    static constexpr std::size_t places = 8;
    /// The input that captures (004 §3.4.1).
    static constexpr int input_of_75v8 = 12;
    static constexpr int input_of_48v8 = 4;

    /// CP121 and CP120. An input that is active already has no edge.
    void enable(bool on) { enabled_ = on; }
    [[nodiscard]] bool enabled() const { return enabled_; }

    /// Once in each period, on or off: whether the capture input is active, and where the axis is.
    void sample(bool active, std::int64_t position);
    /// Captures without an edge (an input function).
    void capture(std::int64_t position);
    /// CLCP: both lists; on or off stays.
    void clear();

    /// TCPn, n from 1: captured in this order; 0 while empty. Full: further captures do not change it.
    [[nodiscard]] std::int64_t captured(std::size_t place) const;
    /// TCPBn, n from 1: 1 is the latest.
    [[nodiscard]] std::int64_t buffered(std::size_t place) const;
    /// Captures since CLCP.
    [[nodiscard]] std::uint64_t count() const { return count_; }

private:
    bool enabled_ = false;
    bool active_ = false;
    std::uint64_t count_ = 0;
    std::array<std::int64_t, places> first_{};
    std::array<std::int64_t, places> latest_{};  ///< a ring: capture i is at i % places
};

}  // namespace servobus::drive
