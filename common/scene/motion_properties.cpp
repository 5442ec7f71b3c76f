#include "common/scene/motion_properties.h"

#include "common/maths/rotation.h"

namespace haptics {
namespace {

void addCount(Hasher& h, std::size_t count) { h.add(static_cast<std::uint64_t>(count)); }

}  // namespace

Pose jawPose(const JawProperties& jaws, Vec3 place, double opening_rad) noexcept {
  const double side = glm::dot(glm::cross(jaws.axis, jaws.reach), place - jaws.hinge_m) > 0 ? 0.5 : -0.5;
  const Quat turned = rotationBy(side * opening_rad * jaws.axis);
  return {turned, jaws.hinge_m - turned * jaws.hinge_m};
}

void addTo(Hasher& h, const MotionProperties& p) {
  h.add(p.mass_kg);
  addCount(h, p.inertia ? 1 : 0);
  if (p.inertia) {
    h.add(p.inertia->centre_m);
    h.add(p.inertia->moments);
    h.add(p.inertia->products);
  }
  h.add(p.gravity_m_per_s2);
  h.add(p.linearDamping_per_s).add(p.angularDamping_per_s);
  h.add(p.spring.stiffness_N_per_m).add(p.spring.damping_Ns_per_m);
  h.add(p.spring.stiffness_Nm_per_rad).add(p.spring.damping_Nms_per_rad);
  addCount(h, p.joint ? static_cast<std::size_t>(p.joint->kind) : 0);
  if (p.joint) {
    h.add(p.joint->anchor_m);
    h.add(p.joint->axis);
    h.add(p.joint->lowest).add(p.joint->highest);
  }
  addCount(h, p.planes.size());
  for (const PlaneProperties& plane : p.planes) {
    h.add(plane.normal);
    h.add(plane.offset_m).add(plane.friction).add(plane.rolling_m);
  }
  constexpr std::size_t kCollision = 10, kFixed = 11, kTool = 12, kJaws = 17;  // beyond those of all other properties
  if (p.collision) {
    addCount(h, kCollision);
    h.add(p.collision->friction).add(p.collision->rolling_m);
  }
  if (p.fixed) addCount(h, kFixed);
  if (p.tool) {
    addCount(h, kTool);
    h.add(p.tool->spacing_m).add(p.tool->torsion_Nm_per_rad);
    if (p.tool->jaws) {
      addCount(h, kJaws);
      h.add(p.tool->jaws->hinge_m);
      h.add(p.tool->jaws->axis);
      h.add(p.tool->jaws->reach);
      h.add(p.tool->jaws->grip_Nm_per_rad);
    }
  }
}

}  // namespace haptics
