#include <algorithm>

#include "haptic_server/engine/force/output_chain.h"
#include "haptic_server/engine/step/body_dents.h"
#include "haptic_server/engine/step/groove_shading.h"
#include "haptic_server/engine/step/soft_contact.h"
#include "haptic_server/engine/step/surface_forces.h"
#include "haptic_server/engine/surface/force_shading.h"

namespace haptics {

/// Shades several bodies that hold the IHIP.
bool SurfaceForceModel::shadeTogether(SurfaceContact& touch) noexcept {
  Vec3 ihip = contact_.ihip;
  if (!shadeGroove(scene_, state_, ihip, contact_.work)) return false;
  held_m_ = ihip - state_.estimate.hip;
  touch.geometric_m = glm::length(held_m_);
  if (touch.geometric_m > 0) touch.normal = held_m_ / touch.geometric_m;
  return true;
}

bool SurfaceForceModel::shadeAt(SurfaceContact& touch, const ClosestPoint& foot, int side) const noexcept {
  const Body& body = state_.bodies[touch.body];
  const ShadingNormals& normals = *detail(touch.body)->shading;
  const Vec3 h = body.frame.toLocal(touch.from);
  const SoftTissue* tissue = object(touch.body).tissue.get();
  const ShadedPoint point = tissue == nullptr ? shade(*body.surface, normals, foot, h, touch.geometric_m * side)
                            : isTouched(touch.body) && state_.deformedContact.shaded.weight > 0
                                ? state_.deformedContact.shaded
                                : shadeDented(touch, *tissue, foot, h, touch.geometric_m * side);
  if (!(point.weight > 0)) return false;
  touch.triangle = point.triangle;
  const Vec3 smooth = body.frame.rotate(point.normal) * double(side);
  touch.normal = point.weight < 1 ? glm::normalize(glm::mix(touch.normal, smooth, point.weight)) : smooth;
  touch.geometric_m = glm::mix(touch.geometric_m, point.depth_m * side, point.weight);
  touch.bulge_m = point.bulge_m * side * point.weight;
  if (tissue != nullptr) {
    touch.bulge_m = deformedBulge_m(scene_, state_, touch.body, touch.triangle, touch.ihip(), touch.bulge_m);
  }
  return true;
}

ShadedPoint SurfaceForceModel::shadeDented(const SurfaceContact& touch, const SoftTissue& tissue,
                                           const ClosestPoint& foot, const Vec3& h, double depth_m) const noexcept {
  return shade(*state_.bodies[touch.body].surface, *detail(touch.body)->shading, dentsOf(state_, touch.body).all(),
               tissue.falloff, foot, h, depth_m);
}

/// Between one body and several, whose bulges are felt one by one before they hold the IHIP together, the whole of the
/// springs' force fades.
void SurfaceForceModel::fadeSwitch() noexcept {
  ShadingFade& fade = memory_.fade;
  if (memory_.object == 0) fade.left_N = Vec3(0);
  const Vec3 now_N = result_.force.spring;
  if (switched_)
    fade.left_N = limitMagnitude(fade.springs_N + fade.change_N - now_N, maxSwitched_N());  // had it gone on
  result_.force.spring += fade.left_N;
  fade.left_N *= 1 - std::min(1.0, config_.period_s / ShadingFade::kTime_s);
  fade.change_N = memory_.object == 0 ? Vec3(0) : result_.force.spring - fade.springs_N;
  fade.springs_N = result_.force.spring;
}

/// What a switch can change: rigid bodies without a bulge are the same alone and together.
double SurfaceForceModel::maxSwitched_N() const noexcept {
  if (state_.features.soft) return config_.maxForce_N;
  double most_N = 0;
  for (std::size_t i = 0; i < state_.objects.count; ++i) {
    if (hasShading(i)) most_N += state_.objects[i].stiffness.value().spring_N_per_m * detail(i)->highest_m();
  }
  return most_N;
}

}  // namespace haptics
