// One event as a JSON object: `{"event": "put-obstacle", "position": 40000, "stiffness": 50}`.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "adapter/json_settings.hpp"
#include "adapter/network_fault.hpp"

namespace servobus::adapter {

/// What may stand beside the event, and what of it must.
struct BesideEvent {
    Setters setters{};
    std::vector<std::string> required{};
};

/// The event that the object at `pointer` of the document describes. Members that the event does not have are errors.
[[nodiscard]] std::variant<Happening, FileError> read_event(const JsonDocument& document, const std::string& pointer,
                                                            const nlohmann::json& members, BesideEvent beside = {});

}  // namespace servobus::adapter
