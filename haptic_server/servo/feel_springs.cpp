#include <algorithm>
#include <span>

#include "haptic_server/servo/edited_objects.h"
#include "haptic_server/servo/feel_details.h"
#include "haptic_server/servo/varying_springs.h"

namespace haptics {

void Feeling::addSpringDamper() noexcept {
  followStiffness();
  for (std::size_t i = 0; i < count_; ++i) addForce(felt_[i]);
  if (state_.anyVaryingStiffness) pushAlong();
  if (severalBodiesHold(state_)) tick_.force.spring += otherSprings_N(state_, held_m_);
  if (count_ > 0 && state_.bodyCount > 1) fadeSwitch();
}

/// To the stiffness at what is felt: a bump that reaches the HIP, or a shaded point.
void Feeling::varyBeside(const Felt& felt) noexcept {
  if (!hasVaryingStiffness(felt.body)) return;
  state_.objects[felt.body].felt.vary(
      stiffnessFactorAt(object(felt.body), state_.bodies[felt.body], felt.triangle, felt.ihip()).value);
}

void Feeling::followStiffness() noexcept {
  if (state_.lettingGo) fadeHeld(state_, config_, held_m_);
  for (std::size_t i = 0; i < state_.bodyCount; ++i) {
    if (state_.lettingGo || !(state_.objects[i].felt.mean() == ownStiffness(scene_, state_, i))) followStiffness(i);
  }
}

void Feeling::followStiffness(std::size_t i) noexcept {
  const bool holds = holdsIhip(state_, i);
  if (state_.lettingGo && holds) return;
  const auto end = felt_.begin() + static_cast<std::ptrdiff_t>(count_);
  const auto felt = std::find_if(felt_.begin(), end, [i](const Felt& f) { return f.body == i; });
  const bool shares = holds && severalBodiesHold(state_) && !hasTexture(i);
  const double depth_m = shares ? heldDepth_m(state_, i, held_m_) : felt != end ? felt->depth_m : 0;
  haptics::followStiffness(scene_, state_, config_, i, depth_m, felt != end ? felt->speed_m_per_s : 0);
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

}  // namespace haptics
