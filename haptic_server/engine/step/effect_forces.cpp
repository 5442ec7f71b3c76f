#include "haptic_server/engine/step/effect_forces.h"

#include <algorithm>
#include <utility>

#include "haptic_server/engine/step/separation_speed.h"
#include "haptic_server/engine/step/tap.h"

namespace haptics {
namespace {

constexpr NearMesh kNoMesh;

/// By which the frame of a body that moves carries the place (world) in this tick.
[[nodiscard]] Vec3 carriedWay(const Body& body, Vec3 place) noexcept {
  return place - toWorld(body.previous, toLocal(body.current, place));
}

[[nodiscard]] bool isInFrameOf(const ServoEffect& effect, std::size_t body) noexcept {
  return effect.body == body && !effect.field->isInWorld();
}

/// What was written, or is, of each effect's force.
[[nodiscard]] double writtenPart(const HapticState& state, Vec3 written_N) noexcept {
  return state.limits.within * writtenFraction(written_N, state.limits.unlimited_N);
}

/// What the last force of each gave the hand on the way to here is its object's.
void accountEnergy(HapticState& state, double part, Vec3 way) noexcept {
  for (const EffectMemory& effect : state.effects.all())
    state.energy.give(effect.object, part * glm::dot(effect.force_N, way));
}

[[nodiscard]] bool isOn(const ServoEffect& effect, const StepInput& input, const ContactResult& contact) noexcept {
  switch (effect.field->trigger()) {
    case Effect::Trigger::kAlways:
      break;
    case Effect::Trigger::kTouch:
      return contact.touching && static_cast<std::size_t>(contact.body) == effect.body;
    case Effect::Trigger::kButton:
      return input.device.status.buttons != 0 && !input.device.status.does(HandAction::kNoOther);
  }
  return true;
}

}  // namespace

void adoptEffects(const ServoScene& next, std::span<const BodyOrigin> origins, std::span<const Body> bodies,
                  std::span<const MovingBody> moving, HapticState& state) noexcept {
  const std::size_t countBefore = state.effects.count;
  std::array<EffectMemory, kMaxEffects> now{};
  std::size_t count = 0;
  std::size_t kept = 0;
  std::array<bool, kMaxEffects> staysInFrame{};
  for (const ServoEffect& effect : next.effects) {
    if (count == now.size()) break;
    EffectMemory& memory = now[count++];
    memory.object = next.objects[effect.body].id;
    memory.number = effect.number;
    for (std::size_t i = 0; i < countBefore; ++i) {
      const EffectMemory& its = state.effects[i];
      if (its.object != memory.object || its.number != memory.number) continue;
      const EffectField& before = *state.scene->effects[i].field;
      const bool goesOn = effect.field->goesOnFrom(before);
      if (goesOn) memory = its;
      staysInFrame[i] = effect.field->isInWorld() == before.isInWorld();
      memory.force_N = staysInFrame[i] ? its.force_N : Vec3(0);
      if (!goesOn) continue;
      effect.field->takeOver(before, memory);
      const int origin = origins[effect.body].before;
      const bool stays =
          effect.field->isInWorld() ||
          (origin >= 0 && bodies[effect.body].current == state.bodies[static_cast<std::size_t>(origin)].current);
      if (&before == effect.field.get() && stays) ++kept;
    }
  }
  for (std::size_t i = 0; i < countBefore; ++i) {
    if (staysInFrame[i] || state.scene->effects[i].field->isInWorld()) continue;
    for (std::size_t k = 0; k < moving.size(); ++k) {
      if (next.objects[moving[k].body].id == state.effects[i].object)
        state.effectsTaken_N[k] += state.effects[i].force_N;
    }
  }
  state.now.effectsEdited = state.now.effectsEdited || kept != count || count != countBefore;
  state.effects.count = count;
  std::copy_n(now.begin(), count, state.effects.items.begin());
  state.effectsFelt = {};
}

void addEffectForces(const ServoScene& scene, HapticState& state, const StepConfig& config, const StepInput& input,
                     ForceResult& result) noexcept {
  const double part = writtenPart(state, state.energy.written_N());
  const Vec3 way = input.device.position - state.estimate.measured;
  accountEnergy(state, part, way);
  const Vec3 hip = state.estimate.hip;
  const Vec3 velocity = state.estimate.velocity.velocity();
  EffectsFelt all;
  if (state.features.taps) all = feelTap(scene, state, config, result.contact, part, way);
  all.withinBefore = std::exchange(state.limits.within, 1);
  for (std::size_t i = 0; i < state.effects.count; ++i) {
    EffectMemory& memory = state.effects[i];
    const ServoEffect& effect = scene.effects[i];
    state.effectsBefore_N[i] = memory.force_N;
    EffectField::Felt felt;
    if (!isOn(effect, input, result.contact)) {
      felt.jumped = memory.force_N != Vec3(0);
      memory.holds = false;
    } else if (effect.field->isInWorld()) {
      felt = effect.field->felt(memory, hip, velocity, config.period_s, kNoMesh);
    } else {
      const Body& body = state.bodies[effect.body];
      Vec3 onFrame = velocity;
      if (body.moving) {
        const Vec3 carried = carriedWay(body, hip);
        all.carried_m = std::max(all.carried_m, glm::length(carried));
        onFrame -= carried / config.period_s;
      }
      const Vec3 here = body.frame.toLocal(hip);
      Allowance& allowance = result.contact.work.allowance;
      const Vec3 relative = body.frame.toLocalDirection(onFrame);
      if (!effect.field->isOfMesh()) {
        felt = effect.field->felt(memory, here, relative, config.period_s, kNoMesh);
      } else if (effect.field->isTexture()) {
        const bool touched = result.contact.touching && static_cast<std::size_t>(result.contact.body) == effect.body;
        const Vec3 normal = touched ? result.contact.normal : Vec3(0);
        felt = effect.field->feltAlong(memory, state.texture, body.frame.toLocalDirection(normal),
                                       glm::dot(result.force.contact, normal), relative);
      } else if (const NearMesh mesh = effect.field->near(*body.surface, here, allowance); allowance.isSpent()) {
        state.fallBehind(result.contact.work);
      } else {
        felt = effect.field->felt(memory, here, relative, config.period_s, mesh);
      }
      felt.force_N = body.frame.rotate(felt.force_N);
    }
    if (effect.field->isActive()) {
      EffectField::Felt weaker = felt;  // of which alone the address is taken: 10 ns of all others
      EffectField::keepToBudget(memory, weaker, config.period_s, part * glm::dot(memory.force_N, way));
      felt = weaker;
    }
    memory.force_N = felt.force_N;
    all.force_N += felt.force_N;
    all.stiffness.spring_N_per_m += effect.field->stiffness().spring_N_per_m;
    all.stiffness.damping_Ns_per_m += effect.field->stiffness().damping_Ns_per_m;
    all.byTime_N += felt.byTime_N;
    if (felt.jumped) state.limits.slew.begin();
  }
  state.effectsFelt = all;
  result.force.contact += all.force_N;
}

void shareRest(HapticState& state, double withinBefore) noexcept {
  const EditSlew& slew = state.limits.slew;
  for (std::size_t k = 0; k < state.moving.count; ++k) {
    MovingBody& moving = state.moving[k];
    Vec3 change_N = state.now.adopted ? -withinBefore * state.effectsTaken_N[k] : Vec3(0);
    for (std::size_t i = 0; i < state.effects.count; ++i) {
      if (isInFrameOf(state.scene->effects[i], moving.body))
        change_N += state.limits.within * state.effects[i].force_N - withinBefore * state.effectsBefore_N[i];
    }
    moving.effectsRest_N = slew.left() * (moving.effectsRest_N - slew.taken() * change_N);
  }
}

Push pushOfEffects(const HapticState& state, std::size_t body, Vec3 written_N) noexcept {
  Push push;
  if (!state.features.effects || state.supervision.fault != Fault::kNone) return push;
  push.place_m = state.estimate.hip;
  const double part = writtenPart(state, written_N), rests = writtenFraction(written_N, state.limits.unlimited_N);
  for (std::size_t i = 0; i < state.effects.count; ++i) {
    if (isInFrameOf(state.scene->effects[i], body)) push.force_N -= part * state.effects[i].force_N;
  }
  const auto all = state.moving.all();
  const auto moving = std::ranges::find(all, body, &MovingBody::body);
  if (moving != all.end()) push.force_N -= rests * moving->effectsRest_N;
  return push;
}

}  // namespace haptics
