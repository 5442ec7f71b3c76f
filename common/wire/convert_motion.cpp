#include <cmath>
#include <string>
#include <utility>

#include "common/wire/convert.h"
#include "common/wire/convert_properties.h"
#include "common/wire/parts.h"

namespace haptics {
namespace {

constexpr Range kMass{1e-6, 1e4, " kg"};
constexpr Range kGravity{-100, 100, " m/s^2"};
constexpr Range kDampingRate{0, 1e4, " /s"};
constexpr Range kSpring{0, 1e6};
constexpr Range kFriction{0, 10};
constexpr Range kRolling{0, 0.1, " m"};
constexpr Range kMoment{1e-15, 1e6, " kg m^2"};
constexpr Range kTorsion{1e-6, 1e3, " Nm/rad"};
constexpr Range kSpacing{1e-6, kMaxCoordinate_m, " m"};
constexpr int kMaxPlanesOfABody = 4;

Refusal checkDirection(const v1::Vector3& v, const std::string& field) {
  if (vectorFrom(v) == Vec3(0)) return Error{field, "has length 0; give a direction of length 1"};
  return checkUnitVector(v, field);
}

Result<GivenInertia> inertiaFrom(const v1::Inertia& message) {
  if (auto bad = checkPosition(message.centre_m(), "centre_m")) return refuse(bad);
  const v1::Vector3& m = message.moments();
  for (const auto& [value, field] : {std::pair{m.x(), "moments.x"}, {m.y(), "moments.y"}, {m.z(), "moments.z"}}) {
    if (auto bad = checkAbove0(value, kMoment, field)) return refuse(bad);
  }
  const Range products{-kMoment.most, kMoment.most, kMoment.unit};
  if (auto bad = checkVector(message.products(), products, "products")) return refuse(bad);
  return GivenInertia{vectorFrom(message.centre_m()), vectorFrom(m), vectorFrom(message.products())};
}

Result<SpringProperties> springFrom(const v1::PoseSpring& message) {
  const SpringProperties spring{message.stiffness_n_per_m(), message.damping_ns_per_m(), message.stiffness_nm_per_rad(),
                                message.damping_nms_per_rad()};
  for (const auto& [value, field] : {std::pair{spring.stiffness_N_per_m, "stiffness_N_per_m"},
                                     {spring.damping_Ns_per_m, "damping_Ns_per_m"},
                                     {spring.stiffness_Nm_per_rad, "stiffness_Nm_per_rad"},
                                     {spring.damping_Nms_per_rad, "damping_Nms_per_rad"}}) {
    if (auto bad = checkRange(value, kSpring, field)) return refuse(bad);
  }
  return spring;
}

Result<JointProperties> jointFrom(const v1::Joint& message, JointProperties::Kind kind) {
  JointProperties joint{.kind = kind};
  if (auto bad = checkPosition(message.anchor_m(), "anchor_m")) return refuse(bad);
  if (auto bad = checkDirection(message.axis(), "axis")) return refuse(bad);
  const bool hinge = kind == JointProperties::Kind::kHinge;
  const double most = hinge ? kMaxJointAngle_rad : kMaxCoordinate_m;
  const char* unit = hinge ? " rad" : " m";
  joint.lowest = message.has_lowest() ? message.lowest() : -most;
  joint.highest = message.has_highest() ? message.highest() : most;
  if (auto bad = checkRange(joint.lowest, {-most, 0, unit}, "lowest")) return refuse(bad);
  if (auto bad = checkRange(joint.highest, {0, most, unit}, "highest")) return refuse(bad);
  joint.anchor_m = vectorFrom(message.anchor_m());
  joint.axis = vectorFrom(message.axis());
  return joint;
}

Result<PlaneProperties> planeFrom(const v1::Plane& message) {
  PlaneProperties plane{.normal = vectorFrom(message.normal()), .offset_m = message.offset_m()};
  if (auto bad = checkDirection(message.normal(), "normal")) return refuse(bad);
  if (auto bad = checkRange(message.offset_m(), {-kMaxCoordinate_m, kMaxCoordinate_m, " m"}, "offset_m")) {
    return refuse(bad);
  }
  if (message.has_friction()) plane.friction = message.friction();
  if (message.has_rolling_m()) plane.rolling_m = message.rolling_m();
  if (auto bad = checkRange(plane.friction, kFriction, "friction")) return refuse(bad);
  if (auto bad = checkRange(plane.rolling_m, kRolling, "rolling_m")) return refuse(bad);
  return plane;
}

Refusal addPlanes(const v1::Motion& message, MotionProperties& motion) {
  if (message.planes_size() > kMaxPlanesOfABody) {
    return Error{"planes", "has " + std::to_string(message.planes_size()) + " entries; a body rests on at most " +
                               std::to_string(kMaxPlanesOfABody)};
  }
  if (message.planes_size() > 0 && motion.joint) {
    return Error{"planes", "are given beside a joint, whose limits stop the body; give one of the two"};
  }
  for (int i = 0; i < message.planes_size(); ++i) {
    PlaneProperties& plane = motion.planes.emplace_back();
    if (auto bad = take(planeFrom(message.planes(i)), plane, "planes[" + std::to_string(i) + "].")) return bad;
  }
  return std::nullopt;
}

Result<CollisionProperties> collisionFrom(const v1::Collision& message) {
  CollisionProperties collision;
  if (message.has_friction()) collision.friction = message.friction();
  if (message.has_rolling_m()) collision.rolling_m = message.rolling_m();
  if (auto bad = checkRange(collision.friction, kFriction, "friction")) return refuse(bad);
  if (auto bad = checkRange(collision.rolling_m, kRolling, "rolling_m")) return refuse(bad);
  return collision;
}

/// What is fixed has nothing that only a body that moves has.
Refusal checkFixed(const v1::Motion& message) {
  if (!message.has_collision()) {
    return Error{"collision", "is missing beside `fixed`; give one (collision {}), or leave the motion out"};
  }
  v1::Motion rest = message;
  rest.clear_fixed();
  rest.clear_collision();
  if (rest.ByteSizeLong() == 0) return std::nullopt;
  return Error{"fixed", "is true beside what only moves a body; leave out all but `collision`, or `fixed`"};
}

/// The hand moves it, and nothing else does.
Refusal checkTool(const v1::Motion& message) {
  v1::Motion rest = message;
  rest.clear_tool();
  if (rest.ByteSizeLong() == 0) return std::nullopt;
  return Error{"tool", "is given beside what moves or meets by itself; leave out all but `tool`, or `tool`"};
}

Result<JawProperties> jawsFrom(const v1::Jaws& message) {
  JawProperties jaws{vectorFrom(message.hinge_m()), vectorFrom(message.axis()), vectorFrom(message.reach())};
  if (message.has_grip_nm_per_rad()) jaws.grip_Nm_per_rad = message.grip_nm_per_rad();
  if (auto bad = checkPosition(message.hinge_m(), "hinge_m")) return refuse(bad);
  if (auto bad = checkDirection(message.axis(), "axis")) return refuse(bad);
  if (auto bad = checkDirection(message.reach(), "reach")) return refuse(bad);
  constexpr double kRightAngle = 1e-3;
  if (std::abs(glm::dot(jaws.axis, jaws.reach)) > kRightAngle)
    return refused("reach", "is at no right angle to `axis`; it points from the hinge to the tips of the closed jaws");
  if (auto bad = checkAbove0(jaws.grip_Nm_per_rad, kTorsion, "grip_Nm_per_rad")) return refuse(bad);
  return jaws;
}

Result<ToolProperties> toolFrom(const v1::Tool& message) {
  ToolProperties tool{.spacing_m = message.spacing_m()};
  if (message.has_torsion_nm_per_rad()) tool.torsion_Nm_per_rad = message.torsion_nm_per_rad();
  if (auto bad = checkAbove0(tool.spacing_m, kSpacing, "spacing_m")) return refuse(bad);
  if (auto bad = checkAbove0(tool.torsion_Nm_per_rad, kTorsion, "torsion_Nm_per_rad")) return refuse(bad);
  if (message.has_jaws()) {
    if (auto bad = take(jawsFrom(message.jaws()), tool.jaws, "jaws.")) return refuse(bad);
  }
  return tool;
}

}  // namespace

Result<MotionProperties> announcedMotionFrom(const v1::Motion& message) {
  MotionProperties motion;
  if (message.has_tool()) {
    if (auto bad = checkTool(message)) return refuse(bad);
    if (auto bad = take(toolFrom(message.tool()), motion.tool, "tool.")) return refuse(bad);
    motion.gravity_m_per_s2 = Vec3(0);
    return motion;
  }
  if (message.has_collision()) {
    if (auto bad = take(collisionFrom(message.collision()), motion.collision, "collision.")) return refuse(bad);
  }
  motion.fixed = message.fixed();
  if (motion.fixed) {
    if (auto bad = checkFixed(message)) return refuse(bad);
    motion.gravity_m_per_s2 = Vec3(0);
    return motion;
  }
  motion.mass_kg = message.mass_kg();
  if (auto bad = checkAbove0(motion.mass_kg, kMass, "mass_kg")) return refuse(bad);
  if (message.has_inertia()) {
    if (auto bad = take(inertiaFrom(message.inertia()), motion.inertia, "inertia.")) return refuse(bad);
  }
  if (message.has_gravity_m_per_s2()) {
    if (auto bad = checkVector(message.gravity_m_per_s2(), kGravity, "gravity_m_per_s2")) return refuse(bad);
    motion.gravity_m_per_s2 = vectorFrom(message.gravity_m_per_s2());
  }
  motion.linearDamping_per_s = message.linear_damping_per_s();
  motion.angularDamping_per_s = message.angular_damping_per_s();
  if (auto bad = checkRange(motion.linearDamping_per_s, kDampingRate, "linear_damping_per_s")) return refuse(bad);
  if (auto bad = checkRange(motion.angularDamping_per_s, kDampingRate, "angular_damping_per_s")) return refuse(bad);
  if (auto bad = take(springFrom(message.spring()), motion.spring, "spring.")) return refuse(bad);
  using Kind = JointProperties::Kind;
  if (message.has_hinge()) {
    if (auto bad = take(jointFrom(message.hinge(), Kind::kHinge), motion.joint, "hinge.")) return refuse(bad);
  }
  if (message.has_slider()) {
    if (auto bad = take(jointFrom(message.slider(), Kind::kSlider), motion.joint, "slider.")) return refuse(bad);
  }
  if (auto bad = addPlanes(message, motion)) return refuse(bad);
  return motion;
}

Result<MotionProperties> motionFrom(const v1::Motion& message) {
  auto motion = announcedMotionFrom(message);
  if (!motion) return motion;
  if (motion->joint) motion->joint->axis = normalised(motion->joint->axis);
  for (PlaneProperties& plane : motion->planes) plane.normal = normalised(plane.normal);
  if (motion->tool && motion->tool->jaws) {
    JawProperties& jaws = *motion->tool->jaws;
    jaws.axis = normalised(jaws.axis);
    jaws.reach = normalised(jaws.reach);
  }
  return motion;
}

void toWire(const MotionProperties& motion, v1::Motion& message) {
  message.Clear();
  if (motion.tool) {
    message.mutable_tool()->set_spacing_m(motion.tool->spacing_m);
    message.mutable_tool()->set_torsion_nm_per_rad(motion.tool->torsion_Nm_per_rad);
    if (const auto& jaws = motion.tool->jaws) {
      v1::Jaws& to = *message.mutable_tool()->mutable_jaws();
      toWire(jaws->hinge_m, *to.mutable_hinge_m());
      toWire(jaws->axis, *to.mutable_axis());
      toWire(jaws->reach, *to.mutable_reach());
      to.set_grip_nm_per_rad(jaws->grip_Nm_per_rad);
    }
    return;
  }
  if (motion.collision) {
    message.mutable_collision()->set_friction(motion.collision->friction);
    message.mutable_collision()->set_rolling_m(motion.collision->rolling_m);
  }
  if (motion.fixed) {
    message.set_fixed(true);
    return;
  }
  message.set_mass_kg(motion.mass_kg);
  if (motion.inertia) {
    toWire(motion.inertia->centre_m, *message.mutable_inertia()->mutable_centre_m());
    toWire(motion.inertia->moments, *message.mutable_inertia()->mutable_moments());
    toWire(motion.inertia->products, *message.mutable_inertia()->mutable_products());
  }
  toWire(motion.gravity_m_per_s2, *message.mutable_gravity_m_per_s2());
  message.set_linear_damping_per_s(motion.linearDamping_per_s);
  message.set_angular_damping_per_s(motion.angularDamping_per_s);
  v1::PoseSpring& spring = *message.mutable_spring();
  spring.set_stiffness_n_per_m(motion.spring.stiffness_N_per_m);
  spring.set_damping_ns_per_m(motion.spring.damping_Ns_per_m);
  spring.set_stiffness_nm_per_rad(motion.spring.stiffness_Nm_per_rad);
  spring.set_damping_nms_per_rad(motion.spring.damping_Nms_per_rad);
  if (motion.joint) {
    const bool hinge = motion.joint->kind == JointProperties::Kind::kHinge;
    v1::Joint& joint = hinge ? *message.mutable_hinge() : *message.mutable_slider();
    toWire(motion.joint->anchor_m, *joint.mutable_anchor_m());
    toWire(motion.joint->axis, *joint.mutable_axis());
    joint.set_lowest(motion.joint->lowest);
    joint.set_highest(motion.joint->highest);
  }
  for (const PlaneProperties& of : motion.planes) {
    v1::Plane& plane = *message.add_planes();
    toWire(of.normal, *plane.mutable_normal());
    plane.set_offset_m(of.offset_m);
    plane.set_friction(of.friction);
    plane.set_rolling_m(of.rolling_m);
  }
}

}  // namespace haptics
