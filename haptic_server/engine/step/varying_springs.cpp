#include "haptic_server/engine/step/varying_springs.h"

#include <algorithm>
#include <cmath>

#include "common/deform/triangle_map.h"
#include "common/maths/barycentric.h"
#include "haptic_server/engine/step/held_springs.h"

namespace haptics {
namespace {

[[nodiscard]] const SurfaceFactor* stiffnessFactorOf(const ServoObject& object) noexcept {
  return object.detail && object.detail->stiffness ? &*object.detail->stiffness : nullptr;
}

/// Whether a line or vertex of its triangle holds the IHIP, rather than that it is on one in passing: then the way from the
/// HIP is not along the normal.
[[nodiscard]] bool isAtAnEdge(const HapticState& state, Vec3 normal) noexcept {
  constexpr double kMinSine = 1e-3;  // larger than that of rounding
  if (state.contact.mode != ContactState::Mode::kOneSurface || state.contact.feature == Feature::kPolygon) return false;
  const Vec3 penetration_m = state.contact.ihip - state.estimate.hip;
  const Vec3 aside_m = penetration_m - normal * glm::dot(penetration_m, normal);
  return squaredLength(aside_m) > kMinSine * kMinSine * squaredLength(penetration_m);
}

/// Direction of the triangle's line that the IHIP is on.
[[nodiscard]] Vec3 lineOf(const Body& body, std::uint32_t triangle, Vec3 ihip) noexcept {
  const TriangleRecord& t = body.surface->triangle(triangle);
  const Vec3 share = barycentric(t.corner(0), t.corner(1), t.corner(2), body.frame.toLocal(ihip));
  int opposite = share[1] < share[0] ? 1 : 0;
  if (share[2] < share[opposite]) opposite = 2;
  const int from = nextCorner(opposite);
  return unitOrZero(body.frame.rotate(t.corner(nextCorner(from)) - t.corner(from)));
}

}  // namespace

FactorSample factorAt(const SurfaceFactor& factor, const ServoObject& object, const Body& body, std::uint32_t triangle,
                      Vec3 place, double most) noexcept {
  FactorSample sample =
      factor.sample(body.surface->triangle(triangle), body.frame.toLocal(place), object.detail->material.get(), most);
  sample.gradient = body.frame.rotate(sample.gradient);
  return sample;
}

FactorSample stiffnessFactorAt(const ServoObject& object, const Body& body, std::uint32_t triangle,
                               Vec3 place) noexcept {
  return factorAt(*object.detail->stiffness, object, body, triangle, place, object.highestFactor);
}

void varyStiffness(const ServoScene& scene, HapticState& state) noexcept {
  for (const ContactSurface& held : state.contact.surfaces()) {
    const auto i = static_cast<std::size_t>(held.body);
    if (stiffnessFactorOf(scene.objects[i]) == nullptr) continue;
    state.objects[i].stiffness.vary(
        stiffnessFactorAt(scene.objects[i], state.bodies[i], held.triangle, state.contact.ihip).value);
  }
}

Vec3 pushAlong_N(const SurfaceFactor& factor, const FactorSample& sample, double spring_N_per_m, double squared_m2,
                 const StepConfig& config) noexcept {
  const double lateral = factor.lateralStiffness_N_per_m(spring_N_per_m, std::sqrt(squared_m2));
  const double part = lateral > config.stableLateral_N_per_m ? config.stableLateral_N_per_m / lateral : 1;
  return -part * spring_N_per_m * squared_m2 / 2 * sample.gradient;
}

Vec3 alongContact(const HapticState& state, Vec3 direction) noexcept {
  const auto holding = state.contact.surfaces();
  if (holding.empty() || holding.size() > 2) return Vec3(0);
  const ContactSurface& first = holding.front();
  const Vec3 normal = normalOf(state, first);
  if (holding.size() == 2) {
    const Vec3 groove = glm::cross(normal, normalOf(state, holding[1]));
    const double squaredSine = squaredLength(groove);
    if (squaredSine > kMinSquaredSine) return groove * (glm::dot(direction, groove) / squaredSine);
  } else if (isAtAnEdge(state, normal)) {
    if (state.contact.feature == Feature::kVertex) return Vec3(0);
    const Vec3 line = lineOf(state.bodies[static_cast<std::size_t>(first.body)], first.triangle, state.contact.ihip);
    return line * glm::dot(direction, line);
  }
  return direction - normal * glm::dot(direction, normal);
}

Vec3 belowShaded(const ServoObject& object, const Body& body, std::uint32_t triangle, double depth_m, Vec3 normal,
                 Vec3 gradient) noexcept {
  const TriangleRecord& t = body.surface->triangle(triangle);
  const ShadingRecord& normals = (*object.detail->shading)[triangle];
  const double side = glm::dot(body.frame.rotate(t.areaNormal()), normal) < 0 ? -1 : 1;
  TriangleMap::Corners above, below;
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    above[i] = body.frame.rotate(t.corner(k));
    below[i] = above[i] - side * depth_m * body.frame.rotate(normals.normal(k));
  }
  const Vec3 there = TriangleMap(below, above).gradient(gradient);
  return there - normal * glm::dot(there, normal);
}

Vec3 contactPushAlong_N(const ServoScene& scene, const HapticState& state, const StepConfig& config, Vec3 penetration_m,
                        double depth_m) noexcept {
  const auto holding = state.contact.surfaces();
  const bool several = severalBodiesHold(state);
  const auto weight = activeSprings(state).weights(penetration_m);
  Vec3 sum_N(0);
  for (std::size_t k = 0; k < holding.size(); ++k) {
    const auto i = static_cast<std::size_t>(holding[k].body);
    const SurfaceFactor* factor = stiffnessFactorOf(scene.objects[i]);
    if (factor == nullptr) continue;
    FactorSample sample = stiffnessFactorAt(scene.objects[i], state.bodies[i], holding[k].triangle, state.contact.ihip);
    sample.gradient = alongContact(state, sample.gradient);
    const double squared_m2 = several ? weight[k] * squaredLength(penetration_m) : depth_m * depth_m;  // of E / k
    sum_N += pushAlong_N(*factor, sample, state.objects[i].stiffness.mean().spring_N_per_m, std::max(0.0, squared_m2),
                         config);
    if (!several) break;
  }
  return sum_N;
}

}  // namespace haptics
