// The four lights of the bus module: RUN, ERR, ST1 and ST2 (000 §1.3, R-LED-1, R-LED-2).
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace servobus::adapter {

/// What the lights tell. "Connected" is at least one connection of class 1 or 3 (R-LED-2).
struct ModuleState {
    bool powered = true;
    bool initialising = false;  ///< it has no address that it may use, and looks for one
    bool connected = false;
    bool address_conflict = false;
    bool fault = false;            ///< "Fault state": bit 3 of the drive's status word (000 §2.3.4.2)
    bool factory_mode = false;     ///< no application runs, because there was no whole one at power-on
    bool valid_bit_stream = true;  ///< in the flash, whatever runs
    bool download = false;         ///< of firmware or bit stream, in progress
    friend bool operator==(const ModuleState&, const ModuleState&) = default;
};

enum class Light : std::uint8_t { run, err, st1, st2 };
inline constexpr std::array<std::string_view, 4> light_names{"RUN", "ERR", "ST1", "ST2"};

enum class LightMode : std::uint8_t { off, on, blink };
[[nodiscard]] std::string_view name(LightMode mode);

struct ShownLight {
    LightMode mode = LightMode::off;
    std::string_view meaning{};  ///< in the words of the manual; empty where being off means nothing
    friend bool operator==(const ShownLight&, const ShownLight&) = default;
};

/// By Light.
using StatusLights = std::array<ShownLight, light_names.size()>;

[[nodiscard]] StatusLights status_lights(const ModuleState& state);

/// Whether a light in this mode shines now. `elapsed` is the time on the module's clock: a light blinks with 1 Hz, and
/// shines in the first half of each second.
[[nodiscard]] constexpr bool is_lit(LightMode mode, std::chrono::microseconds elapsed) {
    constexpr std::chrono::microseconds period = std::chrono::seconds(1);
    return mode == LightMode::on || (mode == LightMode::blink && elapsed % period < period / 2);
}

}  // namespace servobus::adapter
