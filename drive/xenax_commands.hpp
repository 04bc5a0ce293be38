// The direct commands of the XENAX Xvi: the union of both manuals (errata X-43).
// Reserved values are left out, and so are 0x7000 and 0x7001, which only a VARAN module takes.
#pragma once

#include <array>
#include <cstdint>

#include "drive/device.hpp"

namespace servobus::drive::xenax {

/// The numbers of 0x65/0 (000 §2.3.2.1).
enum class Command : std::uint32_t {
    ref = 0x1000,
    rsto = 0x1020,
    mlc = 0x1030,
    aref1 = 0x1050,
    pw = 0x2000,
    pwc = 0x2010,
    pwr = 0x2020,
    pq = 0x2030,
    gp = 0x3000,
    gw = 0x3010,
    jp = 0x3020,
    jn = 0x3030,
    sm = 0x3040,
    gz = 0x3050,
    fc = 0x4000,
    fct1 = 0x4001,
    fct0 = 0x4002,
    fct2 = 0x4003,
    ifdcp = 0x4010,
    ifdcn = 0x4011,
    res = 0x5000,
    resm = 0x5001,
    clcp = 0x5010,
    cp121 = 0x5015,
    cp120 = 0x5016,
    clpo = 0x5020,
    dmbus = 0x5030,
    start_force_monitoring = 0x6000,
    finish_force_monitoring = 0x6001,
    tpso = 0x6002,
    clfo = 0x6010,
};

// clang-format off
inline constexpr std::array<DirectCommand, 31> direct_command_table{{
    // Reference
    {0x1000, "REF",   "Reference",
     "Runs the reference drive. A linear axis needs it after every power-on, a rotative one may do without."},
    {0x1020, "RSTO",  "LimitStop", "References a linear axis against its mechanical stop.",
     Fidelity::behaves, "The position becomes MLPP or MLPN, as DRHR says which stop."},
    {0x1030, "MLC",   "MechanicalLimitCalibration", "Drives to the mechanical stops and stores their positions."},
    {0x1050, "AREF1", "AutomaticReference",
     "Makes the drive reference by itself when reference mode is entered. Reserved in the EtherNet/IP manual."},

    // Power
    {0x2000, "PW",    "PowerOn", "Switches the power stage on. For rotative and third-party motors."},
    {0x2010, "PWC",   "PowerContinues",
     "Switches the power stage on and goes on from the actual position, for example after an error or PQ."},
    {0x2020, "PWR",   "PowerReset", "Switches the power stage on and forgets the reference. For tests."},
    {0x2030, "PQ",    "PowerQuit", "Switches the power stage off."},

    // Motion
    {0x3000, "GP",    "GoPosition", "Drives to the absolute position PO."},
    {0x3010, "GW",    "GoWay", "Drives the distance WA."},
    {0x3020, "JP",    "JogPositive", "Moves in positive direction until it is stopped."},
    {0x3030, "JN",    "JogNegative", "Moves in negative direction until it is stopped."},
    {0x3040, "SM",    "StopMotion", "Stops the running motion."},
    {0x3050, "GZ",    "RotateToZMark", "Turns a rotative motor to the Z-mark of its encoder.",
     Fidelity::behaves, "The nearest one."},

    // Force calibration
    {0x4000, "FC",    "ForceCalibration",
     "Drives the distance WA forward and back and records cogging and friction, to compensate them later.",
     Fidelity::behaves, "What is learned is exact."},
    {0x4001, "FCT1",  "ForceCalibrationTestModeOn", "Tests the force calibration with its compensation active."},
    {0x4002, "FCT0",  "ForceCalibrationTestModeOff", "Ends a force calibration test; the position controller is active."},
    {0x4003, "FCT2",  "ForceCalibrationTestModeOnWithoutCompensation",
     "Tests the force calibration with its compensation inactive."},
    {0x4010, "IFDCP", "IForceDriftCompensationPositive",
     "Starts a drive in positive direction that compensates the drift of I_Force.",
     Fidelity::behaves, "Over 2,000 increments and back; how far the drive goes is not printed."},
    {0x4011, "IFDCN", "IForceDriftCompensationNegative",
     "Starts a drive in negative direction that compensates the drift of I_Force.",
     Fidelity::behaves, "Over 2,000 increments and back; how far the drive goes is not printed."},

    // Initialisation
    {0x5000, "RES",   "Reset", "Sets all parameters back to their defaults."},
    {0x5001, "RESM",  "ResetMotorSpecificSettings", "Sets the parameters that depend on the motor back."},
    {0x5010, "CLCP",  "ClearAllCapturedPositions", "Empties the memory of captured positions."},
    {0x5015, "CP121", "CapturedPositionInput12On",
     "Makes an edge of input 12 capture the position. On the Xvi 48V8 it is input 4."},
    {0x5016, "CP120", "CapturedPositionInput12Off", "Ends what CP121 began."},
    {0x5020, "CLPO",  "ClearPositionCounter", "Makes the actual position of a rotative motor zero."},
    {0x5030, "DMBUS", "DeactivateMotionBlockingByUnconfiguredSMU",
     "Lets the axis move although the safety motion unit is not configured. Only in the bus coupling manual.",
     Fidelity::stored, "The safety unit of this drive is configured."},

    // Force control
    {0x6000, "",      "StartForceMonitoring", "Begins force monitoring in cyclic synchronous position mode."},
    {0x6001, "",      "FinishForceMonitoring",
     "Ends force monitoring in cyclic synchronous position mode and evaluates the motion since it began."},
    {0x6002, "TPSO",  "TakePositionAsSectorOffset", "Makes the actual position the offset of all force sectors."},
    {0x6010, "CLFO",  "ClearForceOffset", "Makes the force that is measured now the new zero."},
}};
// clang-format on

}  // namespace servobus::drive::xenax
