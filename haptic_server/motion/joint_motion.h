#pragma once

#include "haptic_server/motion/rigid_body.h"

namespace haptics {

/// One tick of a body on a hinge or slider. In its one coordinate, so that it cannot leave its axis and needs no solver.
/// At a limit it stops without rebound.
void moveOnJoint(const RigidBody& body, RigidState& state, const Push& push, double period_s) noexcept;

[[nodiscard]] Pose jointPose(const RigidBody& body, const RigidState& state) noexcept;
[[nodiscard]] RigidVelocity jointVelocity(const RigidBody& body, const RigidState& state) noexcept;

}  // namespace haptics
