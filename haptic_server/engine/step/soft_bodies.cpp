#include "haptic_server/engine/step/soft_bodies.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "haptic_server/engine/step/held_springs.h"
#include "haptic_server/engine/step/joint_dent_solver.h"
#include "haptic_server/engine/step/relaxing_dents.h"

namespace haptics {
namespace {

/// The dents leave the HIP outside of the one body that holds the IHIP. Where another body is in the way, both decide.
void loseAlone(const ServoScene& scene, HapticState& state, const StepConfig& config, ForceResult& tick) noexcept {
  const Obstruction met = firstObstruction(state, static_cast<std::size_t>(tick.contact.body), tick.contact.ihip,
                                           state.estimate.hip, tick.contact.work.allowance);
  if (!met.crossing) return lose(state, tick.contact);
  state.denting.isHeldUp = true;
  deformTogether(scene, state, config, tick, met);
}

/// The body that the contact belongs to.
template <bool kAmongOthers>
void deformAlone(const ServoScene& scene, HapticState& state, const StepConfig& config, ForceResult& tick) noexcept {
  ContactResult& contact = tick.contact;
  const auto index = static_cast<std::size_t>(contact.body);
  const Body& body = state.bodies[index];
  const ContactSurface& held = state.contact.holding[0];
  ClosestPoint atRest;
  atRest.triangle = held.triangle;
  atRest.feature = state.contact.feature;
  atRest.index = contact.primitive.localIndex;
  atRest.point =
      state.contact.mode == ContactState::Mode::kOneSurface ? state.contact.local : body.frame.toLocal(contact.ihip);
  const FactorSample softness = softnessAt(scene, state, index, held.triangle, contact.ihip);
  const PressedBody pressed{.body = index,
                            .atRest = atRest,
                            .side = held.side,
                            .h = body.frame.toLocal(state.estimate.hip),
                            .below = contact.penetration_m > 0,
                            .contact_N_per_m = state.objects[index].stiffness.value().spring_N_per_m,
                            .alone = true,
                            .softness = softness.value};
  DentSolver yielding(scene, state, config, contact.work, pressed);
  if (!yielding.press()) return loseAlone(scene, state, config, tick);
  const DentSolver::Nearest at = yielding.nearestTo(pressed.h);
  if (at.outside) return loseAlone(scene, state, config, tick);
  if constexpr (kAmongOthers) {  // where its hollow ends it goes elsewhere on the body
    const Obstruction met =
        firstObstruction(state, index, contact.ihip, body.frame.toWorld(at.foot.point), contact.work.allowance);
    if (met.crossing) {
      state.denting.isHeldUp = true;
      return deformTogether(scene, state, config, tick, met);
    }
  }
  tick.force.spring += tissuePushAlong_N(scene.objects[index], softness, yielding.elastic_m2(), config);
  state.deformedContact.shaded = yielding.smooth();
  if (state.deformedContact.shaded.weight > 0) {
    state.deformedContact.foot = yielding.foot();
    state.deformedContact.isLevel = state.dents.count == 1;
  }
  settleOn(state, index, at, contact);
}

/// What the dent of the one body that holds the IHIP would come upon.
[[nodiscard]] Obstruction whatIsBelow(const ServoScene& scene, const HapticState& state, const StepConfig& config,
                                      ContactResult& contact) noexcept {
  if (!(contact.penetration_m > 0)) return {};
  const auto index = static_cast<std::size_t>(contact.body);
  const double softness = softnessAt(scene, state, index, state.contact.holding[0].triangle, contact.ihip).value;
  const double yield_m = scene.objects[index].tissue->yield_m(pressedDepth_m(state, index), contact.penetration_m,
                                                              state.objects[index].stiffness.value().spring_N_per_m,
                                                              config.period_s, softness);
  return firstObstruction(state, index, contact.ihip,
                          glm::mix(contact.ihip, state.estimate.hip, std::min(1.0, yield_m / contact.penetration_m)),
                          contact.work.allowance);
}

/// Whether a body has come in the way of a dent that is deeper than there: by an edit or a motion, not by the hand.
[[nodiscard]] bool hasComeBetween(const HapticState& state, const ContactResult& contact,
                                  const Obstruction& below) noexcept {
  constexpr double kByHand_m = 1e-4;
  const double pressed_m = pressedDepth_m(state, static_cast<std::size_t>(contact.body));
  return pressed_m > glm::distance(contact.ihip, below.point) + kByHand_m;
}

/// What of the bodies that hold the IHIP is soft yields.
void yield(const ServoScene& scene, HapticState& state, const StepConfig& config, ForceResult& tick) noexcept {
  const auto isSoft = [&](int body) { return scene.objects[static_cast<std::size_t>(body)].tissue != nullptr; };
  if (state.objects.count == 1) {
    if (isSoft(tick.contact.body)) deformAlone<false>(scene, state, config, tick);
    return;
  }
  if (severalBodiesHold(state)) {
    const auto holding = state.contact.surfaces();
    const bool anySoft = std::ranges::any_of(holding, [&](const ContactSurface& held) { return isSoft(held.body); });
    if (anySoft) deformTogether(scene, state, config, tick, {});
    return;
  }
  if (!isSoft(tick.contact.body)) return;
  const Obstruction below = whatIsBelow(scene, state, config, tick.contact);
  if (!below.crossing) return deformAlone<true>(scene, state, config, tick);
  if (hasComeBetween(state, tick.contact, below)) {
    state.now.contactBroken = true;
    state.limits.slew.begin();
  }
  state.denting.isHeldUp = true;
  deformTogether(scene, state, config, tick, below);
}

/// Without initialisers: not all of a list is used.
struct Where {
  std::size_t body;
  Vec3f centre, displacement;

