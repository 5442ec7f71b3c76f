#include "haptic_server/engine/step/soft_contact.h"

#include <limits>

namespace haptics {

Obstruction firstObstruction(const HapticState& state, std::size_t body, Vec3 from, Vec3 to,
                             Allowance& allowance) noexcept {
  Obstruction first;
  const double way_m = glm::distance(from, to);
  for (std::size_t i = 0; i < state.objects.count; ++i) {
    const Body& other = state.bodies[i];
    const double reach_m = other.surface->radius_m() + way_m;
    if (i == body || other.pendingRemoval || squaredLength(from - other.centre) > reach_m * reach_m) continue;
    if (dentsOf(state, i).count > 0) continue;
    const Crossing met = other.surface->firstCrossing(other.frame.toLocal(from), other.frame.toLocal(to), allowance);
    if (met && (!first.crossing || met.time < first.crossing.time)) first = {i, met, glm::mix(from, to, met.time)};
  }
  return allowance.isSpent() ? Obstruction{} : first;
}

void settleOn(const HapticState& state, std::size_t index, const DentSolver::Nearest& at,
              ContactResult& contact) noexcept {
  const Body& body = state.bodies[index];
  contact.alongNormal = false;
  contact.ihip = body.frame.toWorld(at.foot.point);
  contact.normal = body.frame.rotate(at.normal);
  contact.penetration_m = glm::distance(contact.ihip, state.estimate.hip);
  contact.primitive = primitiveOf(*body.surface, at.foot);
  contact.triangle = at.foot.triangle;
}

void lose(HapticState& state, ContactResult& contact) noexcept {
  state.release();
  contact.touching = contact.alongNormal = false;
  contact.body = -1;
  contact.ihip = state.estimate.hip;
  contact.normal = Vec3(0);
  contact.penetration_m = 0;
  contact.primitive = {};
  contact.triangle = kNoTriangle;
}

void loseTo(const Obstruction& met, HapticState& state, ContactResult& contact) noexcept {
  lose(state, contact);
  if (state.now.adopted) state.limits.slew.begin();  // the edit may have put it there
  const Body& other = state.bodies[met.body];
  contact.touching = true;
  contact.body = static_cast<int>(met.body);
  contact.ihip = met.point;
  contact.normal = other.frame.rotate(other.surface->faceNormal(met.crossing.triangle) * double(met.crossing.side));
  contact.penetration_m = glm::distance(contact.ihip, state.estimate.hip);
  contact.primitive = primitiveOf(*other.surface, ClosestPoint{met.crossing.triangle});
  contact.triangle = met.crossing.triangle;
}

FactorSample varyingSoftnessAt(const ServoObject& object, const HapticState& state, std::size_t body,
                               std::uint32_t triangle, const Vec3& place) noexcept {
  FactorSample sample = factorAt(*object.detail->softness, object, state.bodies[body], triangle, place,
                                 std::numeric_limits<double>::infinity());
  sample.gradient = alongContact(state, sample.gradient);
  return sample;
}

double deformedBulge_m(const ServoScene& scene, const HapticState& state, std::size_t body, std::uint32_t triangle,
                       Vec3 place, double bulge_m) noexcept {
  if (!(bulge_m > 0)) return 0;
  const double softness = softnessAt(scene, state, body, triangle, place).value;
  return bulge_m *
         (1 - scene.objects[body].tissue->share(state.objects[body].stiffness.value().spring_N_per_m, softness));
}

}  // namespace haptics
