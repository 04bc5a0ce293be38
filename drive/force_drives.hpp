// Motions that measure or limit force: calibration, drift compensation, and the stored Drive I_Force (004 §6).
#pragma once

#include <cstdint>

#include "drive/procedure.hpp"

namespace servobus::drive {

/// FC: over a way and back at constant speed, while cogging and friction are recorded (004 §6.1.1).
class ForceCalibration final : public Procedure {
public:
    ForceCalibration(double way, double speed, double acceleration)
        : way_(way), speed_(speed), acceleration_(acceleration) {}
    [[nodiscard]] Progress step(Axis& axis, const ProcedureInputs& inputs) override;

private:
    enum class Stage : std::uint8_t { starting, forward, back };

    double way_;
    double speed_;
    double acceleration_;
    Stage stage_ = Stage::starting;
    double begin_ = 0;
};

/// IFDCP and IFDCN: a short way and back; the mean of both currents is what has drifted.
class DriftCompensation final : public Procedure {
public:
    DriftCompensation(double way, double speed, double acceleration)
        : way_(way), speed_(speed), acceleration_(acceleration) {}
    [[nodiscard]] Progress step(Axis& axis, const ProcedureInputs& inputs) override;
    /// A, once it is done.
    [[nodiscard]] double offset() const { return samples_ == 0 ? 0 : sum_ / samples_; }

private:
    enum class Stage : std::uint8_t { starting, forward, back };

    double way_;
    double speed_;
    double acceleration_;
    Stage stage_ = Stage::starting;
    double begin_ = 0;
    double sum_ = 0;
    int samples_ = 0;
};

/// DIF and DF: in one direction until the force limit holds the axis, and then it keeps pressing. The limit itself is
/// the servo's.
class ForceDrive final : public Procedure {
public:
    ForceDrive(double velocity, double acceleration) : velocity_(velocity), acceleration_(acceleration) {}
    [[nodiscard]] Progress step(Axis& axis, const ProcedureInputs& inputs) override;

private:
    double velocity_;
    double acceleration_;
    bool started_ = false;
    StallDetector stall_;
};

}  // namespace servobus::drive
