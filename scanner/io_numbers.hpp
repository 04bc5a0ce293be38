// The numbers that an originator gives away: serial numbers of connections and T->O ids (R-SCN-2).
#pragma once

#include <cstdint>

#include "cip/forward_open.hpp"

namespace servobus::scanner {

class IoNumbers {
public:
    /// All follows from `seed`, which is random outside of tests.
    IoNumbers(std::uint16_t vendor, std::uint64_t seed);

    /// One serial number further.
    [[nodiscard]] cip::ConnectionTriad next_triad();
    /// Another one than the 65535 before; the upper half is that of this start, so that nobody takes a datagram of an
    /// earlier one for his own.
    [[nodiscard]] std::uint32_t next_id();

private:
    cip::ConnectionTriad triad_;
    std::uint32_t id_ = 0;
};

}  // namespace servobus::scanner
