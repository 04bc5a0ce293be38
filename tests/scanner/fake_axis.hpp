// A drive without mechanics: it answers control words and modes at once, and a motion lasts some looks.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "cip/message.hpp"
#include "scanner/axis_sequence.hpp"

namespace servobus::scanner::test {

class FakeAxis {
public:
    FakeAxis();

    AxisState state;
    std::vector<AxisWrite> writes;
    /// Looks that a motion lasts.
    int motion = 4;
    /// What it refuses.
    std::function<bool(const AxisWrite&)> refuses = [](const AxisWrite&) { return false; };
    /// Called at each look while it moves.
    std::function<void(FakeAxis&)> in_motion = [](FakeAxis&) {};
    bool takes_packets = true;

    void write(const AxisWrite& write);
    void look();
    void set(AxisValue which, std::int64_t value) { state.take(which, drive::Value(value)); }
    /// Power on, referenced, in profile position mode.
    void make_ready();
    void fail_with(int error, const std::string& text);
    [[nodiscard]] std::vector<std::int64_t> control_words() const;

    /// As a device on the bus.
    [[nodiscard]] cip::Response answer(const cip::Request& request);

private:
    void control(std::uint16_t word);
    void set_status(std::uint32_t mask, std::uint32_t value);
    void set_process(std::uint32_t mask, std::uint32_t value);
    void start(std::uint16_t word);
    void end_motion();
    [[nodiscard]] cip::Response answer_single(const cip::Request& request);

    int left_ = 0;
    std::int64_t target_ = 0;
};

}  // namespace servobus::scanner::test
