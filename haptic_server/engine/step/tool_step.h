#pragma once

#include <cstddef>

#include "common/telemetry/device_reading.h"
#include "haptic_server/engine/motion/rigid_body.h"
#include "haptic_server/engine/step/force_result.h"
#include "haptic_server/engine/step/haptic_state.h"
#include "haptic_server/engine/step/servo_scene.h"

namespace haptics {

/// The proxy is put where the device is.
void attachTool(HapticState& state, const DevicePose& device) noexcept;

/// Contact and force of the tool that the hand holds, in place of those of the point (paper 3.2 and 3, for each of its
/// points; ToolContact), its torque, and the moment of its jaws, as the device is given them. `result.contact` is where it is
/// held most; its allowance is what the tool may spend. Bodies are met as the scene has them, rigid and smooth.
void feelTool(const ServoScene& scene, HapticState& state, const StepConfig& config, const DevicePose& device,
              ForceResult& result) noexcept;

/// Bounds torque and moment of a tick: rate after an edit, amount, ramp of a fault.
void limitTorque(HapticState& state, const ForceResult& result) noexcept;

/// The torque of a tool that is not held any more: it goes at the rate of an edit.
void fadeTorque(HapticState& state, const ForceResult& result) noexcept;

/// The tool's, for the device, of this tick.
[[nodiscard]] inline Vec3 writtenTorque_Nm(const HapticState& state) noexcept {
  return state.features.tool || state.features.torqueFades ? state.tool.torque.written_Nm() : Vec3(0);
}

/// With what a client adds, within the device's limit; the tool's observer does not know of that.
[[nodiscard]] inline Vec3 writtenTorque_Nm(const HapticState& state, const StepConfig& config,
                                           const AddedWrench& added) noexcept {
  const Vec3 own_Nm = writtenTorque_Nm(state);
  if (!added.acts || state.limits.clutched || !isFinite(added.torque_Nm)) [[likely]]
    return own_Nm;
  return limitMagnitude(own_Nm + state.supervision.ramp.gain() * added.torque_Nm, config.rotation.maxTorque_Nm);
}

/// The moment on the device's gripper, of this tick.
[[nodiscard]] inline double writtenGrip_Nm(const HapticState& state) noexcept {
  return state.tool.grips ? state.tool.grip.written_Nm().x : 0;
}

/// What the tool gives a body.
[[nodiscard]] Push pushOfTool(const HapticState& state, std::size_t body) noexcept;

/// Writes how the tool is held in this tick; object 0: there is none.
/// @return Whether `tool` said otherwise.
[[nodiscard]] bool updateToolState(const HapticState& state, ToolState& tool) noexcept;

}  // namespace haptics
