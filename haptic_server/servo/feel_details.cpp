#include "haptic_server/servo/feel_details.h"

#include <algorithm>
#include <array>
#include <span>

#include "haptic_server/servo/edited_objects.h"
#include "haptic_server/servo/varying_springs.h"

namespace haptics {

void Feeling::addSpringDamper() noexcept {
  followStiffness();
  for (std::size_t i = 0; i < count_; ++i) addForce(felt_[i]);
  if (state_.features.varyingStiffness) pushAlong();
  if (severalBodiesHold(state_)) tick_.force.spring += otherSprings_N(state_, held_m_);
  if (count_ > 0 && state_.adoption.bodyCount > 1) fadeSwitch();
}

/// To the stiffness at what is felt: a bump that reaches the HIP, or a shaded point.
void Feeling::varyBeside(const Felt& felt) noexcept {
  if (!hasVaryingStiffness(felt.body)) return;
  state_.objects[felt.body].felt.vary(
      stiffnessFactorAt(object(felt.body), state_.bodies[felt.body], felt.triangle, felt.ihip()).value);
}

/// Moves every object's felt stiffness towards its own.
void Feeling::followStiffness() noexcept {
  if (state_.adoption.lettingGo) fadeHeld(state_, config_, held_m_);
  for (std::size_t i = 0; i < state_.adoption.bodyCount; ++i) {
    const bool isOwn = state_.objects[i].felt.mean() == ownStiffness(scene_, state_, i);
    if (isOwn || (state_.adoption.lettingGo && holdsIhip(state_, i))) continue;
    const auto end = felt_.begin() + static_cast<std::ptrdiff_t>(count_);
    const auto felt = std::find_if(felt_.begin(), end, [i](const Felt& f) { return f.body == i; });
    const bool shares = holdsIhip(state_, i) && severalBodiesHold(state_) && !hasTexture(i);
    const double depth_m = shares ? heldDepth_m(state_, i, held_m_) : felt != end ? felt->depth_m : 0;
    haptics::followStiffness(scene_, state_, config_, i, depth_m, felt != end ? felt->speed_m_per_s : 0);
  }
}

void Feeling::addForce(const Felt& felt) noexcept {
  const Stiffness k = stiffness(felt);
  const auto along = springDamper(felt.depth_m, felt.normal, felt.speed_m_per_s, k);
  if (!felt.heightOnly && (felt.depth_m > 0 || detail(felt.body) == nullptr)) {
    tick_.force.damping += along.damping;
  }
  if (!hasTexture(felt.body)) {
    tick_.force.spring += along.spring;
    return;
  }
  const TextureDetail& t = *detail(felt.body)->texture;
  const Relief relief{felt.height_m, felt.gradient};
  const double most = config_.stableLateral_N_per_m;
  const Vec3 way =
      t.law() == Texture::Law::kBump
          ? bumpForce(felt.depth_m, felt.normal,
                      {relief.height_m, relief.gradient * t.slopePartFor(felt.depth_m, k.spring_N_per_m, most)})
          : hoForce(felt.depth_m, felt.normal, relief, t.gainFor(k.spring_N_per_m, most));
  const Vec3 smooth_m = std::max(0.0, felt.geometric_m) * felt.normal;
  if (!felt.heightOnly) tick_.force.spring += k.spring_N_per_m * smooth_m;
  tick_.force.texture += k.spring_N_per_m * (way - smooth_m);
}

/// What stiffnesses that vary push along their surfaces.
void Feeling::pushAlong() noexcept {
  for (const Felt& felt : std::span(felt_).first(count_)) {
    if (felt.heightOnly || !hasVaryingStiffness(felt.body)) continue;
    const bool held = isTouched(felt.body);
    if (held && !isShadedRigid(felt.body)) continue;
    FactorSample sample = stiffnessFactorAt(object(felt.body), state_.bodies[felt.body], felt.triangle, felt.ihip());
    sample.gradient -= felt.normal * glm::dot(sample.gradient, felt.normal);
    if (held) {
      sample.gradient = belowShaded(object(felt.body), state_.bodies[felt.body], felt.triangle, felt.depth_m,
                                    felt.normal, sample.gradient);
    }
    tick_.force.spring += haptics::pushAlong_N(*detail(felt.body)->stiffness, sample,
                                               state_.objects[felt.body].felt.mean().spring_N_per_m,
                                               felt.depth_m * felt.depth_m, config_);
  }
  const auto holding = state_.contact.surfaces();
  const bool byCore = contact_.touching && !holding.empty() && holding.front().body == contact_.body;
  if (!byCore || (!severalBodiesHold(state_) && isShadedRigid(felt_[0].body))) return;
  tick_.force.spring += contactPushAlong_N(scene_, state_, config_, held_m_, std::max(0.0, felt_[0].depth_m));
}

void Feeling::addFriction() noexcept {
  memory_.object = count_ > 0 ? object(felt_[0].body).id : 0;
  const bool onSeveral = contact_.touching && state_.contact.holdingCount > 1;
  if (count_ == 0 || (!onSeveral && (detail(felt_[0].body) == nullptr || !detail(felt_[0].body)->friction))) {
    if (memory_.friction[0].object != 0) memory_.friction = {};
    return;
  }
  const Felt& felt = felt_[0];
  const auto along = springDamper(felt.depth_m, felt.normal, felt.speed_m_per_s, stiffness(felt));
  const double pressing_N = felt.depth_m > 0 ? std::max(0.0, glm::dot(along.spring + along.damping, felt.normal)) : 0;
  const bool isKnown = felt.body == nowBody_ && felt.triangle == nowTriangle_;
  const PressedSurface all{felt.body, felt.triangle, felt.normal, pressing_N, isKnown ? &now_ : nullptr};
  if (onSeveral) {
    feelFrictionOnEach(all, felt.ihip());
  } else {
    feelFriction(scene_, state_, config_, felt.ihip(), {&all, 1}, tick_);
  }
}

/// On each surface that holds the IHIP, with its part of what presses.
void Feeling::feelFrictionOnEach(const PressedSurface& all, const Vec3& ihip) noexcept {
  const auto holding = state_.contact.surfaces();
  std::array<PressedSurface, ContactState::kMaxHolding> pressed;
  const Vec3 springs_N = springsThatHold(state_).force_N(held_m_);
  double together_N2 = 0;
  for (std::size_t k = 0; k < holding.size(); ++k) {
    const auto body = static_cast<std::size_t>(holding[k].body);
    pressed[k] = {body, holding[k].triangle, heldNormal(state_, k), std::max(0.0, partOf(state_, k, springs_N))};
    together_N2 += pressed[k].pressing_N * glm::dot(pressed[k].normal, springs_N);
  }
  // Parts add up to the springs' force, but for normals that are too close together to tell them apart.
  const double first_N = state_.objects[all.body].felt.value().spring_N_per_m * glm::length(held_m_);
  const double pressing =
      together_N2 * first_N > 0 ? all.pressing_N / first_N * squaredLength(springs_N) / together_N2 : 0;
  for (PressedSurface& surface : pressed) surface.pressing_N *= pressing;
  feelFriction(scene_, state_, config_, ihip, std::span(pressed).first(holding.size()), tick_);
}

}  // namespace haptics
