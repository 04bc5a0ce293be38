#include "drive/position_capture.hpp"

namespace servobus::drive {

void PositionCapture::sample(bool active, std::int64_t position) {
    if (enabled_ && active && !active_) capture(position);
    active_ = active;
}

void PositionCapture::capture(std::int64_t position) {
    if (count_ < places) first_[count_] = position;
    latest_[count_ % places] = position;
    ++count_;
}

void PositionCapture::clear() {
    count_ = 0;
    first_ = {};
    latest_ = {};
}

std::int64_t PositionCapture::captured(std::size_t place) const {
    return place >= 1 && place <= places ? first_[place - 1] : 0;
}

std::int64_t PositionCapture::buffered(std::size_t place) const {
    return place >= 1 && place <= places && place <= count_ ? latest_[(count_ - place) % places] : 0;
}

}  // namespace servobus::drive
