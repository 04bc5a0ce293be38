// The connection ids and numbers that this target chooses, for all its connections (R-CON-16).
#pragma once

#include <cstdint>

namespace servobus::adapter {

class ConnectionIds {
public:
    /// `incarnation` goes into the upper half of every id, so that ids differ between starts.
    explicit ConnectionIds(std::uint16_t incarnation) : incarnation_(incarnation) {}

    /// An id that none of the last 65,535 was. Whoever takes it looks whether a connection still has it.
    [[nodiscard]] std::uint32_t next() { return std::uint32_t{incarnation_} << 16 | ++last_; }

private:
    std::uint16_t incarnation_;
    std::uint16_t last_ = 0;
};

}  // namespace servobus::adapter
