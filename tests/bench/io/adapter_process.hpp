// The product: servobus-adapter, at an address of this machine that nobody else uses.
#pragma once

#include "tests/bench/io/child.hpp"
#include "tests/bench/io/scenarios.hpp"

namespace servobus::bench {

/// Listens when this returns. `count` drives, the first at Settings::address.
[[nodiscard]] Child start_adapter(const Settings& settings, std::size_t count = 1);
/// The client that reads attributes from it; it has got its first answer when this returns.
[[nodiscard]] Child start_load(const Settings& settings);
/// Ends it and returns the rate that it has reached.
[[nodiscard]] double stop_load(Child& load);
[[nodiscard]] enip::Endpoint explicit_endpoint(const Settings& settings);

}  // namespace servobus::bench
