// What a device does beyond keeping values: the machine behind the table.
#pragma once

#include <optional>

#include "drive/digital_io.hpp"
#include "drive/event.hpp"
#include "drive/parameter.hpp"
#include "drive/refusal.hpp"
#include "drive/store.hpp"
#include "drive/time.hpp"

namespace servobus::drive {

/// It reads and writes the store that it was made with, and keeps the rows that it computes up to date there.
class Behaviour {
public:
    virtual ~Behaviour() = default;

    /// Whether the drive takes this legal value in its present state. Changes nothing.
    [[nodiscard]] virtual std::optional<Refusal> check(const Parameter& row, const Value& value) const = 0;
    /// A bus has written this row; the store holds the value.
    virtual void written(const Parameter& row) = 0;
    /// Time has come to `now`; the first call only starts it.
    virtual void step(Time now) = 0;
    /// When it wants to be stepped at the latest, while something moves; nullopt when nothing does.
    [[nodiscard]] virtual std::optional<Time> next_deadline() const = 0;
    /// Something happens to it from outside. A power cycle is power_up().
    virtual void inject(const Event& event) = 0;
    /// What output `number`, 1 to 8, does to its wire now.
    [[nodiscard]] virtual OutputLevel output_wire(int number) const = 0;
    /// The store has just been reset: what the connected motor and axis tell is put into it.
    virtual void tell_machine() = 0;
    /// Logic power off and on. The store holds what the drive comes up with.
    virtual void power_up() = 0;
    /// A fault keeps it from doing what it is for, until it is reset.
    [[nodiscard]] virtual bool has_fault() const = 0;

protected:
    Behaviour() = default;
    Behaviour(const Behaviour&) = default;
    Behaviour& operator=(const Behaviour&) = default;
};

}  // namespace servobus::drive
