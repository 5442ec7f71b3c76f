#pragma once

#include "haptic_server/engine/motion/rigid_body.h"

namespace haptics {

/// The rate of a body on a hinge or slider after a tick of gravity, push, spring and damping. In its one coordinate, so that
/// it cannot leave its axis and needs no solver.
void driveOnJoint(const RigidBody& body, RigidState& state, const Push& push, double period_s) noexcept;
/// Moves it by a tick at that rate. At a limit it stops without rebound.
void advanceOnJoint(const RigidBody& body, RigidState& state, double period_s) noexcept;
/// The mass or moment that a force along the axis, or a torque about it, moves.
[[nodiscard]] double inertiaOnJoint(const RigidBody& body, const RigidState& state) noexcept;
/// How a place (world) moves at a rate of 1 /s.
[[nodiscard]] Vec3 directionOnJoint(const RigidBody& body, const RigidState& state, Vec3 place_m) noexcept;

[[nodiscard]] Pose jointPose(const RigidBody& body, const RigidState& state) noexcept;
[[nodiscard]] RigidVelocity jointVelocity(const RigidBody& body, const RigidState& state) noexcept;

}  // namespace haptics
