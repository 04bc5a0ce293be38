// Programs, profiles of several parts, and running in step with a master: motions that follow from one another.
#include <algorithm>
#include <cmath>

#include "drive/xenax_drive.hpp"

namespace servobus::drive {

namespace {

// Steps that take no time, in one control period; the next ones follow in the next.
constexpr int steps_at_once = 16;

}  // namespace

void XenaxDrive::begin_program(std::int64_t number) {
    const auto found = connected_.memory.programs.find(number);
    if (found == connected_.memory.programs.end() || found->second.empty()) {
        return report(xenax::message("program_empty"));
    }
    program_ = &found->second;
    program_step_ = 0;
    program_wait_periods_ = 0;
    program_paused_ = false;
}

void XenaxDrive::begin_profile(std::int64_t number) {
    const auto found = connected_.memory.profiles.find(number);
    if (found == connected_.memory.profiles.end() || found->second.empty()) {
        return report(xenax::message("profile_empty"));
    }
    profile_parts_ = &found->second;
    profile_part_ = 0;
    next_profile_part();
}

/// False when there is none, or it cannot be driven.
bool XenaxDrive::next_profile_part() {
    if (profile_parts_ == nullptr) return false;
    if (profile_part_ == profile_parts_->size() || check_motion()) {
        profile_parts_ = nullptr;
        return false;
    }
    const ProfilePart& part = (*profile_parts_)[profile_part_++];
    const double base = part.relative ? base_of_way() : 0;
    begin_move({base + static_cast<double>(part.target), static_cast<double>(part.speed),
                static_cast<double>(part.acceleration)});
    return true;
}

/// One period of a program: what is over makes room for what comes next.
void XenaxDrive::run_program() {
    if (program_ == nullptr || program_paused_) return;
    if (program_wait_periods_ > 0) {
        --program_wait_periods_;
        return;
    }
    for (int steps = 0; steps < steps_at_once; ++steps) {
        const bool busy = in_motion() || motion_ != Motion::none || profile_parts_ != nullptr;
        if (busy || program_wait_periods_ > 0) return;
        if (program_step_ == program_->size()) {
            program_ = nullptr;
            return;
        }
        if (!execute((*program_)[program_step_])) return;
        ++program_step_;
    }
}

/// False while the step waits, or when it ends the program.
bool XenaxDrive::execute(const ProgramStep& step) {
    switch (step.kind) {
        case ProgramStep::Kind::wait_time:
            program_wait_periods_ = step.value * periods_per_ms;
            return true;
        case ProgramStep::Kind::wait_input:
            return is_set(active_inputs(levels_, input_settings_), static_cast<int>(step.value));
        case ProgramStep::Kind::write:
            break;
    }
    const Parameter& row = *v_.store.find(step.row);
    if (check(row, Value(step.value))) {
        program_ = nullptr;
        report(xenax::message("command_not_now"));
        return false;
    }
    v_.store.cover(row, step.value);  // a program runs again, so that power-off may take what it sets
    take(row);
    return true;
}

double XenaxDrive::override_share() const { return static_cast<double>(v_.override.get()) / 100; }

/// SR: in no mode and under power, the axis goes the master's way times SR / 100. While SR is 0 it stands.
void XenaxDrive::follow_master() {
    master_position_ += master_speed_ * control_period_s;
    const auto ratio = static_cast<double>(v_.synchronous_ratio.get()) / 100;
    const bool coupled = motion_ == Motion::synchronous;
    if (!coupled) {
        const bool wanted =
            ratio != 0 && master_speed_ != 0 && !uncoupled_ && v_.mode_displayed.get() == mode::none && !check_motion();
        if (!wanted) return;
        begin_motion(Motion::synchronous);
        coupled_position_ = axis_.set_point().position;
        coupled_master_ = master_position_;
        coupled_ratio_ = ratio;
    } else if (ratio == 0 || v_.mode_requested.get() != mode::none) {
        begin_stop();
        return;
    } else if (ratio != coupled_ratio_) {
        coupled_position_ += (master_position_ - coupled_master_) * coupled_ratio_;
        coupled_master_ = master_position_;
        coupled_ratio_ = ratio;
    }
    axis_.follow(limited(coupled_position_ + (master_position_ - coupled_master_) * ratio), control_period_s);
}

}  // namespace servobus::drive
