// Chance, the same on every machine: the generator and its distributions are written out, since those of the standard
// library differ from one library to the next.
#pragma once

#include <cstdint>

namespace servobus::sim {

/// SplitMix64 (Steele, Lea, Flood 2014): 64 bits of state, every seed is good.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    /// One of many that have nothing in common: what one place draws does not move what another one draws, so that a
    /// scenario with an action less is otherwise the same.
    Random(std::uint64_t seed, std::uint64_t stream) : state_(seed) { state_ = next() ^ stream * 0x9E3779B97F4A7C15; }

    std::uint64_t next() {
        state_ += 0x9E3779B97F4A7C15;
        auto value = state_;
        value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9;
        value = (value ^ (value >> 27)) * 0x94D049BB133111EB;
        return value ^ (value >> 31);
    }
    /// 0 to below 1.
    double unit() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
    /// Both ends are in. The bias of the remainder is far below what a run could show.
    std::int64_t between(std::int64_t low, std::int64_t high) {
        return low + static_cast<std::int64_t>(next() % static_cast<std::uint64_t>(high - low + 1));
    }
    unsigned below(unsigned count) { return static_cast<unsigned>(next() % count); }
    bool chance(double share) { return share > 0 && unit() < share; }
    template <class List>
    const auto& of(const List& list) {
        return list[next() % list.size()];
    }

private:
    std::uint64_t state_;
};

}  // namespace servobus::sim
