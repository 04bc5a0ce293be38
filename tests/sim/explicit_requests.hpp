// What clients of the simulation ask, and what a drive answers in whatever state it is.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "cip/message.hpp"

namespace servobus::sim {

struct ExplicitRequest {
    std::string_view what;
    std::uint8_t service;
    std::string_view path;  ///< encoded, in hex
    std::string_view data;
    std::uint8_t status;                ///< the general status of the reply
    std::optional<std::size_t> size{};  ///< octets of its data
    std::string_view beginning{};       ///< of its data, in hex
};
[[nodiscard]] std::span<const ExplicitRequest> explicit_requests();

[[nodiscard]] cip::Request request_of(const ExplicitRequest& request);
/// Whether that is an answer to it.
[[nodiscard]] bool fits(const ExplicitRequest& request, const cip::Response& response);

}  // namespace servobus::sim
