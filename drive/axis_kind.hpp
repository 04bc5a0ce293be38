// What an axis is, as data: the motor, its mechanics and its measuring system. Files of these ship with the program.
#pragma once

#include <cstdint>
#include <string>

namespace servobus::drive {

/// Linear axes count in metres, newtons and kilograms; rotative ones in turns of the shaft's angle in radian, newton
/// metres and kilogram square metres. A "unit" below is a metre or a radian. Positions are increments from the
/// mechanical zero. The defaults are a LINAX Lxc 230F10.
struct AxisKind {
    enum class Motion : std::uint8_t { linear, rotative };
    /// How the absolute position is found (000 §3.2.2): two distance-coded marks; the encoder's Z-mark, and a sensor;
    /// or not at all, because the encoder is absolute.
    enum class Reference : std::uint8_t { distance_coded_marks, z_mark, absolute };
    /// Reference methods 14 and 15 are for the ROTAX Rxvp alone (000 §3.2.2.3).
    enum class Family : std::uint8_t { linax, elax, rotax_rxvp, rotax_rxhq, third_party };

    std::string key = "linax-lxc-230f10";
    std::string name = "LINAX Lxc 230F10";
    std::string motor_type = "230101";  ///< what 0x64/1/8 says (000 §2.3.1.6)
    Family family = Family::linax;
    Motion motion = Motion::linear;
    Reference reference = Reference::distance_coded_marks;

    double increments_per_unit = 1'000'000;  ///< per metre, or per radian
    double moving_mass = 0.32;               ///< kg or kg m2, without payload
    double force_constant = 1 / 0.28;        ///< N/A or Nm/A: 28 x 10 mA to a newton (004 §6.1.2)
    double peak_current = 10.0;              ///< A
    double nominal_current = 2.8;            ///< A that the motor stands for ever
    double resistance = 2.5;                 ///< ohm, phase to phase
    double inductance = 0.001;               ///< H, phase to phase
    double supply_voltage = 48;              ///< V of the motor supply

    double friction_static = 1.3;    ///< N or Nm to start to move
    double friction_dynamic = 1.2;   ///< N or Nm in motion
    double friction_viscous = 0.8;   ///< N or Nm for each unit/s
    double cogging = 0.6;            ///< N or Nm, amplitude
    double cogging_period = 24'000;  ///< increments

    bool has_stops = true;
    double stop_negative = -1'500;  ///< increments; mechanical stops
    double stop_positive = 231'500;
    double stop_stiffness = 400'000;  ///< N or Nm for each unit
    double start_position = 60'000;   ///< where the slider stands at power-on
    double travel = 230'000;          ///< increments that may be used: the stroke

    double mark_distance = 2'000;    ///< increments between distance-coded marks, as an upper bound
    double increments_per_turn = 0;  ///< of the shaft; 0 for linear axes
    double z_mark = 0;               ///< increments inside a turn where the Z-mark is
    double sensor_position = 0;      ///< increments inside a turn where the reference sensor begins to see
    double sensor_width = 0;         ///< increments over which it sees; 0: there is no sensor
    int pole_pairs = 0;

    double thermal_resistance = 3.2;  ///< K/W from the winding to the surroundings
    double thermal_time = 240;        ///< s
    double temperature_limit = 80;    ///< degree Celsius of the winding
};

}  // namespace servobus::drive
