#pragma once

#include "common/telemetry/device_reading.h"
#include "haptic_server/engine/step/force_result.h"
#include "haptic_server/engine/step/haptic_state.h"
#include "haptic_server/engine/step/servo_scene.h"

// A body that the hand holds while a button is pressed: a virtual coupling (Colgate, Stanley & Brown 1995) of six degrees in
// place of the contact. With the place x of the body at which the hand took it, the HIP h, their velocities v, and theta how
// the body is turned from where the device turns it (axis n), hand and body feel, one the opposite of the other,
//   F = K (x - h) + D (v_x - v_h),    |F| at most the device's limit
//   T = K_r sin(theta) n + D_r (w_body - w_device)
// K is the object's stiffness, the rest is graspSprings()'. The sine keeps T continuous where theta passes half a turn.
namespace haptics {

/// Of a tick in which a button that grasps is pressed, or was in the last: takes the body that the IHIP was on, or lets it go.
/// @return Whether the hand holds one now.
[[nodiscard]] bool followGrasp(HapticState& state, const DevicePose& device) noexcept;

/// Force on the hand, and torque, of what it holds. `result.contact` is where it holds it.
void feelGrasp(const ServoScene& scene, HapticState& state, const StepConfig& config, const DevicePose& device,
               ForceResult& result) noexcept;

/// The hand holds nothing from here on, until a button is pressed anew: force and torque go as by an edit, and a body in which
/// the HIP is then is felt once it has left it.
void letGo(HapticState& state) noexcept;

}  // namespace haptics
