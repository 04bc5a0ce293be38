// An axis behind a link: its values, several in one packet where the device takes packets.
#pragma once

#include <optional>
#include <span>

#include "scanner/axis_sequence.hpp"
#include "scanner/axis_state.hpp"
#include "scanner/cli/link.hpp"

namespace servobus::scanner::cli {

class AxisLink {
public:
    /// The link is open and outlives this.
    explicit AxisLink(Link& link) : link_(link) { link.count_from_last_answer(); }

    /// Reads values into a state. What the device refuses stays as it was; only a refused status word is a failure, for
    /// then it is no such drive.
    [[nodiscard]] std::optional<Failure> read(std::span<const AxisValue> values, AxisState& state);
    [[nodiscard]] std::optional<Failure> write(const AxisWrite& write);
    /// The device's word about the last write that it refused.
    [[nodiscard]] const std::optional<AxisWrite>& refused() const { return refused_; }

    [[nodiscard]] Link& link() { return link_; }

private:
    [[nodiscard]] std::optional<Failure> read_single(AxisValue which, AxisState& state);
    [[nodiscard]] std::optional<Failure> take(AxisValue which, const cip::Response& response, AxisState& state);

    Link& link_;
    bool packets_ = true;
    std::optional<AxisWrite> refused_;
};

}  // namespace servobus::scanner::cli
