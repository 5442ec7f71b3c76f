#include "haptic_server/motion/coupling.h"

#include <algorithm>

namespace haptics {
namespace {

/// Of a push of 1 N at an arm (principal frame, from the centre of mass): the most that the place then accelerates.
[[nodiscard]] double freedomAt(const MassProperties& mass, Vec3 arm) {
  const Vec3 squares = arm * arm;
  const Vec3 across(squares.y + squares.z, squares.z + squares.x, squares.x + squares.y);
  return 1 / mass.mass_kg + glm::dot(across, 1.0 / mass.moments);
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

double leastFeltMass_kg(const RigidBody& body, std::span<const Vec3f> vertices) {
  if (body.freedom == Freedom::kSlider) return body.mass.mass_kg;
  double most = 0;
  for (const Vec3f vertex : vertices) {
    const Vec3 place(vertex);
    most = std::max(most, body.freedom == Freedom::kHinge
                              ? freedomOnHinge(body, place)
                              : freedomAt(body.mass, glm::conjugate(body.mass.principal) * (place - body.mass.centre)));
  }
  return 1 / most;
}

}  // namespace haptics
