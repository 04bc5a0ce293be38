// Control lines: what people and test programs do to a running drive, one JSON object to a line, each answered by one.
//
//     {"event": "put-obstacle", "position": 40000}    {"ok":true}
//     {"event": "put-obstacle"}                       {"ok":false,"error":"column 1: 'position' is missing"}
//     {"query": "state"}                              {"ok":true,"state":"Operation enabled","position":40000,...}
#pragma once

#include <string>
#include <string_view>

#include "adapter/adapter.hpp"
#include "drive/axis_kind.hpp"
#include "enip/target.hpp"

namespace servobus::adapter {

class Control {
public:
    /// The adapter must outlive this. `axis` is what {"query": "axis"} tells.
    Control(Adapter& adapter, drive::AxisKind axis) : adapter_(adapter), axis_(std::move(axis)) {}

    /// The answer to a line, both without their line ends.
    [[nodiscard]] std::string answer(std::string_view line, enip::Time now);

private:
    Adapter& adapter_;
    drive::AxisKind axis_;
};

/// `{"ok":false,"error":"..."}`, for what is wrong with a line before it can be looked at.
[[nodiscard]] std::string control_error(std::string_view reason);

}  // namespace servobus::adapter
