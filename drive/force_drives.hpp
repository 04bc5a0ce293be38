// Motions that measure or limit force: calibration, drift compensation, and the stored Drive I_Force (004 §6).
#pragma once

#include <cstdint>

#include "drive/procedure.hpp"

namespace servobus::drive {

/// Over a way at constant speed, and back to where it began.
class ThereAndBack : public Procedure {
public:
    ThereAndBack(double way, double speed, double acceleration)
        : way_(way), speed_(speed), acceleration_(acceleration) {}
    [[nodiscard]] Progress step(Axis& axis, const ProcedureInputs& inputs) override;

protected:
    /// Neither accelerating nor standing.
    [[nodiscard]] bool at_speed(const Axis& axis) const;

private:
    enum class Stage : std::uint8_t { starting, forward, back };

    double way_;
    double speed_;
    double acceleration_;
    Stage stage_ = Stage::starting;
    double begin_ = 0;
};

/// FC: while the axis goes there and back, cogging and friction are recorded (004 §6.1.1).
class ForceCalibration final : public ThereAndBack {
public:
    using ThereAndBack::ThereAndBack;
};

/// IFDCP and IFDCN: a short way; the mean of the currents there and back is what has drifted.
class DriftCompensation final : public ThereAndBack {
public:
    using ThereAndBack::ThereAndBack;
    [[nodiscard]] Progress step(Axis& axis, const ProcedureInputs& inputs) override;
    /// A, once it is done.
    [[nodiscard]] double offset() const { return samples_ == 0 ? 0 : sum_ / samples_; }

private:
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
