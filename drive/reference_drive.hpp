// How an axis finds its absolute position (000 §3.2.1 to §3.2.2.4): the ways of linear axes, of rotative motors, and
// against a mechanical stop.
#pragma once

#include <cstdint>
#include <optional>

#include "drive/procedure.hpp"

namespace servobus::drive {

/// Linear axes, methods 1 to 6: over two distance-coded marks, after which the encoder shows the distance from the
/// mechanical zero. A stop or a limit switch in the way turns the search round, once.
class LinearReference final : public Procedure {
public:
    /// `phasing`: the electrical angle has to be found first. `speed` in increment/s, `acceleration` in increment/s2.
    LinearReference(bool positive, bool phasing, double speed, double acceleration);
    [[nodiscard]] Progress step(Axis& axis, const ProcedureInputs& inputs) override;

private:
    enum class Stage : std::uint8_t { phasing, searching, stopping, settling };

    void search(Axis& axis, bool positive);
    [[nodiscard]] Progress look(Axis& axis, const ProcedureInputs& inputs);

    double speed_;
    double acceleration_;
    bool positive_;
    bool turned_ = false;
    Stage stage_;
    int periods_ = 0;
    int marks_ = 0;
    double last_position_ = 0;
    StallDetector stall_;
};

/// Which way to the Z-mark after the sensor (000 §2.3.4.16).
enum class ZMarkSearch : std::uint8_t { positive, negative, shortest };

/// Rotative motors, methods 10 to 15: to the sensor, then to the Z-mark, where the position becomes 0. A speed of 0
/// leaves that part out (000 §2.3.4.17, §2.3.4.18). Clockwise is positive (docs/errata.md).
class RotativeReference final : public Procedure {
public:
    struct Search {
        bool positive = true;
        ZMarkSearch z_mark = ZMarkSearch::positive;
        double sensor_speed = 0;
        double z_mark_speed = 0;
        double acceleration = 0;
    };
    explicit RotativeReference(const Search& search) : search_(search) {}
    [[nodiscard]] Progress step(Axis& axis, const ProcedureInputs& inputs) override;

private:
    enum class Stage : std::uint8_t { starting, sensor, leaving_sensor, z_mark, stopping };

    [[nodiscard]] Progress find_sensor(Axis& axis, const ProcedureInputs& inputs);
    void start_z_mark(Axis& axis);
    [[nodiscard]] Progress find_z_mark(Axis& axis);
    void found(Axis& axis, double zero);

    Search search_;
    Stage stage_ = Stage::starting;
    double begin_ = 0;
    double last_position_ = 0;
    double zero_ = 0;
    StallDetector stall_;
};

/// RSTO: against a mechanical stop, with little force; there the position becomes `position`.
class LimitStopReference final : public Procedure {
public:
    LimitStopReference(bool positive, std::int64_t position, double speed, double acceleration)
        : positive_(positive), position_(position), speed_(speed), acceleration_(acceleration) {}
    [[nodiscard]] Progress step(Axis& axis, const ProcedureInputs& inputs) override;

private:
    bool positive_;
    std::int64_t position_;
    double speed_;
    double acceleration_;
    bool started_ = false;
    double begin_ = 0;
    StallDetector stall_;
};

/// MLC: to both mechanical stops and back to where it started.
class LimitCalibration final : public Procedure {
public:
    LimitCalibration(double speed, double acceleration) : speed_(speed), acceleration_(acceleration) {}
    [[nodiscard]] Progress step(Axis& axis, const ProcedureInputs& inputs) override;
    /// Where the stops are, once it is done.
    [[nodiscard]] std::int64_t negative() const { return negative_; }
    [[nodiscard]] std::int64_t positive() const { return positive_; }

private:
    enum class Stage : std::uint8_t { starting, negative, positive, back };

    double speed_;
    double acceleration_;
    Stage stage_ = Stage::starting;
    std::int64_t begin_ = 0;
    std::int64_t negative_ = 0;
    std::int64_t positive_ = 0;
    StallDetector stall_;
};

}  // namespace servobus::drive
