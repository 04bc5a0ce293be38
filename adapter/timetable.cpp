#include "adapter/timetable.hpp"

namespace servobus::adapter {

void Playback::start(drive::Time now) {
    if (start_) return;
    start_ = now;
    round_ = now;
}

std::optional<drive::Time> Playback::next() const {
    if (!start_ || position_ >= timetable_.entries.size()) return std::nullopt;
    return round_ + timetable_.entries[position_].at;
}

std::optional<Timetable::Entry> Playback::take(drive::Time now) {
    const auto due = next();
    if (!due || *due > now) return std::nullopt;
    auto entry = timetable_.entries[position_++];
    entry.at = *due;
    if (position_ == timetable_.entries.size() && timetable_.repeat_every) {
        const auto period = *timetable_.repeat_every;
        round_ += period;
        if (round_ + period <= now) round_ += (now - round_) / period * period;
        position_ = 0;
    }
    return entry;
}

}  // namespace servobus::adapter
