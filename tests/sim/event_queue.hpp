// The clock of a simulation: what happens next, and when.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "enip/time.hpp"

namespace servobus::sim {

using enip::Time;

class EventQueue {
public:
    /// At the same time, what was asked for first happens first. What is asked for in the past happens now.
    void at(Time when, std::function<void()> what) {
        heap_.push_back({std::max(when, now_), next_number_++, std::move(what)});
        std::ranges::push_heap(heap_, later);
    }
    void after(Time::duration delay, std::function<void()> what) { at(now_ + delay, std::move(what)); }

    [[nodiscard]] Time now() const { return now_; }
    [[nodiscard]] bool empty() const { return heap_.empty(); }
    [[nodiscard]] Time next() const { return heap_.front().when; }
    [[nodiscard]] std::uint64_t done() const { return done_; }

    void run_next() {
        std::ranges::pop_heap(heap_, later);
        const auto event = std::move(heap_.back());
        heap_.pop_back();
        now_ = event.when;
        ++done_;
        event.what();
    }

private:
    struct Event {
        Time when;
        std::uint64_t number;
        std::function<void()> what;
    };
    static bool later(const Event& a, const Event& b) {
        return a.when != b.when ? a.when > b.when : a.number > b.number;
    }

    Time now_{std::chrono::hours(1)};
    std::uint64_t next_number_ = 0;
    std::uint64_t done_ = 0;
    std::vector<Event> heap_;
};

}  // namespace servobus::sim
