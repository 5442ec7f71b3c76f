#pragma once

#include <cstddef>
#include <cstdint>

#include "common/deform/triangle_map.h"
#include "haptic_server/engine/geometry/dented_surface.h"
#include "haptic_server/engine/step/body_dents.h"

namespace haptics {

/// Whether a body of the scene that has a detail is felt elsewhere than where its fields are given.
[[nodiscard]] inline bool isDeformed(const ServoScene& scene, const HapticState& state, std::size_t body) noexcept {
  const ServoObject& object = scene.objects[body];
  return object.detail->material || (object.tissue && state.dents.count > 0);
}

/// A triangle of a body, as dents have it. Object frame.
[[nodiscard]] inline TriangleRecord dentedTriangle(const ServoScene& scene, const HapticState& state, std::size_t body,
                                                   std::uint32_t triangle) noexcept {
  const TriangleRecord& atRest = state.bodies[body].surface->triangle(triangle);
  const SoftTissue* tissue = scene.objects[body].tissue.get();
  return tissue == nullptr ? atRest : dented(atRest, dentsOf(state, body).all(), tissue->falloff);
}

/// From such a triangle to where it is on the material.
[[nodiscard]] inline TriangleMap mapToMaterial(const ServoScene& scene, const HapticState& state, std::size_t body,
                                               std::uint32_t triangle, const TriangleRecord& dented) noexcept {
  const TriangleRecord& atRest = state.bodies[body].surface->triangle(triangle);
  return {cornersOf(dented), cornersOf(atRest, scene.objects[body].detail->material.get())};
}

}  // namespace haptics
