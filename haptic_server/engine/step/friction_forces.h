#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "haptic_server/engine/step/force_result.h"
#include "haptic_server/engine/step/haptic_state.h"
#include "haptic_server/engine/step/servo_scene.h"

namespace haptics {

/// A surface that the IHIP is pressed against; world frame.
struct PressedSurface {
  std::size_t body = 0;
  std::uint32_t triangle = 0;
  Vec3 normal{0};                          ///< N_s, unit, towards the hand.
  double pressing_N = 0;                   ///< Along it, not negative.
  const TriangleRecord* dented = nullptr;  ///< The triangle as dentedTriangle() has it, where that is known.
};

/// Stick and slide (paper 4.2) on each of the surfaces that hold the IHIP, into the result's friction.
///
/// Where there are several, each has its own mu_i, normal force N_i and sticking point: along a groove of two planes the
/// hand slides against mu_1 N_1 + mu_2 N_2, which is more than mu |N_1 + N_2|. A surface is known again from tick to tick
/// by its normal, whichever of them pushes most.
///
/// @param ihip  World, m.
/// @param pressed  At least one, at most ContactState::kMaxHolding; the first is that to which the contact belongs.
void computeFriction(const ServoScene& scene, HapticState& state, const StepConfig& config, const Vec3& ihip,
                     std::span<const PressedSurface> pressed, ForceResult& result) noexcept;

}  // namespace haptics