  bool operator==(const Where&) const = default;
};

[[nodiscard]] Where whereIs(const BodyDent& dent) noexcept {
  return {dent.body, dent.dent.centre, dent.dent.displacement};
}

}  // namespace

void deformAtContact(const ServoScene& scene, HapticState& state, const StepConfig& config,
                     ForceResult& tick) noexcept {
  const ContactResult& contact = tick.contact;
  for (BodyDent& dent : state.dents.all()) {
    dent.pressed = dent.pressed && contact.touching && holdsIhip(state, dent.body);
  }
  std::array<Where, kMaxDents> before;
  const std::size_t countBefore = state.dents.count;
  std::ranges::transform(state.allDents(), before.begin(), &whereIs);
  relaxDents(scene, state, config);
  const bool wasHeldUp = std::exchange(state.denting.isHeldUp, false);
  state.deformedContact = {};
  if (contact.touching) yield(scene, state, config, tick);
  if (state.now.adopted && (wasHeldUp || state.denting.isHeldUp)) {
    state.limits.slew.begin();  // the edit may have put what holds the dent up, or something in front of it
    if (!state.denting.isHeldUp) state.now.contactBroken = true;
  }
  if (!std::ranges::equal(std::span(before).first(countBefore), state.allDents(), {}, {}, &whereIs)) {
    ++state.denting.revision;
  }
}

bool updateDentsState(const HapticState& state, std::uint64_t tick, MotionState& motion) noexcept {
  bool changed = motion.dentCount != state.dents.count;
  motion.dentCount = state.dents.count;
  motion.staying = {};
  motion.sceneRevision = state.adoption.revision;
  for (std::size_t i = 0; i < state.dents.count; ++i) {
    const BodyDent& dent = state.dents[i];
    const ObjectDent now{state.objects[dent.body].id, dent.dent};
    changed = changed || !(now == motion.dent[i]);
    motion.dent[i] = now;
    if (dent.stays) motion.staying[i] = dent.number;
  }
  if (changed) motion.tick = tick;
  return changed;
}

}  // namespace haptics
