// A small rotative axis that turns without end, for tests that want one that no file describes.
#pragma once

#include "drive/axis_kind.hpp"

namespace servobus::test {

inline drive::AxisKind rotative_axis() {
    drive::AxisKind kind;
    kind.key = "test-rotative";
    kind.motor_type = "rotative";
    kind.family = drive::AxisKind::Family::third_party;
    kind.motion = drive::AxisKind::Motion::rotative;
    kind.increments_per_turn = 24'000;
    kind.increments_per_unit = 24'000 / 6.283185307179586;
    kind.moving_mass = 6e-5;
    kind.force_constant = 0.08;
    kind.peak_current = 12;
    kind.nominal_current = 4;
    kind.friction_static = 0.012;
    kind.friction_dynamic = 0.01;
    kind.friction_viscous = 1e-5;
    kind.cogging = 0;
    kind.has_stops = false;
    kind.start_position = 3'000;
    return kind;
}

}  // namespace servobus::test
