// An axis over explicit messages, several values in one packet where the device takes packets.
#pragma once

#include <optional>
#include <span>

#include "scanner/cli/axis_link.hpp"
#include "scanner/cli/link.hpp"

namespace servobus::scanner::cli {

class ExplicitAxisLink : public AxisLink {
public:
    /// The link is open and outlives this.
    explicit ExplicitAxisLink(Link& link) : link_(link) { link.count_from_last_answer(); }

    [[nodiscard]] std::optional<Failure> read(std::span<const AxisValue> values, AxisState& state) override;
    /// Reads followed_values().
    [[nodiscard]] std::optional<Failure> look(std::span<const AxisValue> needed, AxisState& state) override;
    [[nodiscard]] std::optional<Failure> write(const AxisWrite& write) override;
    [[nodiscard]] const std::optional<AxisWrite>& refused() const override { return refused_; }
    void wait_until(Clock::time_point when) override { link_.wait_until(when); }

private:
    [[nodiscard]] std::optional<Failure> read_single(AxisValue which, AxisState& state);
    [[nodiscard]] std::optional<Failure> take(AxisValue which, const cip::Response& response, AxisState& state);

    Link& link_;
    bool packets_ = true;
    std::optional<AxisWrite> refused_;
};

}  // namespace servobus::scanner::cli
