#include "haptic_server/servo/feel_details.h"

#include <algorithm>
#include <array>
#include <span>

#include "haptic_server/servo/feel_friction.h"

namespace haptics {

Feeling::Feeling(const ServoScene& scene, HapticState& state, const StepConfig& config, FeltTick& tick) noexcept
    : scene_(scene),
      state_(state),
      memory_(state.surface),
      config_(config),
      contact_(tick.contact),
      tick_(tick),
      held_m_(tick.contact.ihip - state.hip) {}

void Feeling::addFriction() noexcept {
  memory_.object = 0;
  if (count_ == 0) return forgetFriction();
  const Felt& felt = felt_[0];
  memory_.object = object(felt.body).id;
  const bool onSeveral = state_.contact.holdingCount > 1 && isTouched(felt.body);
  if (!onSeveral && (detail(felt.body) == nullptr || !detail(felt.body)->friction)) {
    forgetFriction();
    return;
  }
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

void Feeling::forgetFriction() noexcept {
  if (memory_.friction[0].object != 0) memory_.friction = {};
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

void Feeling::describe() noexcept {
  ForceComponents& force = tick_.force;
  force.contact = force.spring + force.damping + (force.friction + force.texture);
  memory_.frictionForce_N = force.friction;
  if (count_ == 0) return;
  const Felt& felt = felt_[0];
  const Body& body = state_.bodies[felt.body];
  contact_.ihip = felt.ihip();
  contact_.normal = felt.normal;
  contact_.penetration_m = felt.depth_m;
  if (!contact_.touching) {
    contact_.touching = true;
    contact_.body = static_cast<int>(felt.body);
    contact_.primitive = {PrimitiveKind::kPolygon, 0, body.surface->canonical(felt.triangle)};
  }
  tick_.height_m = felt.height_m;
}

}  // namespace haptics
