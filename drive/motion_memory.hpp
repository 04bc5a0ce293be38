// What a XENAX keeps beside its parameters: programs, and motion profiles of several parts. No bus can write them; on a
// real drive WebMotion does, here they come with the machine.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "drive/parameter.hpp"

namespace servobus::drive {

struct DirectCommand;

/// One line of a program. The next one follows when what it started is over.
struct ProgramStep {
    enum class Kind : std::uint8_t {
        write,       ///< a value to a row, as a bus would write it: every direct command is a value of 0x65/0
        wait_time,   ///< ms
        wait_input,  ///< until the input of this number is active
    };
    Kind kind = Kind::write;
    Key row{};
    std::int64_t value = 0;

    friend bool operator==(const ProgramStep&, const ProgramStep&) = default;
};

/// One part of a profile, from standstill to standstill: increments, increment/s, increment/s2.
struct ProfilePart {
    std::int64_t target = 0;
    bool relative = false;
    std::int64_t speed = 100'000;
    std::int64_t acceleration = 1'000'000;
};

struct MotionMemory {
    static constexpr int programs_at_most = 63;  ///< PG 1 to 63 (000 §2.3.2.2)
    static constexpr int profiles_at_most = 5;   ///< PRF 1 to 5
    static constexpr std::size_t steps_at_most = 1'000;

    std::map<std::int64_t, std::vector<ProgramStep>> programs;
    std::map<std::int64_t, std::vector<ProfilePart>> profiles;
};

/// A line as the drive's own command set writes it: `REF`, `GP`, `G 10000`, `SP 50000`, `IX 3`, `SO 1`; and `WT 500`
/// (wait 500 ms) and `WI 3` (wait for input 3). Otherwise a sentence without a full stop that says what is wrong.
[[nodiscard]] std::variant<ProgramStep, std::string> parse_step(std::span<const Parameter> table,
                                                                std::span<const DirectCommand> commands,
                                                                Key direct_command_row, std::string_view line);

}  // namespace servobus::drive
