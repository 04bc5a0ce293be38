// The doctor's words for what a Forward_Open asks: intervals, directions, sizes and what they are made of.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "assemblies/connection.hpp"
#include "cip/forward_open.hpp"
#include "scanner/connection_path.hpp"

namespace servobus::scanner {

/// `0.5 ms`, `10 ms`, `3.2 s`.
[[nodiscard]] std::string duration_text(std::chrono::nanoseconds time);

/// A line for each direction, one for transport and timeout, one for the path.
[[nodiscard]] std::vector<std::string> asked_text(const cip::ForwardOpen& request, const ConnectionPath& path);

/// `18 of assembly 101 + 4 run/idle header + 2 sequence count`.
[[nodiscard]] std::string size_parts(const assemblies::Connection& connection, bool o_to_t);

/// A size that differs from the right one, of a direction whose format may be known.
struct SizeMistake {
    bool o_to_t = true;
    std::size_t asked = 0;
    std::size_t expected = 0;
    std::optional<bool> header{};           ///< whether the direction has a run/idle header
    std::optional<std::size_t> opposite{};  ///< the right size of the other direction
};
/// What may have gone wrong in counting, the likeliest first, a sentence each.
[[nodiscard]] std::vector<std::string> size_causes(const SizeMistake& mistake);

/// How long the target keeps a connection without O->T datagrams.
[[nodiscard]] std::chrono::microseconds target_patience(const cip::ForwardOpen& request);

}  // namespace servobus::scanner
