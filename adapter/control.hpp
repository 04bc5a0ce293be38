// Control lines: what people and test programs do to a running drive, one JSON object to a line, each answered by one.
//
//     {"event": "put-obstacle", "position": 40000}    {"ok":true}
//     {"event": "put-obstacle"}                       {"ok":false,"error":"column 1: 'position' is missing"}
//     {"query": "state"}                              {"ok":true,"state":"Operation enabled","position":40000,...}
//     {"command": "stop"}                             {"ok":true}, and the program ends
//     {"command": "download", "file": "x.flash"}      {"ok":true}, and the lights tell the rest
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "adapter/adapter.hpp"
#include "adapter/json_document.hpp"
#include "drive/axis_kind.hpp"
#include "enip/target.hpp"

namespace servobus::adapter {

class Control {
public:
    /// The adapters must outlive this. Lines that name no drive mean the first. `axis` is what {"query": "axis"} tells.
    Control(Adapter& adapter, drive::AxisKind axis, std::string address = "")
        : drives_{{std::move(address), &adapter}}, axis_(std::move(axis)) {}

    /// Another drive of this process, by the address at which it listens: {"drive": "127.0.1.2", ...}.
    void add(Adapter& adapter, std::string address) { drives_.push_back({std::move(address), &adapter}); }
    /// What {"command": "stop"} does.
    void on_stop(std::function<void()> stop) { stop_ = std::move(stop); }

    /// The answer to a line, both without their line ends.
    [[nodiscard]] std::string answer(std::string_view line, enip::Time now);

private:
    struct Drive {
        std::string address;
        Adapter* adapter;
    };

    [[nodiscard]] std::vector<std::pair<std::string_view, Adapter*>> names() const;
    [[nodiscard]] std::string obey(const JsonDocument& document, enip::Time now);

    std::vector<Drive> drives_;
    drive::AxisKind axis_;
    std::function<void()> stop_;
};

/// `{"ok":false,"error":"..."}`, for what is wrong with a line before it can be looked at.
[[nodiscard]] std::string control_error(std::string_view reason);

}  // namespace servobus::adapter
