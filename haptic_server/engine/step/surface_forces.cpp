#include "haptic_server/engine/step/surface_forces.h"

#include <algorithm>
#include <array>
#include <span>

#include "haptic_server/engine/step/varying_springs.h"

namespace haptics {

/// To the stiffness at what is felt: a bump that reaches the HIP, or a shaded point.
void SurfaceForceModel::varyBeside(const SurfaceContact& touch) noexcept {
  if (!hasVaryingStiffness(touch.body)) return;
  state_.objects[touch.body].stiffness.vary(
      stiffnessFactorAt(object(touch.body), state_.bodies[touch.body], touch.triangle, touch.ihip()).value);
}

void SurfaceForceModel::addForce(const SurfaceContact& touch) noexcept {
  const Stiffness k = stiffness(touch);
  const auto along = springDamper(touch.depth_m, touch.normal, touch.speed_m_per_s, k);
  if (!touch.heightOnly && (touch.depth_m > 0 || detail(touch.body) == nullptr)) {
    result_.force.damping += along.damping;
  }
  if (!hasTexture(touch.body)) {
    result_.force.spring += along.spring;
    return;
  }
  const TextureDetail& t = *detail(touch.body)->texture;
  const HeightSample relief{touch.height_m, touch.gradient};
  const double most = config_.stableLateral_N_per_m;
  const Vec3 way =
      t.law() == Texture::Law::kBump
          ? bumpForce(touch.depth_m, touch.normal,
                      {relief.height_m, relief.gradient * t.slopeShareFor(touch.depth_m, k.spring_N_per_m, most)})
          : hoForce(touch.depth_m, touch.normal, relief, t.gainFor(k.spring_N_per_m, most));
  const Vec3 smooth_m = std::max(0.0, touch.geometric_m) * touch.normal;
  if (!touch.heightOnly) result_.force.spring += k.spring_N_per_m * smooth_m;
  result_.force.texture += k.spring_N_per_m * (way - smooth_m);
}

/// What stiffnesses that vary push along their surfaces.
void SurfaceForceModel::pushAlong() noexcept {
  for (const SurfaceContact& touch : std::span(touches_).first(count_)) {
    if (touch.heightOnly || !hasVaryingStiffness(touch.body)) continue;
    const bool held = isTouched(touch.body);
    if (held && !isShadedRigid(touch.body)) continue;
    FactorSample sample =
        stiffnessFactorAt(object(touch.body), state_.bodies[touch.body], touch.triangle, touch.ihip());
    sample.gradient -= touch.normal * glm::dot(sample.gradient, touch.normal);
    if (held) {
      sample.gradient = belowShaded(object(touch.body), state_.bodies[touch.body], touch.triangle, touch.depth_m,
                                    touch.normal, sample.gradient);
    }
    result_.force.spring += haptics::pushAlong_N(*detail(touch.body)->stiffness, sample,
                                                 state_.objects[touch.body].stiffness.mean().spring_N_per_m,
                                                 touch.depth_m * touch.depth_m, config_);
  }
  const auto holding = state_.contact.surfaces();
  const bool byCore = contact_.touching && !holding.empty() && holding.front().body == contact_.body;
  if (!byCore || (!severalBodiesHold(state_) && isShadedRigid(touches_[0].body))) return;
  result_.force.spring += contactPushAlong_N(scene_, state_, config_, held_m_, std::max(0.0, touches_[0].depth_m));
}

/// On each surface that holds the IHIP, with its part of what presses.
void SurfaceForceModel::computeFrictionOnEach(const PressedSurface& all, const Vec3& ihip) noexcept {
  const auto holding = state_.contact.surfaces();
  std::array<PressedSurface, ContactState::kMaxHolding> pressed;
  const Vec3 springs_N = activeSprings(state_).force_N(held_m_);
  double together_N2 = 0;
  for (std::size_t k = 0; k < holding.size(); ++k) {
    const auto body = static_cast<std::size_t>(holding[k].body);
    pressed[k] = {body, holding[k].triangle, heldNormal(state_, k), std::max(0.0, partOf(state_, k, springs_N))};
    together_N2 += pressed[k].pressing_N * glm::dot(pressed[k].normal, springs_N);
  }
  // Parts add up to the springs' force, but for normals that are too close together to tell them apart.
  const double first_N = state_.objects[all.body].stiffness.value().spring_N_per_m * glm::length(held_m_);
  const double pressing =
      together_N2 * first_N > 0 ? all.pressing_N / first_N * squaredLength(springs_N) / together_N2 : 0;
  for (PressedSurface& surface : pressed) surface.pressing_N *= pressing;
  computeFriction(scene_, state_, config_, ihip, std::span(pressed).first(holding.size()), result_);
}

}  // namespace haptics
