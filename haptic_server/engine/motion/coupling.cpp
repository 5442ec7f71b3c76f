#include "haptic_server/engine/motion/coupling.h"

#include <algorithm>
#include <cmath>

#include "common/interruption/grow.h"

namespace haptics {
namespace {

/// Of a push of 1 N at an arm (principal frame, from the centre of mass), in the direction that serves it best: how the
/// place then accelerates.
[[nodiscard]] double freedomAt(const MassProperties& mass, Vec3 arm) {
  const glm::dmat3 lever(0, arm.z, -arm.y, -arm.z, 0, arm.x, arm.y, -arm.x, 0);
  const Vec3 perMoment = 1.0 / mass.moments;
  const glm::dmat3 turning =
      glm::transpose(lever) * glm::dmat3(perMoment.x, 0, 0, 0, perMoment.y, 0, 0, 0, perMoment.z) * lever;
  // Its largest eigenvalue; one of the three is 0, along the arm.
  const double sum = turning[0][0] + turning[1][1] + turning[2][2];
  const double squares =
      glm::dot(turning[0], turning[0]) + glm::dot(turning[1], turning[1]) + glm::dot(turning[2], turning[2]);
  return 1 / mass.mass_kg + (sum + std::sqrt(std::max(2 * squares - sum * sum, 0.0))) / 2;
}

[[nodiscard]] double freedomOnHinge(const RigidBody& body, Vec3 place) {
  const MassProperties& mass = body.mass;
  const Vec3 axis = body.joint.axis;
  const Vec3 own = glm::conjugate(mass.principal) * axis;
  const double moment = glm::dot(mass.moments * own, own) +
                        mass.mass_kg * squaredLength(glm::cross(axis, mass.centre - body.joint.anchor_m));
  return squaredLength(glm::cross(axis, place - body.joint.anchor_m)) / moment;
}

}  // namespace

double minApparentMass_kg(const RigidBody& body, std::span<const Vec3f> vertices) {
  if (body.freedom == Freedom::kSlider) return body.mass.mass_kg;
  double most = 0;
  forEach(vertices.size(), [&](std::size_t i) {
    const Vec3 place(vertices[i]);
    most = std::max(most, body.freedom == Freedom::kHinge
                              ? freedomOnHinge(body, place)
                              : freedomAt(body.mass, glm::conjugate(body.mass.principal) * (place - body.mass.centre)));
  });
  return 1 / most;
}

GraspSprings graspSprings(const RigidBody& body, double apparentMass_kg, double stiffness_N_per_m, double period_s,
                          int hands) noexcept {
  constexpr double kTicksPerRadian = 5;  // of the torsion's oscillation; fewer leave its damper too large for a tick
  const double share = 1.0 / hands;
  const Vec3 moments = body.mass.moments;
  const double rate_per_s = 1 / (kTicksPerRadian * period_s);
  return {std::min(std::sqrt(stiffness_N_per_m * body.mass.mass_kg), share * apparentMass_kg / (2 * period_s)),
          share * std::min({moments.x, moments.y, moments.z}) * rate_per_s * rate_per_s};
}

}  // namespace haptics
