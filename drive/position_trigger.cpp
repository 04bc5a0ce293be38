#include "drive/position_trigger.hpp"

#include <algorithm>

namespace servobus::drive {

void PositionTrigger::clear() {
    upward_.reset();
    downward_.reset();
    remaining_ = 0;
}

bool PositionTrigger::step(std::int64_t position) {
    if (remaining_ > 0) --remaining_;
    const bool upward = last_ && upward_ && *last_ < *upward_ && *upward_ <= position;
    const bool downward = last_ && downward_ && *last_ > *downward_ && *downward_ >= position;
    last_ = position;
    if (upward || downward) remaining_ = pulse_periods;
    return upward || downward;
}

void PositionTrigger::rest(std::int64_t periods) { remaining_ -= std::min(remaining_, periods); }

}  // namespace servobus::drive
