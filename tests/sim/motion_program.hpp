// What the program of an owner makes of its drive: it switches it on, lets the axis move, holds it, lets it go.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "assemblies/connection.hpp"
#include "cip/bytes.hpp"
#include "tests/sim/random.hpp"

namespace servobus::sim {

class MotionProgram {
public:
    enum class Goal : std::uint8_t { relax, hold, move };

    /// Without outputs (a heartbeat) it does nothing.
    MotionProgram(const assemblies::Connection& kind, bool jog, std::uint64_t seed);

    void want(Goal goal) { goal_ = goal; }
    void run(bool run) { run_ = run; }
    /// What the drive says.
    void input(cip::ByteView data);
    /// What it is told, and whether the run bit is set. Each image has another target, so that it can be seen which one is in
    /// force.
    bool output(std::span<std::uint8_t> data);

private:
    struct Places {
        std::size_t target;
        std::size_t speed;
        std::size_t acceleration;
        std::size_t control;
    };
    [[nodiscard]] std::uint16_t next_word();
    [[nodiscard]] std::uint16_t moving_word();

    std::optional<Places> places_{};
    std::size_t status_place_ = 0;
    cip::Bytes idle_image_;
    bool jog_;
    Random random_;
    Goal goal_ = Goal::hold;
    bool run_ = true;
    std::uint16_t status_ = 0;
    std::uint16_t word_ = 0;
    std::uint32_t stamp_ = 0;
    std::uint32_t patience_ = 0;  ///< datagrams until the next turn
    bool there_ = false;          ///< the way that it goes now
};

}  // namespace servobus::sim
