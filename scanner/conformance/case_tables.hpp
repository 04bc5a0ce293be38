// The tables of cases, one for each group. A case belongs to the file of its group.
#pragma once

#include <span>

#include "scanner/conformance/case.hpp"

namespace servobus::scanner::conformance {

[[nodiscard]] std::span<const Case> encapsulation_cases();
[[nodiscard]] std::span<const Case> session_cases();
[[nodiscard]] std::span<const Case> packet_cases();
[[nodiscard]] std::span<const Case> ucmm_cases();
[[nodiscard]] std::span<const Case> class3_cases();
[[nodiscard]] std::span<const Case> object_cases();
[[nodiscard]] std::span<const Case> network_object_cases();
[[nodiscard]] std::span<const Case> key_cases();
[[nodiscard]] std::span<const Case> forward_open_cases();
[[nodiscard]] std::span<const Case> refused_open_cases();
[[nodiscard]] std::span<const Case> null_open_cases();
[[nodiscard]] std::span<const Case> forward_close_cases();
[[nodiscard]] std::span<const Case> ownership_cases();
[[nodiscard]] std::span<const Case> multicast_cases();
[[nodiscard]] std::span<const Case> production_cases();
[[nodiscard]] std::span<const Case> timeout_cases();
[[nodiscard]] std::span<const Case> inactivity_cases();
[[nodiscard]] std::span<const Case> malformed_cases();

}  // namespace servobus::scanner::conformance
