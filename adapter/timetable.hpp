// What happens to the drive, and when: a list of events that is played against the clock of its caller.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "adapter/network_fault.hpp"
#include "drive/time.hpp"

namespace servobus::adapter {

/// Events in the order of their times, which count from the start. After `repeat_every`, if given, all starts again.
struct Timetable {
    struct Entry {
        drive::Time at{};
        Happening event;
    };
    std::vector<Entry> entries;
    std::optional<drive::Time> repeat_every{};  ///< longer than zero, and not shorter than the last entry's time
};

/// A timetable that runs.
class Playback {
public:
    Playback() = default;
    explicit Playback(Timetable timetable) : timetable_(std::move(timetable)) {}

    /// The clock of the timetable starts; only the first call counts.
    void start(drive::Time now);
    [[nodiscard]] bool started() const { return start_.has_value(); }
    /// The time since start().
    [[nodiscard]] drive::Time elapsed(drive::Time now) const { return start_ ? now - *start_ : drive::Time{}; }

    /// When the next event is due; nullopt before start() and after the last one.
    [[nodiscard]] std::optional<drive::Time> next() const;
    /// The next event that is due by `now`, with its own time. Repetitions that nobody has asked for while they were
    /// due are left out.
    [[nodiscard]] std::optional<Timetable::Entry> take(drive::Time now);

private:
    Timetable timetable_;
    std::optional<drive::Time> start_;
    drive::Time round_{};  ///< when the present repetition began
    std::size_t position_ = 0;
};

}  // namespace servobus::adapter
