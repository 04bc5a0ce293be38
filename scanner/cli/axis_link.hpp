// An axis behind a connection: its values, read and written. Over explicit messages, or over an I/O connection.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <span>

#include "scanner/axis_sequence.hpp"
#include "scanner/axis_state.hpp"
#include "scanner/cli/link.hpp"

namespace servobus::scanner::cli {

class AxisLink {
public:
    using Clock = std::chrono::steady_clock;
    using Recorder = std::function<void(const AxisState&, Clock::time_point)>;

    virtual ~AxisLink() = default;

    /// Reads values into a state. What the device refuses stays as it was; only a refused status word is a failure, for
    /// then it is no such drive.
    [[nodiscard]] virtual std::optional<Failure> read(std::span<const AxisValue> values, AxisState& state) = 0;
    /// The same by explicit messages, whatever has become of the rest.
    [[nodiscard]] virtual std::optional<Failure> ask(std::span<const AxisValue> values, AxisState& state) {
        return read(values, state);
    }
    /// Looks at the axis as it is after everything that has been written: at `needed`, and at what else comes with it.
    [[nodiscard]] virtual std::optional<Failure> look(std::span<const AxisValue> needed, AxisState& state) = 0;
    [[nodiscard]] virtual std::optional<Failure> write(const AxisWrite& write) = 0;
    /// The last write that was refused.
    [[nodiscard]] virtual const std::optional<AxisWrite>& refused() const = 0;

    /// Does nothing until then, but keeps the connection.
    virtual void wait_until(Clock::time_point when) = 0;
    /// True when `recorder` is told every sample from now on, with its own time; false when whoever looks has to
    /// record.
    [[nodiscard]] virtual bool record(Recorder) { return false; }

protected:
    AxisLink() = default;
    AxisLink(const AxisLink&) = default;
    AxisLink& operator=(const AxisLink&) = default;
};

}  // namespace servobus::scanner::cli
