#include "haptic_server/step/surface_forces.h"

#include <algorithm>
#include <array>
#include <span>

#include "haptic_server/step/edited_objects.h"
#include "haptic_server/step/varying_springs.h"

namespace haptics {

void SurfaceForceModel::addSpringDamper() noexcept {
  updateTouchedStiffness();
  for (std::size_t i = 0; i < count_; ++i) addForce(touches_[i]);
  if (state_.features.varyingStiffness) pushAlong();
  if (severalBodiesHold(state_)) tick_.force.spring += otherSprings_N(state_, held_m_);
  if (count_ > 0 && state_.adoption.bodyCount > 1) fadeSwitch();
}

/// To the stiffness at what is felt: a bump that reaches the HIP, or a shaded point.
void SurfaceForceModel::varyBeside(const SurfaceContact& touch) noexcept {
  if (!hasVaryingStiffness(touch.body)) return;
  state_.objects[touch.body].stiffness.vary(
      stiffnessFactorAt(object(touch.body), state_.bodies[touch.body], touch.triangle, touch.ihip()).value);
}

/// Moves every object's felt stiffness towards its own.
void SurfaceForceModel::updateTouchedStiffness() noexcept {
  if (state_.adoption.fadingOut) fadeHeld(state_, config_, held_m_);
  for (std::size_t i = 0; i < state_.adoption.bodyCount; ++i) {
    const bool isOwn = state_.objects[i].stiffness.mean() == ownStiffness(scene_, state_, i);
    if (isOwn || (state_.adoption.fadingOut && holdsIhip(state_, i))) continue;
    const auto end = touches_.begin() + static_cast<std::ptrdiff_t>(count_);
    const auto touch = std::find_if(touches_.begin(), end, [i](const SurfaceContact& f) { return f.body == i; });
    const bool shares = holdsIhip(state_, i) && severalBodiesHold(state_) && !hasTexture(i);
    const double depth_m = shares ? heldDepth_m(state_, i, held_m_) : touch != end ? touch->depth_m : 0;
    haptics::updateTouchedStiffness(scene_, state_, config_, i, depth_m, touch != end ? touch->speed_m_per_s : 0);
  }
}

void SurfaceForceModel::addForce(const SurfaceContact& touch) noexcept {
  const Stiffness k = stiffness(touch);
  const auto along = springDamper(touch.depth_m, touch.normal, touch.speed_m_per_s, k);
  if (!touch.heightOnly && (touch.depth_m > 0 || detail(touch.body) == nullptr)) {
    tick_.force.damping += along.damping;
  }
  if (!hasTexture(touch.body)) {
    tick_.force.spring += along.spring;
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
  if (!touch.heightOnly) tick_.force.spring += k.spring_N_per_m * smooth_m;
  tick_.force.texture += k.spring_N_per_m * (way - smooth_m);
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
    tick_.force.spring += haptics::pushAlong_N(*detail(touch.body)->stiffness, sample,
                                               state_.objects[touch.body].stiffness.mean().spring_N_per_m,
                                               touch.depth_m * touch.depth_m, config_);
  }
  const auto holding = state_.contact.surfaces();
  const bool byCore = contact_.touching && !holding.empty() && holding.front().body == contact_.body;
  if (!byCore || (!severalBodiesHold(state_) && isShadedRigid(touches_[0].body))) return;
  tick_.force.spring += contactPushAlong_N(scene_, state_, config_, held_m_, std::max(0.0, touches_[0].depth_m));
}

void SurfaceForceModel::addFriction() noexcept {
  memory_.object = count_ > 0 ? object(touches_[0].body).id : 0;
  const bool onSeveral = contact_.touching && state_.contact.holdingCount > 1;
  if (count_ == 0 || (!onSeveral && (detail(touches_[0].body) == nullptr || !detail(touches_[0].body)->friction))) {
    if (memory_.friction[0].object != 0) memory_.friction = {};
    return;
  }
  const SurfaceContact& touch = touches_[0];
  const auto along = springDamper(touch.depth_m, touch.normal, touch.speed_m_per_s, stiffness(touch));
  const double pressing_N = touch.depth_m > 0 ? std::max(0.0, glm::dot(along.spring + along.damping, touch.normal)) : 0;
  const bool isKnown = touch.body == nowBody_ && touch.triangle == nowTriangle_;
  const PressedSurface all{touch.body, touch.triangle, touch.normal, pressing_N, isKnown ? &now_ : nullptr};
  if (onSeveral) {
    computeFrictionOnEach(all, touch.ihip());
  } else {
    computeFriction(scene_, state_, config_, touch.ihip(), {&all, 1}, tick_);
  }
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
  computeFriction(scene_, state_, config_, ihip, std::span(pressed).first(holding.size()), tick_);
}

}  // namespace haptics
