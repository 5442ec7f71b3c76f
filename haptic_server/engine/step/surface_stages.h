#pragma once

#include <algorithm>

#include "haptic_server/engine/step/edited_objects.h"
#include "haptic_server/engine/step/surface_forces.h"
#include "haptic_server/engine/step/varying_springs.h"

// The stages that every tick with surface properties runs; in a header, so that they are inlined into it. That is worth
// 70 instructions of 1,800.
namespace haptics {

[[gnu::always_inline]] inline void SurfaceForceModel::addShading() noexcept {
  if (!contact_.touching) return;
  SurfaceContact& touch = touches_[count_++];
  touch = {};
  touch.body = static_cast<std::size_t>(contact_.body);
  touch.triangle = contact_.triangle == kNoTriangle ? state_.contact.holding[0].triangle : contact_.triangle;
  touch.from = state_.estimate.hip;
  touch.geometric_m = contact_.penetration_m;
  const bool alongWay = !contact_.alongNormal && exceedsRounding(touch.geometric_m, touch.body);
  touch.normal = alongWay ? (contact_.ihip - state_.estimate.hip) / touch.geometric_m : contact_.normal;
  unshaded_m_ = touch.geometric_m * touch.normal;
  shadeTouched(touch);
  if (state_.features.varyingStiffness && isShadedRigid(touch.body)) varyBeside(touch);
}

/// With force shading where there is a shading normal.
[[gnu::always_inline]] inline void SurfaceForceModel::shadeTouched(SurfaceContact& touch) noexcept {
  const Feature feature =
      contact_.triangle == kNoTriangle ? Feature(state_.contact.feature) : featureOf(contact_.primitive);
  const Vec3 unshaded = touch.normal;
  const double unshaded_m = touch.geometric_m;
  ShadingFade::Mode mode = ShadingFade::Mode::kOff;
  if (severalBodiesHold(state_)) {
    if (shadeTogether(touch)) mode = ShadingFade::Mode::kTogether;
  } else if (state_.features.soft && state_.denting.isHeldUp) {
    mode = ShadingFade::Mode::kBetween;
  } else if (hasShading(touch.body) && state_.contact.mode == ContactState::Mode::kOneSurface &&
             shadeAt(touch, {touch.triangle, feature, contact_.primitive.localIndex}, state_.contact.holding[0].side)) {
    mode = ShadingFade::Mode::kAlone;
  }
  fadeShading(touch, mode, unshaded, unshaded_m);
}

/// Without a step where shading begins, ends or is of another kind.
[[gnu::always_inline]] inline void SurfaceForceModel::fadeShading(SurfaceContact& touch, ShadingFade::Mode mode,
                                                                  Vec3 unshaded, double unshaded_m) noexcept {
  ShadingFade& fade = memory_.fade;
  const Vec3 turn = touch.normal - unshaded;
  const double deepening_m = touch.geometric_m + touch.bulge_m - unshaded_m;
  if (memory_.object == 0) {
    fade = {};
  } else if (mode != fade.mode && std::max<ShadingFade::Mode>(mode, fade.mode) >= ShadingFade::Mode::kBetween) {
    fade.turnLeft = Vec3(0);
    fade.deepeningLeft_m = 0;
    switched_ = true;
  } else if (mode != fade.mode || state_.now.detailEdited) {
    fade.turnLeft += fade.turn - turn;
    fade.deepeningLeft_m += fade.deepening_m - deepening_m;
  }
  fade.mode = mode;
  fade.turn = turn;
  fade.deepening_m = deepening_m;
  if (fade.turnLeft == Vec3(0) && fade.deepeningLeft_m == 0) return;
  touch.normal = unitOrZero(touch.normal + fade.turnLeft);
  touch.geometric_m += fade.deepeningLeft_m;
  const double left = 1 - std::min(1.0, config_.period_s / ShadingFade::kTime_s);
  fade.turnLeft *= left;
  fade.deepeningLeft_m *= left;
}

[[gnu::always_inline]] inline void SurfaceForceModel::addTexture() noexcept {
  if (contact_.touching) {
    SurfaceContact& touch = touches_[0];
    BumpState& bump = state_.bumps[touch.body];
    bump.triangle = touch.triangle;
    bump.clear_m = 0;
    addTextureHeight(touch, bump);
    const Vec3 shaded_m = std::max(0.0, touch.geometric_m) * touch.normal;
    result_.shadingForce_N = stiffness(touch).spring_N_per_m * (shaded_m - unshaded_m_);
  }
  if (state_.features.bumps) computeBumpForces();
}

[[gnu::always_inline]] inline void SurfaceForceModel::addSpringDamper() noexcept {
  updateStiffnesses();
  for (std::size_t i = 0; i < count_; ++i) addForce(touches_[i]);
  if (state_.features.varyingStiffness) pushAlong();
  if (severalBodiesHold(state_)) result_.force.spring += otherSprings_N(state_, held_m_);
  if (count_ > 0 && state_.objects.count > 1) fadeSwitch();
}

/// Moves every object's felt stiffness towards its own.
[[gnu::always_inline]] inline void SurfaceForceModel::updateStiffnesses() noexcept {
  if (state_.adoption.fadingOut) fadeHeld(state_, config_, held_m_);
  for (std::size_t i = 0; i < state_.objects.count; ++i) {
    const bool isOwn = state_.objects[i].stiffness.mean() == ownStiffness(scene_, state_, i);
    if (isOwn || (state_.adoption.fadingOut && holdsIhip(state_, i))) continue;
    const auto end = touches_.begin() + static_cast<std::ptrdiff_t>(count_);
    const auto touch = std::find_if(touches_.begin(), end, [i](const SurfaceContact& f) { return f.body == i; });
    const bool shares = holdsIhip(state_, i) && severalBodiesHold(state_) && !hasTexture(i);
    const double depth_m = shares ? heldDepth_m(state_, i, held_m_) : touch != end ? touch->depth_m : 0;
    updateStiffness(scene_, state_, config_, i, depth_m, touch != end ? touch->speed_m_per_s : 0);
  }
}

[[gnu::always_inline]] inline void SurfaceForceModel::addFriction() noexcept {
  memory_.object = count_ > 0 ? object(touches_[0].body).id : 0;
  const bool onSeveral = contact_.touching && state_.contact.holdingCount > 1;
  if (count_ == 0 || (!onSeveral && (detail(touches_[0].body) == nullptr || !detail(touches_[0].body)->friction))) {
    if (memory_.friction[0].object != 0) memory_.friction = {};
    return;
  }
  const SurfaceContact& touch = touches_[0];
  const auto along = springDamper(touch.depth_m, touch.normal, touch.speed_m_per_s, stiffness(touch));
  const double pressing_N = touch.depth_m > 0 ? std::max(0.0, glm::dot(along.spring + along.damping, touch.normal)) : 0;
  const bool isKnown = touch.body == dentedBody_ && touch.triangle == dentedIndex_;
  const PressedSurface all{touch.body, touch.triangle, touch.normal, pressing_N, isKnown ? &dented_ : nullptr};
  if (onSeveral) {
    computeFrictionOnEach(all, touch.ihip());
  } else {
    computeFriction(scene_, state_, config_, touch.ihip(), {&all, 1}, result_);
  }
}

[[gnu::always_inline]] inline void SurfaceForceModel::writeResult() noexcept {
  ForceComponents& force = result_.force;
  force.contact = force.spring + force.damping + (force.friction + force.texture);
  memory_.frictionForce_N = force.friction;
  if (count_ == 0) return;
  const SurfaceContact& touch = touches_[0];
  const Body& body = state_.bodies[touch.body];
  contact_.ihip = touch.ihip();
  contact_.normal = touch.normal;
  contact_.penetration_m = touch.depth_m;
  if (!contact_.touching) {
    contact_.touching = true;
    contact_.body = static_cast<int>(touch.body);
    contact_.primitive = {PrimitiveKind::kPolygon, 0, body.surface->canonical(touch.triangle)};
  }
  result_.height_m = touch.height_m;
}

}  // namespace haptics
