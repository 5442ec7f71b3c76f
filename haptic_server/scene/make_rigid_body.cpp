#include "haptic_server/scene/make_rigid_body.h"

#include <algorithm>
#include <string>

#include "haptic_server/engine/motion/solid.h"

namespace haptics {
namespace {

Result<MassProperties> evenlyFilled(double mass_kg, const TriMesh& mesh, bool closed) {
  const Solid solid = solidOf(mesh.vertices, mesh.triangles, closed);
  switch (solid.defect) {
    case SolidDefect::kOpen:
      return refused("inertia", "is missing, and the mesh is open: " + std::to_string(solid.openSides) +
                                    " triangles' sides have no other; give an inertia, or close the mesh");
    case SolidDefect::kInsideOut:
      return refused("inertia", "is missing, and the mesh is inside out; give an inertia, or turn its triangles over");
    case SolidDefect::kFlat:
      return refused("inertia", "is missing, and the mesh encloses no volume; give an inertia");
    case SolidDefect::kNone:
      break;
  }
  MassProperties mass;
  const double density = mass_kg / solid.volume_m3;
  if (spreadMass(mass_kg, solid.centre, density * solid.inertia, mass) == MassDefect::kNone) return mass;
  return refused("inertia", "is missing, and that of the mesh is none that a body has; give an inertia");
}

Result<MassProperties> asGiven(double mass_kg, const GivenInertia& given) {
  const Vec3 m = given.moments;
  const Vec3 p = given.products;
  MassProperties mass;
  switch (spreadMass(mass_kg, given.centre_m, {{m.x, p.z, p.y}, {p.z, m.y, p.x}, {p.y, p.x, m.z}}, mass)) {
    case MassDefect::kNone:
      return mass;
    case MassDefect::kBeyond:
      return refused("inertia", "has a principal moment that is more than the other two together, as no body has");
    default:
      return refused("inertia", "has a principal moment that is not above 0; check its products");
  }
}

}  // namespace

Result<RigidBody> rigidBodyFrom(const MotionProperties& properties, const TriMesh& mesh, bool closed) {
  auto mass = properties.inertia ? asGiven(properties.mass_kg, *properties.inertia)
                                 : evenlyFilled(properties.mass_kg, mesh, closed);
  if (!mass) return tl::unexpected<Error>(std::move(mass.error()));
  RigidBody body;
  body.mass = *mass;
  body.gravity_m_per_s2 = properties.gravity_m_per_s2;
  body.linearDamping_per_s = properties.linearDamping_per_s;
  body.angularDamping_per_s = properties.angularDamping_per_s;
  const SpringProperties& spring = properties.spring;
  body.spring = {spring.stiffness_N_per_m, spring.damping_Ns_per_m, spring.stiffness_Nm_per_rad,
                 spring.damping_Nms_per_rad};
  if (properties.joint) {
    const bool hinge = properties.joint->kind == JointProperties::Kind::kHinge;
    body.freedom = hinge ? Freedom::kHinge : Freedom::kSlider;
    body.joint = {properties.joint->anchor_m, properties.joint->axis, properties.joint->lowest,
                  properties.joint->highest};
  }
  body.planeCount = std::min(properties.planes.size(), kMaxPlanes);
  for (std::size_t i = 0; i < body.planeCount; ++i) {
    const PlaneProperties& plane = properties.planes[i];
    body.planes[i] = {plane.normal, plane.offset_m, plane.friction, plane.rolling_m};
  }
  return body;
}

}  // namespace haptics
