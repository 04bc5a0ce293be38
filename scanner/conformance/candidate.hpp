// The I/O connections that a device is said to have, and what may be varied about each of them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scanner/io_plan.hpp"

namespace servobus::eds {
struct DataSheet;
}  // namespace servobus::eds

namespace servobus::scanner::conformance {

enum class Kind : std::uint8_t { exclusive_owner, redundant_owner, input_only, listen_only };
[[nodiscard]] std::string_view name(Kind kind);

struct Candidate {
    std::string name{};
    Kind kind = Kind::exclusive_owner;
    IoPlan plan{};
    // What else the device is said to take.
    bool point_to_point = true;  ///< T->O
    bool multicast = false;      ///< T->O
    bool variable = false;       ///< in both directions
    bool change_of_state = false;
    bool application = false;
    unsigned priorities = 0xF;       ///< of T->O: a bit for each cip::Priority
    std::uint32_t shortest_rpi = 1;  ///< of both directions, microseconds
    std::uint32_t longest_rpi = 0xFFFFFFFF;

    [[nodiscard]] bool owns() const { return kind == Kind::exclusive_owner || kind == Kind::redundant_owner; }
};

/// Those of a data sheet that can be opened, in its order.
[[nodiscard]] std::vector<Candidate> candidates_of(const eds::DataSheet& sheet);
/// Those of the XENAX.
[[nodiscard]] std::vector<Candidate> candidates_of_xenax();
/// One that somebody has described by its numbers: an input-only one when it sends no data.
[[nodiscard]] Candidate candidate_of(const IoPlan& plan);

}  // namespace servobus::scanner::conformance
