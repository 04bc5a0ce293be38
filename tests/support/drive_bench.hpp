// A DriveHarness for people who work with commands rather than control words.
#pragma once

#include <cmath>

#include "drive/axis_kind.hpp"
#include "tests/support/drive_harness.hpp"

namespace servobus::test {

/// Bits of the process status register (004 §3.3.7).
namespace psr {
inline constexpr unsigned error = 0;
inline constexpr unsigned reference = 1;
inline constexpr unsigned in_motion = 2;
inline constexpr unsigned in_position = 3;
inline constexpr unsigned in_force = 5;
inline constexpr unsigned in_sector = 6;
inline constexpr unsigned force_in_sector = 7;
inline constexpr unsigned power = 8;
inline constexpr unsigned gantry = 9;
inline constexpr unsigned negative_limit_switch = 10;
inline constexpr unsigned positive_limit_switch = 11;
inline constexpr unsigned emergency_exit_power_on = 12;
inline constexpr unsigned emergency_exit = 13;
inline constexpr unsigned force_calibration = 14;
inline constexpr unsigned current_limit = 15;
inline constexpr unsigned phasing = 25;
inline constexpr unsigned drift_compensation = 26;
inline constexpr unsigned force_limit = 27;
}  // namespace psr

class DriveBench : public DriveHarness {
public:
    using DriveHarness::DriveHarness;

    bool psr(unsigned number) { return bit("ProcessStatusRegisterXENAX", number); }
    std::uint32_t tpsr() { return word("ProcessStatusRegisterXENAX"); }
    double position() { return static_cast<double>(get("PositionActualValue")); }
    bool moving() { return psr(psr::in_motion); }

    [[nodiscard]] bool stands_within(std::chrono::microseconds limit = std::chrono::seconds(60)) {
        return runs_until([&] { return !moving(); }, limit);
    }
    /// REF, and nothing else: it switches the power on by itself.
    void refer() {
        command("REF");
        EXPECT_TRUE(runs_until([&] { return psr(psr::reference) && !moving(); }, std::chrono::seconds(30)));
    }
    void go(std::int64_t target) {
        set("GoImmediately", target);
        EXPECT_TRUE(stands_within());
        run(std::chrono::milliseconds(100));
    }
    /// The refusal of a write or command that must leave everything else as it was.
    void expect_refused(const std::optional<drive::Refusal>& refusal, drive::Refusal wanted) {
        ASSERT_TRUE(refusal);
        EXPECT_EQ(*refusal, wanted) << drive::describe(*refusal);
    }
    /// `command` is refused, and neither status nor position nor motion show anything of it.
    void refuses(std::string_view mnemonic, drive::Refusal wanted = drive::Refusal::wrong_state) {
        SCOPED_TRACE(mnemonic);
        const auto status = tpsr();
        const auto statusword = word("Statusword");
        const auto error = get("TellError");
        expect_refused(try_command(mnemonic), wanted);
        EXPECT_EQ(tpsr(), status);
        EXPECT_EQ(word("Statusword"), statusword);
        EXPECT_EQ(get("TellError"), error);
    }
    void refuses_write(std::string_view name, std::int64_t value, drive::Refusal wanted = drive::Refusal::wrong_state) {
        SCOPED_TRACE(name);
        const auto status = tpsr();
        expect_refused(try_set(name, value), wanted);
        EXPECT_EQ(tpsr(), status);
    }
};

}  // namespace servobus::test
