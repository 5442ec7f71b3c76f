#pragma once

#include <cstddef>
#include <cstdint>

#include "haptic_server/engine/step/dent_solver.h"
#include "haptic_server/engine/step/force_result.h"
#include "haptic_server/engine/step/varying_springs.h"

namespace haptics {

// What a contact with soft bodies is made of, whether one of them holds the IHIP or several.

/// What of other bodies is on a straight way that the IHIP goes in a dent of one; world, m. Dented bodies are left out: where
/// they are is not what their hierarchies say. Nothing, where the allowance does not last.
struct Obstruction {
  std::size_t body = 0;
  Crossing crossing;
  Vec3 point{0};
};
[[nodiscard]] Obstruction firstObstruction(const HapticState& state, std::size_t body, Vec3 from, Vec3 to,
                                           Allowance& allowance) noexcept;

/// The IHIP is where a body with its dents is nearest to the HIP.
void settleOn(const HapticState& state, std::size_t body, const DentSolver::Nearest& at,
              ContactResult& contact) noexcept;

/// The dents leave the HIP outside of the body that holds the IHIP: there is no contact.
void lose(HapticState& state, ContactResult& contact) noexcept;

/// What reaches into the dent holds the IHIP instead, where it is met.
void loseTo(const Obstruction& met, HapticState& state, ContactResult& contact) noexcept;

/// softnessAt() where it varies.
[[nodiscard]] FactorSample varyingSoftnessAt(const ServoObject& object, const HapticState& state, std::size_t body,
                                             std::uint32_t triangle, const Vec3& place) noexcept;

/// Of the tissue's stiffness, at a place (world) on the shape at rest; the gradient (1/m, world) along the IHIP's ways. 1
/// where it does not vary.
[[nodiscard]] inline FactorSample softnessAt(const ServoScene& scene, const HapticState& state, std::size_t body,
                                             std::uint32_t triangle, const Vec3& place) noexcept {
  const ServoObject& object = scene.objects[body];
  if (!object.detail || !object.detail->softness) [[likely]]
    return {};
  return varyingSoftnessAt(object, state, body, triangle, place);
}

/// What is left at a place (world) of how far a soft body's smooth surface is before its polygons, m: it yields as what lies
/// below it does.
[[nodiscard]] double deformedBulge_m(const ServoScene& scene, const HapticState& state, std::size_t body,
                                     std::uint32_t triangle, Vec3 place, double bulge_m) noexcept;

/// What the tissue pushes along the surface, where it varies; N, world.
/// @param elastic_m2  DentSolver::elastic_m2().
[[nodiscard]] inline Vec3 tissuePushAlong_N(const ServoObject& object, const FactorSample& softness, double elastic_m2,
                                            const StepConfig& config) noexcept {
  if (softness.gradient == Vec3(0)) [[likely]]
    return Vec3(0);
  return pushAlong_N(*object.detail->softness, softness, object.tissue->stiffness_N_per_m, elastic_m2, config);
}

}  // namespace haptics
