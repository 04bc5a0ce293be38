// The position trigger (TGU, TGD; 004 §3.4.3): a pulse when the axis passes a position in one direction. The manuals
// here do not say how long the pulse is, nor whether it fires once: the length is chosen, and it fires at each passing.
#pragma once

#include <cstdint>
#include <optional>

namespace servobus::drive {

class PositionTrigger {
public:
    /// 5 ms at 100 us: long enough for the input of a PLC.
    static constexpr std::int64_t pulse_periods = 50;

    /// TGU, TGD. Each replaces its own position; both can be set. Unset until the first write.
    void set_upward(std::int64_t position) { upward_ = position; }
    void set_downward(std::int64_t position) { downward_ = position; }
    void clear();

    /// One control period; true when the trigger fires in it. Arriving at the position counts, leaving it does not.
    bool step(std::int64_t position);
    /// `periods` control periods in which the axis stands.
    void rest(std::int64_t periods);
    /// The position counter was set (REF, CLPO): its jump is no motion.
    void forget_position() { last_.reset(); }

    /// The output function: the pulse lasts.
    [[nodiscard]] bool active() const { return remaining_ > 0; }

private:
    std::optional<std::int64_t> upward_;
    std::optional<std::int64_t> downward_;
    std::optional<std::int64_t> last_;
    std::int64_t remaining_ = 0;
};

}  // namespace servobus::drive
