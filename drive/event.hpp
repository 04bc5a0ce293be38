// What happens to a drive from outside its bus: people, parts, wires. Scenarios and control commands are lists of these.
#pragma once

#include <cstdint>
#include <variant>

namespace servobus::drive::event {

/// Something stands in the way, or is taken away again. Position in increments, stiffness in N/mm or Nm/rad.
struct PutObstacle {
    std::int64_t position = 0;
    double stiffness = 50;
    bool from_above = false;  ///< it stops motion in negative direction
};
struct RemoveObstacle {};
/// The axis is clamped, or free again.
struct BlockAxis {
    bool blocked = true;
};
/// What the axis carries: kg or kg m2.
struct SetPayload {
    double mass = 0;
};
/// A force on the axis: N or Nm, positive in positive direction.
struct PushAxis {
    double force = 0;
};
/// The level at a digital input, 1 to 12.
struct SetInput {
    int number = 1;
    bool high = true;
};
enum class Direction : std::uint8_t { negative, positive };
struct LimitSwitch {
    Direction direction = Direction::negative;
    bool active = true;
};
/// The emergency exit input: power off (004 §3.3.7, bit 13), or with `keep_power` the stop that leaves the power on
/// (bit 12).
struct EmergencyExit {
    bool active = true;
    bool keep_power = false;
};
enum class SafetyFunction : std::uint8_t { sto, ss1, ss2, sls };
/// A safety input is requested, or released.
struct SafetyStop {
    SafetyFunction function = SafetyFunction::sto;
    bool active = true;
};
/// The wires of the encoder.
struct LoseEncoder {
    bool lost = true;
};
/// The motor supply in volts; 0 cuts it.
struct SetSupply {
    double volts = 0;
};
/// The temperature around motor and drive, degree Celsius.
struct SetTemperature {
    double celsius = 25;
};
/// The master that SR couples the axis to: increment/s of its encoder; 0 stops it.
struct TurnMaster {
    double speed = 0;
};
/// The power stage drops out by itself.
struct CutPowerStage {};
/// Whoever controls the drive over a cyclic connection is idle, silent, or has gone.
struct LoseController {};
/// Logic power off and on again: everything that is not stored is forgotten.
struct PowerCycle {};

}  // namespace servobus::drive::event

namespace servobus::drive {

using Event = std::variant<event::PutObstacle, event::RemoveObstacle, event::BlockAxis, event::SetPayload,
                           event::PushAxis, event::SetInput, event::LimitSwitch, event::EmergencyExit,
                           event::SafetyStop, event::LoseEncoder, event::SetSupply, event::SetTemperature,
                           event::TurnMaster, event::CutPowerStage, event::LoseController, event::PowerCycle>;

}  // namespace servobus::drive
