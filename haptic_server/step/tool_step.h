#pragma once

#include <cstddef>

#include "haptic_server/motion/rigid_body.h"
#include "haptic_server/step/force_result.h"
#include "haptic_server/step/haptic_state.h"
#include "haptic_server/step/servo_scene.h"

namespace haptics {

/// Where a device that senses no rotation has the tool: it is turned as the scene has it. World.
[[nodiscard]] inline Pose devicePose(const HapticState& state, Vec3 position) noexcept {
  return {state.objects[state.tool.body].scenePose.rotation, position};
}

/// The proxy is put where the device is.
void attachTool(HapticState& state, Vec3 position) noexcept;

/// Contact and force of the tool that the hand holds, in place of those of the point (paper 3.2 and 3, for each of its
/// points; ToolContact). `result.contact` is where it is held most; its allowance is what the tool may spend. Bodies are met
/// as the scene has them, rigid and smooth.
void feelTool(const ServoScene& scene, HapticState& state, const StepConfig& config, ForceResult& result) noexcept;

/// What the tool gives a body.
[[nodiscard]] Push pushOfTool(const HapticState& state, std::size_t body) noexcept;

/// How it is held in this tick, 0 for no tool. True: otherwise than `tool` says.
[[nodiscard]] bool describeTool(const HapticState& state, ToolState& tool) noexcept;

}  // namespace haptics
