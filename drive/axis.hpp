// One controlled axis: a set point that moves, the controller that follows it, and the machine that is moved. It knows
// no state machine and no parameter table; time is counted in control periods.
#pragma once

#include <cstdint>

#include "drive/axis_kind.hpp"
#include "drive/heat.hpp"
#include "drive/plant.hpp"
#include "drive/profile.hpp"
#include "drive/servo.hpp"

namespace servobus::drive {

class Axis {
public:
    /// `seed` chooses the noise of the measured current; the same seed and the same calls give the same bits.
    Axis(const AxisKind& kind, std::uint64_t seed);

    [[nodiscard]] const AxisKind& kind() const { return kind_; }
    [[nodiscard]] Plant& plant() { return plant_; }
    [[nodiscard]] const Plant& plant() const { return plant_; }
    [[nodiscard]] Heat& heat() { return heat_; }
    [[nodiscard]] const Heat& heat() const { return heat_; }
    [[nodiscard]] ServoSettings& settings() { return settings_; }
    [[nodiscard]] const ServoSettings& settings() const { return settings_; }

    /// Power: on holds the position where the axis stands, off lets it coast. The brake is the user's.
    void switch_on();
    void switch_off();
    [[nodiscard]] bool is_on() const { return on_; }
    void set_brake(bool closed);
    [[nodiscard]] bool brake() const { return brake_; }
    void set_supply_voltage(double volts);
    [[nodiscard]] double supply_voltage() const { return supply_voltage_; }
    /// While it is lost, the position stays what it was and the velocity is 0. Found again, an incremental encoder
    /// counts on from there; an absolute one knows better.
    void set_encoder_lost(bool lost);
    [[nodiscard]] bool encoder_lost() const { return encoder_lost_; }

    // What the set point does. All of these do nothing while the axis is off; positions are the encoder's.
    /// From where the set point stands; only while it stands.
    void move_to(double position, const MotionLimits& limits);
    /// Jog; again while moving changes speed, direction and acceleration on the fly.
    void run_at(double velocity, double acceleration, double jerk);
    /// Down to standstill from whatever it does.
    void stop(double acceleration, double jerk);
    /// Cyclic synchronous position: reach `target` in `seconds`, on a straight line (004 §5.3).
    void follow(double target, double seconds);
    /// The set point jumps to where the axis stands, and stays.
    void hold();

    /// The set point takes over where the axis is and how fast it goes, whatever it was to do.
    void catch_up();

    /// One control period.
    void step();
    /// `periods` control periods in which nothing can happen because at_rest() is true: only warmth changes.
    void rest(std::int64_t periods);
    /// Set point, machine and current stand still, and would go on doing so.
    [[nodiscard]] bool at_rest() const;

    /// The set point moves, or a profile has time left.
    [[nodiscard]] bool moving() const { return moving_; }
    [[nodiscard]] const MotionState& set_point() const { return set_point_; }
    /// Where the profile that runs or ran last ends; its final velocity is not 0 in a jog.
    [[nodiscard]] const Profile& profile() const { return profile_; }
    [[nodiscard]] double profile_time() const { return profile_time_; }  ///< s since its start

    /// The encoder: whole increments.
    [[nodiscard]] std::int64_t position() const;
    [[nodiscard]] double velocity() const { return encoder_lost_ ? 0 : plant_.velocity(); }  ///< increment/s
    [[nodiscard]] double following_error() const { return set_point_.position - static_cast<double>(position()); }
    [[nodiscard]] double current() const { return current_; }                    ///< A, as it is
    [[nodiscard]] double measured_current() const { return measured_current_; }  ///< A, with noise (TMC)
    /// A, filtered, without what a calibration has learned (IFA).
    [[nodiscard]] double force_current() const { return force_current_; }
    [[nodiscard]] double contact_force() const { return plant_.contact_force(); }  ///< N or Nm
    [[nodiscard]] bool at_force_limit() const { return on_ && servo_.at_force_limit(); }

    /// The encoder counts on from `value` where the axis stands (REF, CLPO). Only while the set point stands.
    void set_position(std::int64_t value);
    /// What the encoder shows at the mechanical zero.
    [[nodiscard]] double encoder_offset() const { return encoder_offset_; }

private:
    enum class Source : std::uint8_t { hold, profile, follow };

    void start(const Profile& profile);
    void advance_set_point();
    void advance_profile();
    void advance_follow();
    void stand(double position);
    [[nodiscard]] double measured_position() const;
    [[nodiscard]] double learned_current() const;
    void control();
    void measure();
    void add_noise(std::int64_t periods);

    AxisKind kind_;
    Plant plant_;
    Servo servo_;
    Heat heat_;
    ServoSettings settings_;
    std::uint64_t noise_;  ///< goes on with time; a hash of it is the noise

    bool on_ = false;
    bool brake_ = false;
    bool encoder_lost_ = false;
    bool touched_ = true;  ///< something has changed that no step has seen yet
    double supply_voltage_;
    double encoder_offset_ = 0;
    double frozen_position_ = 0;  ///< what a lost encoder goes on saying

    Source source_ = Source::hold;
    bool moving_ = false;
    MotionState set_point_{};
    Profile profile_{};
    std::int64_t profile_periods_ = 0;
    double profile_time_ = 0;
    double follow_target_ = 0;
    double follow_acceleration_ = 0;
    std::int64_t follow_left_ = 0;  ///< control periods until the target is reached

    double current_ = 0;
    double measured_current_ = 0;
    double force_current_ = 0;
    bool force_current_steady_ = true;
};

}  // namespace servobus::drive
